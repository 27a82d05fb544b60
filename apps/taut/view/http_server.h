#pragma once
/// An HTTP/1.1 server of one thread for a program's own page, and for nobody else: what comes without the token in its path, with another
/// Host than this server's, from another Origin, or malformed, is refused before anybody looks at it. A connection has so long for a
/// request, however slowly it sends.

#include <functional>
#include <memory>
#include <string>

namespace taut::app {

struct HttpRequest {
    std::string method; ///< GET or POST
    std::string path;   ///< what stands after /TOKEN/, as it was sent
    std::string query;  ///< after ?
    std::string body;   ///< of a POST: JSON, as its Content-Type says
};

struct HttpResponse {
    unsigned status = 200;
    std::string type = "text/plain; charset=utf-8";
    std::string body{};
};

/// Sends the response; once, from any thread, now or later.
using HttpReply = std::function<void(HttpResponse)>;
/// Called on the server's thread.
using HttpHandler = std::function<void(const HttpRequest &, HttpReply)>;

struct HttpOptions {
    std::string host = "127.0.0.1"; ///< a numeric address
    unsigned short port = 0;        ///< 0: one that is free
    std::string token;              ///< first part of every path
    double secondsForRequest = 15;  ///< from the first wait for it to its last byte
    int connections = 64;           ///< at a time; more are closed
};

class HttpServer {
  public:
    /// Listens. Throws RunError where it can't.
    HttpServer(const HttpOptions &options, HttpHandler handler);
    ~HttpServer();
    HttpServer(const HttpServer &) = delete;
    HttpServer &operator=(const HttpServer &) = delete;

    [[nodiscard]] unsigned short port() const;
    /// http://HOST:PORT/TOKEN/
    [[nodiscard]] std::string url() const;
    /// Whether nobody outside this machine can reach it.
    [[nodiscard]] bool isLoopback() const;
    /// Serves until stop().
    void run();
    /// From any thread. Responses that are not sent yet are dropped.
    void stop();
    /// When what is answered now has had a moment to arrive. On the server's thread.
    void stopSoon();

    struct State;

  private:
    std::unique_ptr<State> state_;
};

/// 128 bits from the system, as 32 hexadecimal digits.
std::string randomToken();

} // namespace taut::app
