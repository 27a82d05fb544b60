#include "interruption.h"

#include "taut/base/file_bytes.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <mutex>
#include <string>
#include <thread>

namespace taut::app {

namespace {

struct Signal {
    int number;
    const char *name;
};
constexpr Signal kSignals[] = {{SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}, {SIGPIPE, nullptr}};

int toWatcher = -1;
std::atomic<int> exitCode{1};

/// Who wants to be told, and what came.
struct Waiting {
    std::mutex mutex;
    std::function<void()> stop;
    const char *signal = nullptr;
};
Waiting &waiting() {
    static auto *one = new Waiting; // lives as long as any thread
    return *one;
}

/// A handler may do almost nothing; a thread that waits for its byte may do anything.
void tellWatcher(int number) {
    const int error = errno;
    const auto byte = static_cast<unsigned char>(number);
    static_cast<void>(!write(toWatcher, &byte, 1));
    errno = error;
}

/// Whether somebody waited for the signal, and is told.
bool isTaken(const Signal &signal) {
    Waiting &w = waiting();
    const std::lock_guard lock(w.mutex);
    if (!w.stop || w.signal != nullptr || signal.name == nullptr) return false;
    w.signal = signal.name;
    w.stop();
    return true;
}

[[noreturn]] void end(const Signal &signal) {
    abandonOutputFiles();
    if (signal.name != nullptr) {
        const std::string line = std::string("taut: error: stopped by ") + signal.name + "; what was not finished is removed\n";
        static_cast<void>(!write(STDERR_FILENO, line.data(), line.size()));
    }
    _exit(exitCode);
}

void watch(int fromHandler) {
    while (true) {
        unsigned char byte = 0;
        while (read(fromHandler, &byte, 1) != 1) {}
        for (const Signal &signal : kSignals)
            if (signal.number == byte && !isTaken(signal)) end(signal);
    }
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

void setExitCodeOfStop(int code) {
    exitCode = code;
}

StopRequest::StopRequest(std::function<void()> stop) {
    const std::lock_guard lock(waiting().mutex);
    waiting().stop = std::move(stop);
    waiting().signal = nullptr;
}

StopRequest::~StopRequest() {
    const std::lock_guard lock(waiting().mutex);
    waiting().stop = nullptr;
}

const char *StopRequest::signal() const {
    const std::lock_guard lock(waiting().mutex);
    return waiting().signal;
}

} // namespace taut::app
