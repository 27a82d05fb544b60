#pragma once
/// Motion from anywhere: the positions of a mesh's points over time, from a program's own arrays or function, or from files
/// (formats/point_files.h). A mesh with a point source moves exactly as one with deformers does: gradient, M and gloss follow.
///
/// Positions are [points] in the mesh's object space, metres, in the order of Mesh::positions. A frame may be fractional: motion blur
/// and sequences ask for times between frames.

#include "taut/base/vec.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace taut {

/// One user's way through a source: holds what it has read last. Not for several threads at once.
class PointReader {
  public:
    PointReader() = default;
    PointReader(const PointReader &) = delete;
    PointReader &operator=(const PointReader &) = delete;
    virtual ~PointReader() = default;
    /// Positions at a frame, [points]; the view holds until the next call. `fps` for sources that are keyed in seconds.
    virtual std::span<const Vec3> at(double frame, double fps) = 0;
};

/// Immutable itself, and may be shared by objects and threads: each opens a reader of its own.
class PointSource {
  public:
    PointSource() = default;
    PointSource(const PointSource &) = delete;
    PointSource &operator=(const PointSource &) = delete;
    virtual ~PointSource() = default;
    [[nodiscard]] virtual std::size_t points() const = 0;
    /// A reader, which refers to the source.
    [[nodiscard]] virtual std::unique_ptr<PointReader> open() const = 0;
};

/// Where a frame lies among samples: at `before`, or `u` of the way from there to the next one, in [0, 1).
struct SamplePlace {
    std::size_t before = 0;
    float u = 0;
};
/// Among increasing frames, held at both ends.
SamplePlace placeAmong(std::span<const double> frames, double frame);

/// A source that knows its positions at some times and is linear between them. At a sample's own time the view is the sample itself.
class SampledReader : public PointReader {
  public:
    std::span<const Vec3> at(double frame, double fps) final;

  protected:
    [[nodiscard]] virtual SamplePlace place(double frame, double fps) const = 0;
    /// The positions of a sample, [points]. The views of the last two samples asked for must hold together.
    virtual std::span<const Vec3> sample(std::size_t number) = 0;

  private:
    std::vector<Vec3> between_;
};

/// The last two samples of a file, as a SampledReader keeps them.
class TwoSamples {
  public:
    /// Sample `number`, by `read(buffer)` where it is not at hand.
    template <class Read> std::span<const Vec3> get(std::size_t number, const Read &read) {
        for (std::size_t i = 0; i < slots_.size(); ++i)
            if (slots_[i].number == number) return slots_[last_ = i].positions;
        Slot &slot = slots_[last_ = 1 - last_];
        slot.number = kNothing; // where reading throws
        read(slot.positions);
        slot.number = number;
        return slot.positions;
    }

  private:
    static constexpr std::size_t kNothing = SIZE_MAX;
    struct Slot {
        std::size_t number = kNothing;
        std::vector<Vec3> positions;
    };
    std::array<Slot, 2> slots_;
    std::size_t last_ = 0; ///< asked for last
};

/// The caller's arrays: frame firstFrame + i is frames[i], linear between, held outside. Nothing is copied: the arrays stay the caller's,
/// who keeps them, and may write into them between two frames of a render. Throws InputError where there is no frame or they differ in
/// length.
std::shared_ptr<const PointSource> pointFrames(std::vector<std::span<const Vec3>> frames, double firstFrame = 1);

/// The caller's function, which writes the [points] positions at a frame. It is called by one thread at a time for each object, once for
/// each time in the shutter; what it throws comes out of RenderScene::setFrame as it is.
using PointFunction = std::function<void(double frame, std::span<Vec3> positions)>;
std::shared_ptr<const PointSource> pointFunction(std::size_t points, PointFunction function);

} // namespace taut
