// taut render --display: packets that a tev viewer understands, and the same picture as in the file.

#include "view_server.h"

#include <map>

using namespace taut;
using namespace taut::test;

namespace {

/// One that listens where a viewer would, for one connection; keeps all that comes.
class Viewer {
  public:
    explicit Viewer(std::size_t most = std::string::npos) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof at;
        REQUIRE(bind(socket_, reinterpret_cast<sockaddr *>(&at), sizeof at) == 0); // NOLINT: POSIX
        REQUIRE(listen(socket_, 1) == 0);
        REQUIRE(getsockname(socket_, reinterpret_cast<sockaddr *>(&at), &size) == 0); // NOLINT: POSIX
        port = ntohs(at.sin_port);
        thread_ = std::thread([this, most] {
            const int client = accept(socket_, nullptr, nullptr);
            char block[4096];
            for (ssize_t n = 0; bytes_.size() < most && (n = recv(client, block, sizeof block, 0)) > 0;) bytes_.append(block, static_cast<std::size_t>(n));
            close(client);
        });
    }
    Viewer(const Viewer &) = delete;
    Viewer &operator=(const Viewer &) = delete;
    ~Viewer() {
        if (thread_.joinable()) {
            shutdown(socket_, SHUT_RDWR);
            thread_.join();
        }
        close(socket_);
    }
    [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port); }
    const std::string &bytes() {
        thread_.join();
        return bytes_;
    }
    unsigned short port = 0;

  private:
    int socket_;
    std::string bytes_;
    std::thread thread_;
};

/// Reads a packet's fields in turn.
struct Fields {
    const std::string &bytes;
    std::size_t at;
    template <class T> T number() {
        T value{};
        REQUIRE(at + sizeof value <= bytes.size());
        std::memcpy(&value, bytes.data() + at, sizeof value);
        at += sizeof value;
        return value;
    }
    std::string text() {
        const std::size_t end = bytes.find('\0', at);
        REQUIRE(end != std::string::npos);
        std::string value = bytes.substr(at, end - at);
        at = end + 1;
        return value;
    }
};

/// What a viewer has made of packets: images by name.
struct Shown {
    int width = 0, height = 0, updates = 0;
    std::vector<std::string> channels;
    std::vector<float> values;
};

std::map<std::string, Shown> shownBy(const std::string &bytes) {
    std::map<std::string, Shown> images;
    for (std::size_t begin = 0; begin < bytes.size();) {
        Fields fields{bytes, begin};
        const auto length = fields.number<std::uint32_t>();
        REQUIRE(begin + length <= bytes.size());
        const int kind = fields.number<std::uint8_t>();
        static_cast<void>(fields.number<std::uint8_t>());
        Shown &image = images[fields.text()];
        if (kind == 4) {
            image.width = fields.number<std::int32_t>();
            image.height = fields.number<std::int32_t>();
            for (int n = fields.number<std::int32_t>(); n > 0; --n) image.channels.push_back(fields.text());
            image.values.assign(static_cast<std::size_t>(image.width * image.height) * image.channels.size(), 0);
        } else {
            REQUIRE(kind == 6);
            ++image.updates;
            const auto count = fields.number<std::int32_t>();
            for (int c = 0; c < count; ++c) CHECK(fields.text() == image.channels.at(static_cast<std::size_t>(c)));
            const auto x = fields.number<std::int32_t>();
            const auto y = fields.number<std::int32_t>();
            const auto w = fields.number<std::int32_t>();
            const auto h = fields.number<std::int32_t>();
            for (int c = 0; c < count; ++c) CHECK(fields.number<std::int64_t>() == c);
            for (int c = 0; c < count; ++c) CHECK(fields.number<std::int64_t>() == count);
            for (int row = y; row < y + h; ++row)
                for (int i = 0; i < w * count; ++i)
                    image.values.at(static_cast<std::size_t>((row * image.width + x) * count + i)) = fields.number<float>();
        }
        CHECK(fields.at == begin + length);
        begin += length;
    }
    return images;
}

} // namespace

TEST_CASE("display: a viewer gets every frame, and at its end what the file has", "[view][cli]") {
    const Workplace place("display");
    Viewer viewer;
    requireSuccess(runTaut({"render", place.scene, "-q", "--frames", "1-2", "--display", viewer.address(), "-o", place.path("a.####.exr")}));
    const auto images = shownBy(viewer.bytes());
    REQUIRE(images.size() == 2);
    for (const int frame : {1, 2}) {
        const Image image = readImage(place.path("a.000" + std::to_string(frame) + ".exr"));
        const Shown &shown = images.at("plate.toml " + std::to_string(frame));
        CHECK(shown.width == 24);
        CHECK(shown.height == 16);
        CHECK(shown.updates > 0);
        CHECK(shown.channels == image.channels);
        CHECK(shown.values == image.values);
    }
}

TEST_CASE("display: a viewer that goes away is missed once, and the render goes on", "[view][cli]") {
    const Workplace place("display_gone");
    Viewer viewer(16);
    const CommandResult result = runTaut({"render", place.scene, "-q", "--frames", "1-3", "-D", "render.width=640", "-D", "render.height=480", "--display",
                                          viewer.address(), "-o", place.path("a.####.exr")});
    requireSuccess(result);
    CHECK(fs::exists(place.path("a.0003.exr")));
    CHECK(linesOf(result.err).size() == 1);
    CHECK(result.err.find("the viewer is gone; the render goes on") != std::string::npos);
}

TEST_CASE("display: an address that is none, or where nobody is, ends it before the work", "[view][cli]") {
    const Workplace place("display_bad");
    for (const char *address : {"127.0.0.1", ":14158", "127.0.0.1:", "127.0.0.1:x", "127.0.0.1:70000"})
        checkUsageError(runTaut({"render", place.scene, "--display", address, "-o", place.path("a.exr")}), "HOST:PORT");
    const CommandResult nobody = runTaut({"render", place.scene, "--display", "127.0.0.1:1", "-o", place.path("a.exr")});
    CHECK(nobody.exitCode == 1);
    CHECK(errorLine(nobody).find("no viewer listens there") != std::string::npos);
    CHECK_FALSE(fs::exists(place.path("a.exr")));
}
