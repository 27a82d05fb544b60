#pragma once
/// Progress of a render: a bar with the time left on a terminal, plain lines elsewhere, JSON lines for farms, and those of Open Job
/// Description (openjd_progress: percent), on standard output.

#include <chrono>
#include <string>

namespace taut::app {

enum class ProgressStyle { None, Bar, Plain, Json, OpenJobDescription };

class Progress {
  public:
    Progress(ProgressStyle style, int frames);
    void startFrame(int frame);
    [[nodiscard]] int frame() const { return frame_; } ///< that is under way
    void update(double shareOfFrame);
    void finishFrame(int frame, const std::string &output, double seconds, const std::string &reached = {});
    /// What happened to the frame in between: "resumed" from a file, "checkpoint" in one, "skipped" for one.
    void tell(const char *event, double shareOfFrame, const std::string &path);
    /// The last line: why, and the checkpoint that is left; none where the frame was done. Said whatever the style.
    void stopped(const char *cause, double shareOfFrame, const std::string &checkpoint);

  private:
    ProgressStyle style_;
    int frames_;
    int done_ = 0;
    int frame_ = 0;
    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point lastPrint_;
};

} // namespace taut::app
