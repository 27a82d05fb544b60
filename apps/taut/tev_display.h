#pragma once
/// The picture of a render on its way to a tev viewer (github.com/Tom94/tev, README, "Over the Network").
///
/// Packets over TCP, little-endian: length of all of it (4 bytes), kind (1), then, of what is sent here,
///   4, a new image:       grab focus (1), name 0, width, height, number of channels (4 each), their names, each ended by 0
///   6, a part of it:      grab focus (1), name 0, number of channels (4), their names, x, y, width, height (4 each), for each channel where
///                         its first value stands and then how far apart its values are (8 each, in floats), the floats

#include "taut/render/film.h"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace taut::app {

class TevDisplay {
  public:
    /// Connects to HOST:PORT. Throws InputError where that is none, RunError where nobody listens.
    explicit TevDisplay(const std::string &address);
    ~TevDisplay();
    TevDisplay(const TevDisplay &) = delete;
    TevDisplay &operator=(const TevDisplay &) = delete;

    /// A new, black image; of another name than those before.
    void create(const std::string &name, int width, int height, const std::vector<std::string> &channels);
    /// The film's window of it. After the viewer has gone this does nothing; that is said once.
    void update(const std::string &name, const Film &film);

  private:
    void send(std::string packet);

    std::string address_;
    int socket_ = -1;
};

/// While it lives, sends the film twice a second, and once more at its end.
class DisplayFeed {
  public:
    /// `display` null: does nothing.
    DisplayFeed(TevDisplay *display, std::string name, std::function<Film()> film);
    ~DisplayFeed();
    DisplayFeed(const DisplayFeed &) = delete;
    DisplayFeed &operator=(const DisplayFeed &) = delete;

  private:
    TevDisplay *display_;
    std::string name_;
    std::function<Film()> film_;
    std::mutex mutex_;
    std::condition_variable ended_;
    bool end_ = false;
    std::thread thread_;
};

} // namespace taut::app
