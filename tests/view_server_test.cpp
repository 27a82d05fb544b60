// taut view's server: who has no token, comes from elsewhere, or sends what is no request is refused, and the picture goes on.

#include "view_server.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

/// Whether the page still gets what it asks for.
void checkAlive(const ViewServer &server) {
    CHECK(server.get("state").status == 200);
    CHECK(server.get("picture?follows=1&after=0").status == 200);
}

} // namespace

TEST_CASE("view: the page and nothing else is served", "[view][cli]") {
    const Workplace place("view_page");
    const ViewServer server({place.scene});
    const HttpAnswer page = server.get("");
    CHECK(page.status == 200);
    CHECK(page.head.find("text/html") != std::string::npos);
    CHECK(page.head.find("Content-Security-Policy: default-src 'none'; script-src 'self'") != std::string::npos);
    // Every file that it and its modules name is there, as it stands in the source tree.
    const std::string folder = std::string(TAUT_SOURCE_DIR) + "/apps/taut/view/page";
    const std::vector<std::string> names = namesIn(folder);
    CHECK(names.size() > 8);
    for (const std::string &name : names) CHECK(server.get(name).body == readBytes(folder + "/" + name));
    for (const std::string path : {"plate.toml", "../plate.toml", "..%2fplate.toml", "/etc/passwd", "%2e%2e/", "./", "state/", "change", "index.html/..",
                                   "page/index.html", "state%00", "inspect", "picture", "picture?follows=1", "picture?follows=x&after=0"}) {
        INFO(path);
        const int status = server.get(path).status;
        CHECK((status == 404 || status == 400));
    }
}

TEST_CASE("view: without the token, with another Host or Origin, a request is refused", "[view][cli]") {
    const Workplace place("view_refused");
    const ViewServer server({place.scene});
    const std::string host = "Host: " + server.host() + "\r\n";
    const std::string path = "/" + server.token + "/state";
    const auto status = [&](const std::string &target, const std::string &headers) { return server.ask("GET", target, headers).status; };
    CHECK(status(path, host) == 200);
    CHECK(status(path, host + "Origin: http://" + server.host() + "\r\n") == 200);
    CHECK(status(path, "Host: localhost:" + std::to_string(server.port) + "\r\n") == 200);
    std::string other = server.token;
    other.back() = other.back() == '0' ? '1' : '0';
    for (const std::string &target : {std::string("/"), std::string("/state"), "/" + other + "/state", "/" + server.token, "/" + server.token + "0/state",
                                      "/" + server.token.substr(1) + "/state", std::string("//state"), "/x/../" + server.token + "/state",
                                      std::string("/favicon.ico")}) {
        INFO(target);
        CHECK(status(target, host) == 403);
    }
    for (const std::string headers : {"", "Host: evil.example\r\n", "Host: 127.0.0.1\r\n", "Host: 127.0.0.1:1\r\n", "Host: 127.0.0.1.evil.example:1\r\n",
                                      "Host: [::1]\r\n"}) {
        INFO(headers);
        CHECK(status(path, headers) == 403);
    }
    CHECK(status(path, host + host) != 200);
    CHECK(status(path, "Host: evil.example:" + std::to_string(server.port) + "\r\n") == 403);
    for (const std::string origin : {"null", "http://evil.example", "https://127.0.0.1", "http://127.0.0.1", "file://"}) {
        INFO(origin);
        CHECK(status(path, host + "Origin: " + origin + "\r\n") == 403);
    }
    // What a form of another page could send is no change.
    CHECK(server.ask("POST", "/" + server.token + "/change", host + "Content-Type: text/plain\r\n", "{\"frame\":1}").status == 415);
    CHECK(server.ask("PUT", path, host).status == 405);
    CHECK(server.ask("POST", "/" + server.token + "/change", host + "Content-Type: application/json\r\n", "{").status == 400);
    checkAlive(server);
}

TEST_CASE("view: it listens to this machine alone, unless --host says otherwise, which it warns of", "[view][cli]") {
    const Workplace place("view_host");
    {
        const ViewServer server({place.scene});
        char port[8];
        std::snprintf(port, sizeof port, "%04X", static_cast<unsigned>(server.port));
        int listening = 0;
        for (const std::string &line : linesOf(readBytes("/proc/" + std::to_string(server.process()) + "/net/tcp"))) {
            if (line.find(std::string(":") + port + " 00000000:0000 0A") == std::string::npos) continue;
            CHECK(line.find("0100007F:") != std::string::npos);
            ++listening;
        }
        CHECK(listening == 1);
        CHECK(server.errors().empty());
    }
    checkUsageError(runTaut({"view", place.scene, "--no-open", "--host", "evil"}), "a numeric address");
    const Workplace missing("view_missing");
    checkUsageError(runTaut({"view", missing.path("none.toml"), "--no-open"}), "none.toml");
    // Another address is warned of; nobody need be waited for to see that.
    const CommandResult open = runProgram({"timeout", "-s", "INT", "5", TAUT_COMMAND, "view", place.scene, "--no-open", "--host", "0.0.0.0"}, 60);
    CHECK(open.err.find("taut: warning: --host 0.0.0.0") == 0);
}

