#include "taut/deform/point_source.h"

#include "taut/base/error.h"

#include <algorithm>
#include <string>

namespace taut {

namespace {

class ArrayReader final : public SampledReader {
  public:
    ArrayReader(const std::vector<std::span<const Vec3>> &frames, const std::vector<double> &times) : frames_(frames), times_(times) {}

  protected:
    [[nodiscard]] SamplePlace place(double frame, double /*fps*/) const override { return placeAmong(times_, frame); }
    std::span<const Vec3> sample(std::size_t number) override { return frames_[number]; }

  private:
    std::vector<std::span<const Vec3>> frames_;
    std::vector<double> times_;
};

class ArraySource final : public PointSource {
  public:
    ArraySource(std::vector<std::span<const Vec3>> frames, double firstFrame) : frames_(std::move(frames)) {
        for (std::size_t i = 0; i < frames_.size(); ++i) times_.push_back(firstFrame + static_cast<double>(i));
    }
    [[nodiscard]] std::size_t points() const override { return frames_.front().size(); }
    [[nodiscard]] std::unique_ptr<PointReader> open() const override { return std::make_unique<ArrayReader>(frames_, times_); }

  private:
    std::vector<std::span<const Vec3>> frames_;
    std::vector<double> times_;
};

class FunctionReader final : public PointReader {
  public:
    FunctionReader(std::size_t points, const PointFunction &function) : positions_(points), function_(function) {}
    std::span<const Vec3> at(double frame, double /*fps*/) override {
        function_(frame, positions_);
        return positions_;
    }

  private:
    std::vector<Vec3> positions_;
    PointFunction function_;
};

class FunctionSource final : public PointSource {
  public:
    FunctionSource(std::size_t points, PointFunction function) : points_(points), function_(std::move(function)) {}
    [[nodiscard]] std::size_t points() const override { return points_; }
    [[nodiscard]] std::unique_ptr<PointReader> open() const override { return std::make_unique<FunctionReader>(points_, function_); }

  private:
    std::size_t points_;
    PointFunction function_;
};

} // namespace

SamplePlace placeAmong(std::span<const double> frames, double frame) {
    const auto next = std::upper_bound(frames.begin(), frames.end(), frame);
    if (next == frames.begin()) return {};
    const auto before = static_cast<std::size_t>(next - frames.begin()) - 1;
    if (next == frames.end()) return {before, 0};
    return {before, static_cast<float>((frame - frames[before]) / (*next - frames[before]))};
}

std::span<const Vec3> SampledReader::at(double frame, double fps) {
    const SamplePlace where = place(frame, fps);
    const std::span<const Vec3> first = sample(where.before);
    if (where.u == 0) return first;
    const std::span<const Vec3> second = sample(where.before + 1);
    between_.resize(first.size());
    for (std::size_t i = 0; i < first.size(); ++i) between_[i] = glm::mix(first[i], second[i], where.u);
    return between_;
}

std::shared_ptr<const PointSource> pointFrames(std::vector<std::span<const Vec3>> frames, double firstFrame) {
    if (frames.empty()) throw InputError("points: found no frame, expected at least one array of positions");
    for (std::size_t i = 1; i < frames.size(); ++i)
        if (frames[i].size() != frames.front().size())
            throw InputError("points: found " + std::to_string(frames[i].size()) + " positions in array " + std::to_string(i) +
                             ", expected " + std::to_string(frames.front().size()) + " as in the first");
    return std::make_shared<const ArraySource>(std::move(frames), firstFrame);
}

std::shared_ptr<const PointSource> pointFunction(std::size_t points, PointFunction function) {
    if (!function) throw InputError("points: found no function, expected one that writes positions");
    return std::make_shared<const FunctionSource>(points, std::move(function));
}

} // namespace taut
