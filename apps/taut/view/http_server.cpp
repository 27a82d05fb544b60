#include "http_server.h"

#include "taut/base/error.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <optional>

namespace taut::app {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Tcp = asio::ip::tcp;

constexpr std::uint32_t kMostHeader = 16 * 1024;
constexpr std::uint64_t kMostBody = 1024 * 1024;
constexpr auto kWriteTime = std::chrono::seconds(30);
constexpr auto kAcceptAgain = std::chrono::milliseconds(100);

/// In time that depends on their lengths alone.
bool isSame(std::string_view a, std::string_view b) {
    if (a.size() != b.size()) return false;
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
    return difference == 0;
}

std::string_view text(beast::string_view s) {
    return {s.data(), s.size()};
}

/// HOST of HOST:PORT, without the brackets of IPv6; empty where the port is another.
std::string hostOf(std::string_view header, unsigned short port) {
    const std::string suffix = ":" + std::to_string(port);
    if (header.size() <= suffix.size() || header.substr(header.size() - suffix.size()) != suffix) return {};
    header.remove_suffix(suffix.size());
    if (header.size() > 2 && header.front() == '[' && header.back() == ']') header = header.substr(1, header.size() - 2);
    return std::string(header);
}

} // namespace

struct HttpServer::State {
    State(const HttpOptions &options_, HttpHandler handler_) : options(options_), handler(std::move(handler_)) {}

    HttpOptions options;
    HttpHandler handler;
    int open = 0; ///< connections; these go with the context
    asio::io_context context{1};
    Tcp::acceptor acceptor{context};
    asio::steady_timer again{context};
    asio::ip::address address;
    unsigned short port = 0;

    /// A name that others may make point here (DNS rebinding) is none of ours; an address, or this machine's own name, is.
    [[nodiscard]] bool isOurHost(std::string_view header) const {
        const std::string host = hostOf(header, port);
        if (host == "localhost" || host == address.to_string()) return true;
        if (address.is_loopback()) return false;
        boost::system::error_code error;
        asio::ip::make_address(host, error);
        std::array<char, 256> name{};
        return !error || (gethostname(name.data(), name.size() - 1) == 0 && host == name.data());
    }

    void accept();
};

namespace {

/// One client; lives as long as something is to be read or sent.
class Connection : public std::enable_shared_from_this<Connection> {
  public:
    Connection(Tcp::socket socket, HttpServer::State &server) : stream_(std::move(socket)), server_(server) { ++server_.open; }
    Connection(const Connection &) = delete;
    Connection &operator=(const Connection &) = delete;
    ~Connection() { --server_.open; }

