#pragma once
/// Arbitrary output variables: what is known of the first surface on a path, in world space where it is a place or a direction.
///
/// One table (aov.cpp) holds them all: a new one is a row there, with its function.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace taut {

class RenderScene;
struct SurfacePoint;

/// A row of the table.
enum class Aov : std::uint8_t {};

struct AovInfo {
    std::string_view name;                  ///< on the command line
    std::vector<std::string_view> channels; ///< in the EXR: LAYER.C, C one of R G B A X Y Z, as Blender reads them, or a single letter
    /// Writes the channels' values at a first hit.
    void (*write)(const RenderScene &scene, const SurfacePoint &point, float *out);
};

std::span<const AovInfo> aovTable();
const AovInfo &infoOf(Aov aov);

/// The row of a name; none where there is no such name.
std::optional<Aov> findAov(std::string_view name);
/// The rows of several names, "all" being every one, each once. Throws InputError with the nearest valid name.
std::vector<Aov> aovsNamed(std::span<const std::string_view> names, std::string_view option);

/// Writes the AOVs of one hit, in their order.
void writeAovs(const RenderScene &scene, const SurfacePoint &point, std::span<const Aov> aovs, float *out);

} // namespace taut
