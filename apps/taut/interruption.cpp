#include "interruption.h"

#include "taut/base/file_bytes.h"

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <iostream>
#include <string>
#include <thread>

namespace taut::app {

namespace {

constexpr int kFailed = 1;

struct Signal {
    int number;
    const char *name;
};
constexpr Signal kSignals[] = {{SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}, {SIGPIPE, nullptr}};

int toWatcher = -1;

/// A handler may do almost nothing; a thread that waits for its byte may do anything.
void tellWatcher(int number) {
    const int error = errno;
    const auto byte = static_cast<unsigned char>(number);
    static_cast<void>(!write(toWatcher, &byte, 1));
    errno = error;
}

void watch(int fromHandler) {
    unsigned char byte = 0;
    while (read(fromHandler, &byte, 1) != 1) {}
    abandonOutputFiles();
    for (const Signal &signal : kSignals)
        if (signal.number == byte && signal.name != nullptr) {
            const std::string line = std::string("taut: error: stopped by ") + signal.name + "; what was not finished is removed\n";
            static_cast<void>(!write(STDERR_FILENO, line.data(), line.size()));
        }
    _exit(kFailed);
}

} // namespace

void endCleanlyWhenStopped() {
    std::signal(SIGXFSZ, SIG_IGN);
    int ends[2];
    if (pipe(ends) != 0) return; // then signals do what they always did
    toWatcher = ends[1];
    std::thread(watch, ends[0]).detach();
    for (const Signal &signal : kSignals) {
        struct sigaction action {};
        if (sigaction(signal.number, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
        action = {};
        action.sa_handler = tellWatcher;
        action.sa_flags = SA_RESTART;
        sigaction(signal.number, &action, nullptr);
    }
}

} // namespace taut::app
