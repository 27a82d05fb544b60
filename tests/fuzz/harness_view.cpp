/// What comes over the wire to `taut view`: requests, and the changes of a scene that they bring.

#include "harness.h"
#include "harness_list.h"

#include "taut/formats/write_mesh.h"
#include "taut/mesh/shapes.h"
#include "taut/scene/load_scene.h"
#include "taut/view/http_server.h"
#include "taut/view/panel.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace taut::fuzz {

namespace {

const std::string kToken = "0123456789abcdef0123456789abcdef";

/// A server as the command has it, whose answers tell what was let through.
class Server {
  public:
    Server()
        : server_(options(), [this](const app::HttpRequest &request, const app::HttpReply &reply) {
              ++let_;
              reply({200, "text/plain", request.method + " " + request.path});
          }) {
        std::thread([this] { server_.run(); }).detach(); // for as long as the process lives
    }
    [[nodiscard]] unsigned short port() const { return server_.port(); }
    [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(port()); }
    /// Requests that were let through so far.
    [[nodiscard]] int let() const { return let_; }

    /// All that is answered to these bytes, after which no more come.
    [[nodiscard]] std::string answer(std::string_view bytes) const {
        const int client = socket(AF_INET, SOCK_STREAM, 0);
        require(client >= 0, "a socket");
        const timeval limit{10, 0};
        setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        const linger now{1, 0}; // its port can be used again at once
        setsockopt(client, SOL_SOCKET, SO_LINGER, &now, sizeof now);
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port());
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        require(connect(client, reinterpret_cast<const sockaddr *>(&to), sizeof to) == 0, "the server takes connections"); // NOLINT: POSIX
        while (!bytes.empty()) {
            const ssize_t sent = send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (sent <= 0) break;
            bytes.remove_prefix(static_cast<std::size_t>(sent));
        }
        shutdown(client, SHUT_WR);
        std::string all;
        char block[4096];
        for (ssize_t n = 0; (n = recv(client, block, sizeof block, 0)) > 0;) all.append(block, static_cast<std::size_t>(n));
        close(client);
        return all;
    }

  private:
    static app::HttpOptions options() {
        app::HttpOptions options;
        options.token = kToken;
        options.secondsForRequest = 2;
        return options;
    }
    std::atomic<int> let_ = 0;
    app::HttpServer server_;
};

const Server &theServer() {
    static const Server *const server = new Server;
    return *server;
}

std::string request(const std::string &head, const std::string &body = {}) {
    return head + " HTTP/1.1\r\nHost: " + theServer().host() +
           "\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

constexpr const char *kScene = R"([render]
width = 16
height = 9
frames = "1-3"
[camera]
position = [0, -3, 2]
look_at = [[1, [0, 0, 0]], [3, [0, 0, 1]]]
[material.brushed]
type = "conductor"
metal = "Al"
alpha = [0.1, 0.3]
[[light]]
type = "point"
position = [1, 1, 2]
intensity = 5
[[mesh]]
file = "torus.obj"
material = "brushed"
[[mesh.deform]]
type = "twist"
angle_deg = [[1, 0], [3, 90]]
)";

app::SceneChanges::Overrides sorted(app::SceneChanges::Overrides overrides) {
    std::sort(overrides.begin(), overrides.end());
    return overrides;
}

} // namespace

/// The port is the process's own: PORT in an input stands for it.
void runHttp(std::string_view bytes) {
    const Server &server = theServer();
    std::string text(bytes);
    for (std::size_t at = 0; (at = text.find("PORT", at)) != std::string::npos;) text.replace(at, 4, std::to_string(server.port()));
    const int before = server.let();
    const std::string answer = server.answer(text);
    const int let = server.let() - before;
    require(answer.empty() || answer.rfind("HTTP/1.1 ", 0) == 0, "what is answered is HTTP");
    require(let == 0 || text.find("/" + kToken + "/") != std::string::npos, "nobody without the token is let through");
    require(let == 0 || text.find(server.host()) != std::string::npos || text.find("localhost:") != std::string::npos,
            "nor for another host");
    static int runs = 0;
    if (++runs % 256 == 1)
        require(server.answer(request("GET /" + kToken + "/state")).find("GET state") != std::string::npos, "the server goes on");
}

void runChange(std::string_view bytes) {
    static const std::string scene = [] {
        writeObj(makeTorus(6, 5, 0.7F, 0.25F), scratchFolder() + "/torus.obj");
        return scratchFile("view.toml", kScene);
    }();
    const nlohmann::json body = nlohmann::json::parse(bytes, nullptr, false);
    if (!body.is_array()) return;
    Warnings warnings;
    app::SceneArguments arguments;
    arguments.scene = scene;
    app::SceneChanges changes(arguments, warnings);
    const app::SceneChanges::Overrides none = changes.changed();
    survive([&] {
        nlohmann::json undo;
        try {
            undo = changes.apply(body, 2);
        } catch (const InputError &) {
            require(changes.changed() == none, "what is refused changes nothing");
            throw;
        }
        const app::SceneChanges::Overrides made = sorted(changes.changed());
        static_cast<void>(app::panelOf(changes, 2));
        static_cast<void>(app::cameraOf(changes.scene(), 2));
        const std::string saved = scratchFile("again.toml", changes.sceneText());
        const Scene again = loadScene(saved, {}, warnings);
        require(again.objects.size() == changes.scene().objects.size(), "what is saved is the scene");
        const nlohmann::json redo = changes.apply(undo, 2);
        require(changes.changed() == none, "undo takes all back");
        changes.apply(redo, 2);
        require(sorted(changes.changed()) == made, "and redo brings it again");
    });
}

std::vector<std::string> httpSeeds() {
    const std::string host = "\r\nHost: 127.0.0.1:PORT\r\n";
    const std::string path = "/" + kToken + "/";
    return {"GET " + path + "state HTTP/1.1" + host + "\r\n",
            "GET " + path + "picture?follows=1&after=0 HTTP/1.1" + host + "Origin: http://127.0.0.1:PORT\r\n\r\nGET " + path + " HTTP/1.1" +
                host + "\r\n",
            "POST " + path + "change HTTP/1.1" + host + "Content-Type: application/json\r\nContent-Length: 14\r\n\r\n{\"changes\":[]}",
            "POST " + path + "save HTTP/1.1" + host +
                "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n4;x=y\r\n{\"a\"\r\n3\r\n:1}\r\n0\r\n\r\n",
            "GET / HTTP/1.0\r\nHost: evil.example\r\nConnection: keep-alive\r\n\r\n",
            "GET http://localhost:PORT" + path + " HTTP/1.1" + host + "Expect: 100-continue\r\n\r\n"};
}

std::vector<std::string> changeSeeds() {
    return {
        R"([{"key":"material.brushed.alpha","value":0.25}])",
        R"([{"key":"mesh.0.deform.0.angle_deg","value":30,"atFrame":true},{"key":"mesh.0.follow","value":false}])",
        R"([{"key":"camera","value":{"position":[0,-2,1],"look_at":[0,0,0],"up":[0,0,1],"fov_deg":30,"aperture_radius":0.01,"focus_distance":2}}])",
        R"([{"key":"light.0.intensity","text":"[1, 2, 3]"},{"key":"environment.radiance","value":[0.1,0.2,0.3]}])",
        R"([{"key":"render.width","value":32},{"key":"render.width","value":null},{"key":"material.new","text":"{type = \"diffuse\"}"}])"};
}

} // namespace taut::fuzz
