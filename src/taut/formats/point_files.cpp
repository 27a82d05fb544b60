#include "taut/formats/point_files.h"

#include "taut/base/frame_set.h"
#include "taut/formats/point_cache.h"
#include "taut/formats/read_mesh.h"

#include <cmath>

namespace taut {

namespace {

class SequenceSource final : public PointSource {
  public:
    SequenceSource(std::string pattern, std::vector<int> numbers, std::shared_ptr<const Mesh> first)
        : pattern_(std::move(pattern)), numbers_(std::move(numbers)), frames_(numbers_.begin(), numbers_.end()), first_(std::move(first)) {}
    [[nodiscard]] std::size_t points() const override { return first_->positions.size(); }
    [[nodiscard]] std::unique_ptr<PointReader> open() const override { return std::make_unique<Reader>(*this); }

  private:
    class Reader final : public SampledReader {
      public:
        explicit Reader(const SequenceSource &source) : source_(source) {}

      protected:
        [[nodiscard]] SamplePlace place(double frame, double /*fps*/) const override { return placeAmong(source_.frames_, frame); }
        std::span<const Vec3> sample(std::size_t number) override {
            return read_.get(number, [&](std::vector<Vec3> &out) {
                out = readSequencePositions(pathOfFrame(source_.pattern_, source_.numbers_[number]), *source_.first_);
            });
        }

      private:
        const SequenceSource &source_;
        TwoSamples read_;
    };

    std::string pattern_;
    std::vector<int> numbers_;
    std::vector<double> frames_;
    std::shared_ptr<const Mesh> first_;
};

class CacheSource final : public PointSource {
  public:
    explicit CacheSource(const std::string &path) : path_(path), points_(PointCacheReader(path).info().points) {}
    [[nodiscard]] std::size_t points() const override { return points_; }
    [[nodiscard]] std::unique_ptr<PointReader> open() const override { return std::make_unique<Reader>(path_); }

  private:
    class Reader final : public SampledReader {
      public:
        explicit Reader(const std::string &path) : cache_(path) {}

      protected:
        [[nodiscard]] SamplePlace place(double frame, double fps) const override {
            const double sample = cache_.info().sampleAtFrame(frame, fps);
            const double before = std::floor(sample);
            return {static_cast<std::size_t>(before), static_cast<float>(sample - before)};
        }
        std::span<const Vec3> sample(std::size_t number) override {
            return read_.get(number, [&](std::vector<Vec3> &out) { cache_.read(static_cast<std::uint32_t>(number), out); });
        }

      private:
        PointCacheReader cache_;
        TwoSamples read_;
    };

    std::string path_;
    std::size_t points_;
};

} // namespace

std::shared_ptr<const PointSource> sequencePoints(std::string pattern, std::vector<int> frames, std::shared_ptr<const Mesh> first) {
    return std::make_shared<const SequenceSource>(std::move(pattern), std::move(frames), std::move(first));
}

std::shared_ptr<const PointSource> cachePoints(const std::string &path) {
    return std::make_shared<const CacheSource>(path);
}

} // namespace taut
