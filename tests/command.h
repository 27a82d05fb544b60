#pragma once
/// The command as a user runs it: arguments in; exit code, standard output and standard error out. A run that hangs is killed.

#include "output_folder.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

extern char **environ; // NOLINT: POSIX wants this declaration from the user

namespace taut::test {

namespace fs = std::filesystem;

using Arguments = std::vector<std::string>;

/// What `timeout` returns for a run that it had to end.
inline constexpr int kTimedOut = 124;

struct CommandResult {
    int exitCode = 0; ///< minus the signal's number where a signal ended it
    std::string out;
    std::string err;
};

/// A file that vanishes when closed; it holds one output stream of a run, however long, without a reader.
class Capture {
  public:
    Capture() : file_(std::tmpfile()) {
        if (file_ == nullptr) throw std::runtime_error("no temporary file for the output of a command");
    }
    Capture(const Capture &) = delete;
    Capture &operator=(const Capture &) = delete;
    ~Capture() { std::fclose(file_); }

    [[nodiscard]] int descriptor() const { return fileno(file_); }
    [[nodiscard]] std::string text() const {
        std::string all;
        char block[4096];
        std::rewind(file_);
        for (std::size_t read = 0; (read = std::fread(block, 1, sizeof(block), file_)) > 0;) all.append(block, read);
        return all;
    }

  private:
    std::FILE *file_;
};

/// Runs any program found on the PATH. `folder`: where it runs; empty: here.
inline CommandResult runProgram(const Arguments &words, int timeoutSeconds, const std::string &folder = "") {
    Arguments all{"timeout", "--kill-after=5", std::to_string(timeoutSeconds)};
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char *> argv;
    for (std::string &word : all) argv.push_back(word.data());
    argv.push_back(nullptr);

    const Capture out;
    const Capture err;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
    if (!folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    pid_t process = 0;
    const int failed = posix_spawnp(&process, "timeout", &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw std::runtime_error("can't start a command");
    int status = 0;
    if (waitpid(process, &status, 0) != process) throw std::runtime_error("can't wait for a command");
    return {WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status), out.text(), err.text()};
}

/// Runs `taut` with these arguments.
inline CommandResult runTaut(const Arguments &arguments, const std::string &folder = "", int timeoutSeconds = 300) {
    Arguments words{TAUT_COMMAND};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return runProgram(words, timeoutSeconds, folder);
}

/// Runs a line of bash, in which $0 is the command, in a folder.
inline CommandResult runShell(const std::string &line, const std::string &folder) {
    return runProgram({"bash", "-c", line, TAUT_COMMAND}, 300, folder);
}

inline std::vector<std::string> linesOf(const std::string &text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

/// The one error line of a run. Where standard error has anything but that line and warnings, a text that says so.
inline std::string errorLine(const CommandResult &result) {
    std::string error;
    for (const std::string &line : linesOf(result.err)) {
        if (line.rfind("taut: warning: ", 0) == 0) continue;
        if (line.rfind("taut: error: ", 0) != 0) return "NOT AN ERROR LINE: " + line;
        if (!error.empty()) return "TWO ERROR LINES: " + result.err;
        error = line;
    }
    return error.empty() ? "NO ERROR LINE" : error;
}

inline void writeBytes(const std::string &path, const std::string &bytes) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << bytes;
    if (!file.flush()) throw std::runtime_error("can't write " + path);
}

/// Names in a folder, hidden ones too, sorted.
inline std::vector<std::string> namesIn(const std::string &folder) {
    std::vector<std::string> names;
    for (const auto &entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

} // namespace taut::test
