#include "movie.h"

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

extern char **environ; // NOLINT: POSIX wants this declaration from the user

namespace taut::app {

namespace {

namespace fs = std::filesystem;

struct MovieFormat {
    const char *extension;
    std::vector<const char *> arguments;
};

/// Sizes that are odd are filled up with black, colours are said to be Rec. 709's.
const char *const kVideo = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";

const std::array<MovieFormat, 3> &formats() {
    static const std::array<MovieFormat, 3> all{{
        {"mp4",
         {"-vf", kVideo, "-c:v", "libx264", "-crf", "16", "-preset", "slow", "-colorspace", "bt709", "-color_primaries", "bt709",
          "-color_trc", "bt709", "-movflags", "+faststart", "-f", "mp4"}},
        {"webm",
         {"-vf", kVideo, "-c:v", "libvpx-vp9", "-crf", "20", "-b:v", "0", "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc",
          "bt709", "-f", "webm"}},
        {"gif", {"-filter_complex", "split[a][b];[a]palettegen[p];[b][p]paletteuse", "-f", "gif"}},
    }};
    return all;
}

std::string folderOfMovie(const std::string &path) {
    return path + ".frames";
}

/// Runs it in a folder, both its streams in `log`; minus errno where it can't be run.
int run(const std::vector<std::string> &words, const std::string &folder, const std::string &log) {
    std::vector<char *> argv;
    for (const std::string &word : words) argv.push_back(const_cast<char *>(word.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    pid_t pid = 0;
    const int error = posix_spawnp(&pid, argv.front(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) return -error;
    int status = 0;
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {}
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// The last line of a log, which is where ffmpeg says why.
std::string lastLine(std::string text) {
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text.substr(text.find_last_of('\n') + 1);
}

} // namespace

bool isMoviePath(const std::string &path) {
    const std::string extension = lowerExtension(path);
    return std::any_of(formats().begin(), formats().end(), [&](const MovieFormat &f) { return extension == f.extension; });
}

void checkMovie(const std::string &path) {
    if (run({"ffmpeg", "-version"}, "/", "/dev/null") != 0)
        failInput({"-o"}, quoted(path) + ", but no ffmpeg on this machine", "ffmpeg (apt-get install ffmpeg), or images: out/####.png");
}

std::string pictureOfMovie(const std::string &path, std::size_t number) {
    return fmt::format("{}/{:06}.png", folderOfMovie(path), number);
}

void writeMovie(const std::string &path, double fps) {
    const std::string folder = folderOfMovie(path);
    const std::string log = folder + "/ffmpeg.log";
    const std::string extension = lowerExtension(path);
    const auto format = std::find_if(formats().begin(), formats().end(), [&](const MovieFormat &f) { return extension == f.extension; });
    const std::string made = "movie." + extension; // in the folder, until it is whole
    std::vector<std::string> words{"ffmpeg",     "-hide_banner",         "-loglevel", "error",   "-y",
                                   "-framerate", fmt::format("{}", fps), "-i",        "%06d.png"};
    words.insert(words.end(), format->arguments.begin(), format->arguments.end());
    words.push_back(made);
    if (const int code = run(words, folder, log); code != 0)
        throw RunError(path + ": ffmpeg failed" +
                       (code < 0 ? ": " + std::string(std::strerror(-code)) : " (" + lastLine(readFileBytes(log)) + ")") +
                       "; the pictures are in " + folder);
    std::error_code error;
    fs::rename(folder + "/" + made, path, error);
    if (error) throw RunError(path + ": could not be written: " + error.message());
    fs::remove_all(folder, error);
}

} // namespace taut::app