TEST_CASE("view: it ends by a signal and when the page says so; with its token file the address stays", "[view][cli]") {
    const Workplace place("view_end");
    const std::string tokens = place.path("token");
    std::string url;
    unsigned short port = 0;
    {
        ViewServer server({place.scene, "--token-file", tokens});
        url = server.url;
        port = server.port;
        CHECK(fs::status(tokens).permissions() == (fs::perms::owner_read | fs::perms::owner_write));
        CHECK(server.end(SIGINT) == 0);
    }
    {
        ViewServer server({place.scene, "--token-file", tokens, "--port", std::to_string(port)});
        CHECK(server.url == url);
        CHECK(server.post("quit", nlohmann::json::object()).status == 200);
        CHECK(server.end(0) == 0);
    }
    writeBytes(tokens, "short");
    checkUsageError(runTaut({"view", place.scene, "--no-open", "--token-file", tokens}), "16 to 128 hexadecimal digits");
}

TEST_CASE("view: a hundred thousand malformed requests are refused, and the picture goes on", "[view][cli]") {
    const Workplace place("view_malformed");
    const ViewServer server({place.scene});
    const std::string good = "POST /" + server.token + "/change HTTP/1.1\r\nHost: " + server.host() +
                             "\r\nContent-Type: application/json\r\nContent-Length: 58\r\n\r\n"
                             "{\"changes\":[{\"key\":\"material.brushed.alpha\",\"value\":0.25}]}";
    std::mt19937 random(1);
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    int sent = 0;
    int refused = 0;
    while (sent < 100000) {
        const Client client(server.port, 30, true);
        REQUIRE(client.isOpen());
        std::string text = good;
        for (std::size_t n = 1 + below(8); n > 0; --n) {
            const std::size_t at = below(text.size());
            switch (below(4)) {
            case 0: text[at] = static_cast<char>(random()); break;
            case 1: text.erase(at, 1 + below(20)); break;
            case 2: text.insert(at, text.substr(below(text.size()), below(40))); break;
            default: text.insert(at, std::string(below(3), static_cast<char>(random())));
            }
            if (text.empty()) text = "x";
        }
        client.send(text);
        client.shutdownSend();
        const int status = ViewServer::answerOf(client.receive()).status;
        refused += status != 200 ? 1 : 0;
        ++sent;
    }
    CHECK(refused > sent / 2); // a change of a digit may leave a request what it was
    checkAlive(server);
}

TEST_CASE("view: malformed requests of every kind are refused, and the picture goes on", "[view][cli]") {
    const Workplace place("view_broken");
    const ViewServer server({place.scene});
    const std::string target = "/" + server.token + "/change";
    const std::string host = "Host: " + server.host() + "\r\n";
    const auto answered = [&](const std::string &text) {
        const Client client(server.port, 30);
        client.send(text);
        client.shutdownSend();
        return ViewServer::answerOf(client.receive()).status;
    };
    CHECK(answered("\r\n\r\n") != 200);
    CHECK(answered("GET\r\n\r\n") == 400);
    CHECK(answered("GET /" + std::string(100000, 'a') + " HTTP/1.1\r\n" + host + "\r\n") == 400);
    CHECK(answered("GET " + target + " HTTP/1.1\r\n" + host + std::string(3000, 'x') + ": " + std::string(30000, 'y') + "\r\n\r\n") == 400);
    CHECK(answered("POST " + target + " HTTP/1.1\r\n" + host + "Content-Type: application/json\r\nContent-Length: 99999999999\r\n\r\n{}") == 400);
    CHECK(answered("POST " + target + " HTTP/1.1\r\n" + host + "Content-Type: application/json\r\nContent-Length: -1\r\n\r\n{}") == 400);
    CHECK(answered("POST " + target + " HTTP/1.1\r\n" + host + "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n") == 400);
    CHECK(answered(std::string("\0\1\2\3\xff\xfe", 6)) != 200);
    const std::string deep(200000, '[');
    CHECK(server.ask("POST", target, host + "Content-Type: application/json\r\n", deep).status == 400);
    CHECK(server.ask("POST", target, host + "Content-Type: application/json\r\n", "{\"changes\":" + std::string(5000, '[') + std::string(5000, ']') + "}").status == 400);
    const std::string nested = std::string(3000, '[') + "1" + std::string(3000, ']');
    CHECK(server.ask("POST", target, host + "Content-Type: application/json\r\n", R"({"changes":[{"key":"material.brushed.alpha","value":)" + nested + "}]}").status == 400);
    checkAlive(server);
}

TEST_CASE("view: clients that send a byte a second keep nobody else waiting, and are let go", "[view][cli]") {
    const Workplace place("view_slow");
    const ViewServer server({place.scene});
    std::vector<std::unique_ptr<Client>> slow;
    for (int i = 0; i < 40; ++i) slow.push_back(std::make_unique<Client>(server.port, 60));
    const std::string text = "GET /" + server.token + "/state HTTP/1.1\r\nHost: 127.0.0.1\r\nX: yyyyyyyyyyyyyyyyyyyyyyyyy";
    for (std::size_t second = 0; second < 3; ++second) {
        for (const auto &client : slow) client->send(text.substr(second, 1));
        checkAlive(server);
        std::this_thread::sleep_for(std::chrono::seconds(1));
    }
    // The server waits for a request fifteen seconds, however they come.
    CHECK(slow.front()->isEnded());
    CHECK(slow.back()->isEnded());
    checkAlive(server);
}
