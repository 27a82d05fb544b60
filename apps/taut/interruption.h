#pragma once
/// What the command does when it is told to stop.

namespace taut::app {

/// From now on SIGINT, SIGTERM and SIGHUP remove what is half written, say so in one line and end the process with exit code 1; so does
/// a reader of its output that goes away (SIGPIPE), without a line. A file that grows beyond the limit of its size (SIGXFSZ) is an
/// error of writing. A signal that was ignored when the process began stays so.
void endCleanlyWhenStopped();

} // namespace taut::app
