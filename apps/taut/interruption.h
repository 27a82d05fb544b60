#pragma once
/// What the command does when it is told to stop.

#include <functional>

namespace taut::app {

/// Stopped before it was done, by a signal or a limit of time, and what there is can be gone on with (EX_TEMPFAIL of sysexits.h).
inline constexpr int kResumable = 75;

/// From now on SIGINT, SIGTERM and SIGHUP remove what is half written, say so in one line and end the process with exit code 1
/// (setExitCodeOfStop); so does a reader of its output that goes away (SIGPIPE), without a line. A file that grows beyond the limit of its
/// size (SIGXFSZ) is an error of writing. A signal that was ignored when the process began stays so.
void endCleanlyWhenStopped();

/// The exit code of a process that is ended so.
void setExitCodeOfStop(int code);

/// While it lives the first of these signals only calls `stop`, from a thread of its own; the next one ends the process. One at a time.
class StopRequest {
  public:
    explicit StopRequest(std::function<void()> stop);
    ~StopRequest();
    StopRequest(const StopRequest &) = delete;
    StopRequest &operator=(const StopRequest &) = delete;

    /// The name of the signal that came; null: none yet.
    [[nodiscard]] const char *signal() const;
};

} // namespace taut::app
