#pragma once
/// `taut view` as a child process, and a plain HTTP client that can also send what is none.

#include "cli_fixtures.h"

#include <arpa/inet.h>
#include <csignal>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <regex>
#include <thread>

namespace taut::test {

struct HttpAnswer {
    int status = 0; ///< 0: the connection was closed without one
    std::string head;
    std::string body;
    [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(body); }
};

/// One connection to this machine; closed at the end.
class Client {
  public:
    /// `forgets`: its port can be used again at once.
    explicit Client(unsigned short port, int timeoutSeconds = 120, bool forgets = false) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        const timeval limit{timeoutSeconds, 0};
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        const linger now{1, 0};
        if (forgets) setsockopt(socket_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
        isOpen_ = ::connect(socket_, reinterpret_cast<const sockaddr *>(&to), sizeof to) == 0; // NOLINT: POSIX
    }
    Client(const Client &) = delete;
    Client &operator=(const Client &) = delete;
    ~Client() { ::close(socket_); }

    [[nodiscard]] bool isOpen() const { return isOpen_; }
    /// False where the other side has closed.
    bool send(std::string_view bytes) const {
        while (!bytes.empty()) {
            const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (n <= 0) return false;
            bytes.remove_prefix(static_cast<std::size_t>(n));
        }
        return true;
    }
    /// All that comes until the other side closes, or nothing comes any more.
    [[nodiscard]] std::string receive() const {
        std::string all;
        char block[65536];
        for (ssize_t n = 0; (n = recv(socket_, block, sizeof block, 0)) > 0;) all.append(block, static_cast<std::size_t>(n));
        return all;
    }
    /// Whether nothing more will come: the other side has closed.
    [[nodiscard]] bool isEnded() const {
        char byte = 0;
        const ssize_t n = recv(socket_, &byte, 1, 0);
        return n == 0 || (n < 0 && errno != EAGAIN);
    }
    void shutdownSend() const { shutdown(socket_, SHUT_WR); }

  private:
    int socket_;
    bool isOpen_ = false;
};

class ViewServer {
  public:
    explicit ViewServer(const Arguments &arguments) {
        int ends[2];
        REQUIRE(pipe(ends) == 0);
        Arguments words{TAUT_COMMAND, "view", "--no-open"};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<char *> argv;
        for (std::string &word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, err_.descriptor(), STDERR_FILENO);
        posix_spawn_file_actions_addclose(&actions, ends[0]);
        REQUIRE(posix_spawn(&process_, argv[0], &actions, nullptr, argv.data(), environ) == 0);
        posix_spawn_file_actions_destroy(&actions);
        ::close(ends[1]);
        for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) url += c;
        ::close(ends[0]);
        INFO(err_.text());
        std::smatch match;
        REQUIRE(std::regex_match(url, match, std::regex(R"(http://127\.0\.0\.1:(\d+)/([0-9a-f]{32})/)")));
        port = static_cast<unsigned short>(std::stoi(match[1]));
        token = match[2];
    }
    ViewServer(const ViewServer &) = delete;
    ViewServer &operator=(const ViewServer &) = delete;
    ~ViewServer() {
        if (process_ > 0) end(SIGKILL);
    }

    std::string url, token;
    unsigned short port = 0;

    /// Sends the signal and waits: the exit code, minus the signal's number where that ended it.
    int end(int signal) {
        if (signal != 0) kill(process_, signal);
        int status = 0;
        waitpid(std::exchange(process_, 0), &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
    [[nodiscard]] std::string errors() const { return err_.text(); }
    [[nodiscard]] pid_t process() const { return process_; }

    [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(port); }
    /// A request with these header lines, each with its end.
    [[nodiscard]] HttpAnswer ask(const std::string &method, const std::string &target, const std::string &headers,
                                 const std::string &body = "") const {
        const Client client(port);
        client.send(method + " " + target + " HTTP/1.1\r\nConnection: close\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" +
                    headers + "\r\n" + body);
        return answerOf(client.receive());
    }
    [[nodiscard]] HttpAnswer get(const std::string &path) const { return ask("GET", "/" + token + "/" + path, "Host: " + host() + "\r\n"); }
    [[nodiscard]] HttpAnswer post(const std::string &path, const nlohmann::json &body) const {
        return ask("POST", "/" + token + "/" + path, "Host: " + host() + "\r\nContent-Type: application/json\r\n", body.dump());
    }

    static HttpAnswer answerOf(const std::string &text) {
        HttpAnswer answer;
        const std::size_t end = text.find("\r\n\r\n");
        if (end == std::string::npos || text.rfind("HTTP/1.1 ", 0) != 0) return answer;
        answer.status = std::stoi(text.substr(9, 3));
        answer.head = text.substr(0, end);
        answer.body = text.substr(end + 4);
        return answer;
    }

  private:
    Capture err_;
    pid_t process_ = 0;
};

/// A picture as it travels (apps/taut/view/picture.h).
struct SeenPicture {
    std::uint32_t number = 0, version = 0, columns = 0, rows = 0, width = 0, height = 0, samples = 0, channels = 0;
    bool follows = false, done = false;
    float milliseconds = 0;
    std::vector<std::uint16_t> halves;
};

inline SeenPicture seenPicture(const std::string &body) {
    std::uint32_t words[16];
    REQUIRE(body.size() >= sizeof words);
    std::memcpy(words, body.data(), sizeof words);
    REQUIRE(body.substr(0, 4) == "TAUT");
    SeenPicture p{words[1], words[2], words[5], words[6], words[7], words[8], words[9], words[12], words[4] != 0, words[11] != 0, 0, {}};
    std::memcpy(&p.milliseconds, &words[13], 4);
    p.halves.resize((body.size() - sizeof words) / 2);
    std::memcpy(p.halves.data(), body.data() + sizeof words, 2 * p.halves.size());
    REQUIRE(p.halves.size() == std::size_t{p.columns} * p.rows * p.channels);
    return p;
}

/// Waits for the whole picture of at least that version.
inline SeenPicture wholePicture(const ViewServer &server, std::uint32_t version, bool follows = true) {
    std::uint32_t after = 0;
    for (int i = 0; i < 300; ++i) {
        const HttpAnswer answer = server.get("picture?follows=" + std::string(follows ? "1" : "0") + "&after=" + std::to_string(after));
        if (answer.status == 204) continue;
        REQUIRE(answer.status == 200);
        SeenPicture picture = seenPicture(answer.body);
        after = picture.number;
        if (picture.done && picture.version >= version) return picture;
    }
    FAIL("no whole picture came");
    return {};
}

} // namespace taut::test