    void read() {
        parser_.emplace();
        parser_->header_limit(kMostHeader);
        parser_->body_limit(kMostBody);
        stream_.expires_after(std::chrono::milliseconds(static_cast<long>(1000 * server_.options.secondsForRequest)));
        http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](beast::error_code error, std::size_t) { self->onRead(error); });
    }

  private:
    void onRead(beast::error_code error) {
        if (error == http::error::end_of_stream || error == beast::error::timeout || error == asio::error::operation_aborted ||
            error == asio::error::connection_reset)
            return;
        keepAlive_ = !error && parser_->get().keep_alive();
        if (error) return write({400, "text/plain; charset=utf-8", "malformed request\n"});
        const http::request<http::string_body> &request = parser_->get();
        if (const char *reason = refusal(request)) return write({403, "text/plain; charset=utf-8", std::string(reason) + "\n"});
        if (request.method() != http::verb::get && request.method() != http::verb::post)
            return write({405, "text/plain; charset=utf-8", "GET or POST\n"});
        if (request.method() == http::verb::post && text(request[http::field::content_type]).rfind("application/json", 0) != 0)
            return write({415, "text/plain; charset=utf-8", "Content-Type: application/json\n"});
        std::string_view target = text(request.target()).substr(server_.options.token.size() + 2);
        const std::size_t mark = std::min(target.find('?'), target.size());
        HttpRequest asked{std::string(text(request.method_string())), std::string(target.substr(0, mark)),
                          std::string(target.substr(std::min(mark + 1, target.size()))), request.body()};
        stream_.expires_never(); // while the answer is waited for
        server_.handler(asked, [self = shared_from_this()](HttpResponse response) {
            auto shared = std::make_shared<HttpResponse>(std::move(response));
            asio::post(self->stream_.get_executor(), [self, shared] { self->write(std::move(*shared)); });
        });
    }

    /// Why a request is nobody's who got the address from us; null: it may be.
    [[nodiscard]] const char *refusal(const http::request<http::string_body> &request) const {
        if (request.count(http::field::host) != 1 || !server_.isOurHost(text(request[http::field::host]))) return "another host";
        const auto origin = request.find(http::field::origin);
        if (origin != request.end() && text(origin->value()) != "http://" + std::string(text(request[http::field::host]))) return "another origin";
        const std::string_view target = text(request.target());
        const std::string &token = server_.options.token;
        const bool whole = target.size() >= token.size() + 2 && target[0] == '/' && target[token.size() + 1] == '/';
        return whole && isSame(target.substr(1, token.size()), token) ? nullptr : "no token";
    }

    void write(HttpResponse response) {
        response_ = {};
        response_.version(11);
        response_.result(response.status);
        response_.set(http::field::content_type, response.type);
        response_.set(http::field::cache_control, "no-store");
        response_.set("X-Content-Type-Options", "nosniff");
        response_.set("Referrer-Policy", "no-referrer");
        response_.set("Cross-Origin-Resource-Policy", "same-origin");
        response_.set("Content-Security-Policy",
                      "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data: blob:; "
                      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
        response_.keep_alive(keepAlive_);
        response_.body() = std::move(response.body);
        response_.prepare_payload();
        stream_.expires_after(kWriteTime);
        http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code error, std::size_t) {
            if (!error && self->keepAlive_) return self->read();
            beast::error_code ignored;
            self->stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
        });
    }

    beast::tcp_stream stream_;
    HttpServer::State &server_;
    beast::flat_buffer buffer_{kMostHeader + kMostBody};
    std::optional<http::request_parser<http::string_body>> parser_;
    http::response<http::string_body> response_;
    bool keepAlive_ = false;
};

} // namespace

void HttpServer::State::accept() {
    acceptor.async_accept([this](beast::error_code error, Tcp::socket socket) {
        if (error == asio::error::operation_aborted) return;
        if (error) { // out of file descriptors, say
            again.expires_after(kAcceptAgain);
            return again.async_wait([this](beast::error_code) { accept(); });
        }
        if (open < options.connections) std::make_shared<Connection>(std::move(socket), *this)->read();
        accept();
    });
}

HttpServer::HttpServer(const HttpOptions &options, HttpHandler handler) : state_(std::make_unique<State>(options, std::move(handler))) {
    boost::system::error_code error;
    state_->address = asio::ip::make_address(options.host, error);
    if (error) failInput({"--host"}, quoted(options.host), "a numeric address such as 127.0.0.1");
    try {
        const Tcp::endpoint endpoint(state_->address, options.port);
        state_->acceptor.open(endpoint.protocol());
        state_->acceptor.set_option(asio::socket_base::reuse_address(true));
        state_->acceptor.bind(endpoint);
        state_->acceptor.listen();
        state_->port = state_->acceptor.local_endpoint().port();
    } catch (const boost::system::system_error &failure) {
        throw RunError(options.host + ":" + std::to_string(options.port) + ": can't be listened at (" + failure.code().message() + ")");
    }
    state_->accept();
}

HttpServer::~HttpServer() {
    stop();
}

unsigned short HttpServer::port() const {
    return state_->port;
}

std::string HttpServer::url() const {
    const std::string host = state_->address.is_v6() ? "[" + state_->address.to_string() + "]" : state_->address.to_string();
    return "http://" + host + ":" + std::to_string(state_->port) + "/" + state_->options.token + "/";
}

bool HttpServer::isLoopback() const {
    return state_->address.is_loopback();
}

void HttpServer::run() {
    state_->context.run();
}

void HttpServer::stop() {
    state_->context.stop();
}

void HttpServer::stopSoon() {
    auto timer = std::make_shared<asio::steady_timer>(state_->context, std::chrono::milliseconds(200));
    timer->async_wait([state = state_.get(), timer](beast::error_code) { state->context.stop(); });
}

std::string randomToken() {
    std::array<unsigned char, 16> bytes{};
    if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) throw RunError("no random numbers from the system");
    std::string out;
    for (const unsigned char b : bytes)
        for (const int digit : {b >> 4, b & 15}) out += "0123456789abcdef"[digit];
    return out;
}

} // namespace taut::app
