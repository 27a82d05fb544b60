#include "tev_display.h"

#include "taut/base/error.h"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <iostream>
#include <memory>

namespace taut::app {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are sent as they lie in memory");

constexpr char kCreateImage = 4;
constexpr char kUpdateImage = 6;
constexpr auto kUpdateInterval = std::chrono::milliseconds(500);
/// A viewer that takes nothing for so long is gone.
constexpr timeval kPatience{10, 0};
/// A part of an image goes in one packet of about so many floats.
constexpr int kFloatsAPacket = 1 << 18;

template <class T> void put(std::string &packet, T value) {
    packet.append(reinterpret_cast<const char *>(&value), sizeof value); // NOLINT: its bytes
}
void putText(std::string &packet, const std::string &text) {
    packet.append(text.c_str(), text.size() + 1);
}

/// With room for its length.
std::string packetOf(char kind, bool grabFocus, const std::string &name) {
    std::string packet(4, '\0');
    packet += kind;
    packet += static_cast<char>(grabFocus);
    putText(packet, name);
    return packet;
}

int connectTo(const std::string &host, const std::string &port) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo *found = nullptr;
    if (getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return -1;
    const std::unique_ptr<addrinfo, void (*)(addrinfo *)> all(found, freeaddrinfo);
    for (const addrinfo *a = all.get(); a != nullptr; a = a->ai_next) {
        const int s = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
        if (s < 0) continue;
        if (connect(s, a->ai_addr, a->ai_addrlen) == 0) {
            setsockopt(s, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
            return s;
        }
        close(s);
    }
    return -1;
}

} // namespace

TevDisplay::TevDisplay(const std::string &address) : address_(address) {
    const std::size_t colon = address.rfind(':');
    const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
    std::string host = address.substr(0, std::min(colon, address.size()));
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
    const bool isPort =
        !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos && std::stoi(port) <= 65535;
    if (host.empty() || !isPort) failInput({"--display"}, quoted(address), "HOST:PORT such as 127.0.0.1:14158");
    socket_ = connectTo(host, port);
    if (socket_ < 0) throw RunError("--display " + address + ": no viewer listens there");
}

TevDisplay::~TevDisplay() {
    if (socket_ >= 0) close(socket_);
}

void TevDisplay::send(std::string packet) {
    if (socket_ < 0) return;
    const auto length = static_cast<std::uint32_t>(packet.size());
    std::memcpy(packet.data(), &length, sizeof length);
    for (std::size_t sent = 0; sent < packet.size();) {
        const ssize_t n = ::send(socket_, packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) {
            std::cerr << "taut: warning: --display " << address_ << ": the viewer is gone; the render goes on" << std::endl;
            close(socket_);
            socket_ = -1;
            return;
        }
        sent += static_cast<std::size_t>(n);
    }
}

void TevDisplay::create(const std::string &name, int width, int height, const std::vector<std::string> &channels) {
    std::string packet = packetOf(kCreateImage, true, name);
    put<std::int32_t>(packet, width);
    put<std::int32_t>(packet, height);
    put(packet, static_cast<std::int32_t>(channels.size()));
    for (const std::string &channel : channels) putText(packet, channel);
    send(std::move(packet));
}

void TevDisplay::update(const std::string &name, const Film &film) {
    if (socket_ < 0) return;
    const Window &window = film.window();
    const std::vector<std::string> channels = film.channelNames();
    const std::vector<float> values = film.resolve();
    const auto count = static_cast<int>(channels.size());
    const auto rowFloats = static_cast<std::size_t>(window.width()) * channels.size();
    const int rows = std::max(1, kFloatsAPacket / static_cast<int>(std::max<std::size_t>(rowFloats, 1)));
    for (int y = 0; y < window.height(); y += rows) {
        const int height = std::min(rows, window.height() - y);
        std::string packet = packetOf(kUpdateImage, false, name);
        put<std::int32_t>(packet, count);
        for (const std::string &channel : channels) putText(packet, channel);
        for (const int number : {window.x0, window.y0 + y, window.width(), height}) put<std::int32_t>(packet, number);
        for (int c = 0; c < count; ++c) put<std::int64_t>(packet, c);
        for (int c = 0; c < count; ++c) put<std::int64_t>(packet, count);
        const float *first = values.data() + static_cast<std::size_t>(y) * rowFloats;
        packet.append(reinterpret_cast<const char *>(first), sizeof(float) * rowFloats * static_cast<std::size_t>(height)); // NOLINT: bytes
        send(std::move(packet));
    }
}

DisplayFeed::DisplayFeed(TevDisplay *display, std::string name, std::function<Film()> film)
    : display_(display), name_(std::move(name)), film_(std::move(film)) {
    if (display_ == nullptr) return;
    thread_ = std::thread([this] {
        std::unique_lock lock(mutex_);
        while (!ended_.wait_for(lock, kUpdateInterval, [this] { return end_; })) display_->update(name_, film_());
    });
}

DisplayFeed::~DisplayFeed() {
    if (display_ == nullptr) return;
    {
        const std::lock_guard lock(mutex_);
        end_ = true;
    }
    ended_.notify_all();
    thread_.join();
    display_->update(name_, film_());
}

} // namespace taut::app
