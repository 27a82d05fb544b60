#pragma once
/// A mesh from arrays, and its points as they stand in the caller's memory.

#include "arrays.h"

#include "taut/deform/point_source.h"
#include "taut/mesh/mesh.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace taut::python {

/// Faces as starts in an array of corners, with what their corners may have. An attribute has one row a point or one row a corner.
struct MeshArrays {
    Array<float> rest;            ///< [points, 3], object space, metres
    Array<std::uint32_t> starts;  ///< [faces]
    Array<std::uint32_t> corners; ///< [corners] -> point
    std::optional<Array<float>> uvs, normals;
    std::optional<Array<std::uint32_t>> faceMaterials{}; ///< [faces], into materialNames
    std::vector<std::string> materialNames{};
};

/// Takes everything over: the library keeps its own topology and rest shape. Throws InputError for rows that fit neither points nor
/// corners; what is wrong with the indices is check()'s to say.
std::shared_ptr<const Mesh> meshOf(const std::string &name, const MeshArrays &arrays);

/// A source whose positions are where the caller last said: a view, no copy.
class CurrentPoints final : public PointSource {
  public:
    explicit CurrentPoints(std::size_t points) : points_(points) {}
    [[nodiscard]] std::size_t points() const override { return points_; }
    [[nodiscard]] std::unique_ptr<PointReader> open() const override { return std::make_unique<Reader>(now_); }
    void set(std::span<const Vec3> positions) { now_ = positions; }

  private:
    class Reader final : public PointReader {
      public:
        explicit Reader(const std::span<const Vec3> &now) : now_(now) {}
        std::span<const Vec3> at(double /*frame*/, double /*fps*/) override { return now_; }

      private:
        const std::span<const Vec3> &now_;
    };
    std::size_t points_;
    std::span<const Vec3> now_;
};

} // namespace taut::python
