#pragma once
/// Progress of a render: a bar with the time left on a terminal, plain lines elsewhere, JSON lines for farms.

#include <chrono>
#include <string>

namespace taut::app {

enum class ProgressStyle { None, Bar, Plain, Json };

class Progress {
  public:
    Progress(ProgressStyle style, int frames);
    void startFrame(int frame);
    void update(double shareOfFrame);
    void finishFrame(int frame, const std::string &output, double seconds);

  private:
    ProgressStyle style_;
    int frames_;
    int done_ = 0;
    int frame_ = 0;
    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point lastPrint_;
};

} // namespace taut::app
