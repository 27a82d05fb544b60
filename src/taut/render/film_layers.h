#pragma once
/// What a film sums beside radiance and the AOVs of first hits, where it is asked for: mattes, light groups, squares. All of it exact, so
/// that films with layers merge as films do.
///
/// Mattes count the samples whose first surface an object, or a material, is: an id has the share of a pixel's samples that saw it
/// (Cryptomatte 1.2.0). Light groups split radiance by what sent it; their sums add up to those of R, G and B exactly. Variance is that
/// of a pixel's mean: s^2 / n, with s^2 = sum (x - mean)^2 / (n - 1) over its n samples, without bias where these are independent.

#include "taut/base/exact_sum.h"
#include "taut/base/vec.h"
#include "taut/render/aov.h"

#include <span>
#include <string>
#include <vector>

namespace taut {

class Unpacker;

/// Which are asked for.
struct FilmLayers {
    bool objects = false, materials = false;
    bool lights = false;
    bool samples = false, variance = false;
    int ranks = 6;                          ///< ids a pixel in the image, even, 2 to 32; a film keeps all
    std::vector<std::string> lightGroups{}; ///< their names, with `lights`: render/light_groups.h

    [[nodiscard]] bool hasSums() const { return objects || materials || lights || variance; }
    [[nodiscard]] bool any() const { return hasSums() || samples; }
    /// "Layer.C", as compositors read them.
    [[nodiscard]] std::vector<std::string> channelNames() const;
    /// All that it says, as words without spaces.
    [[nodiscard]] std::vector<std::string> words() const;
    /// Takes one back. Throws InputError where it is none.
    void addWord(std::string_view word);
    bool operator==(const FilmLayers &) const = default;
};

/// Names of AOVs and layers: rows of the table (aov.h), crypto_object, crypto_material, lights, samples and variance. "all" is every row
/// of the table. Throws InputError with the nearest valid name.
struct FilmContents {
    std::vector<Aov> aovs;
    FilmLayers layers;
};
FilmContents filmContentsNamed(std::span<const std::string> names, std::string_view option);

/// One sample as layers take it.
struct LayerSample {
    std::uint32_t object = 0, material = 0; ///< ids of the first surface; 0: none (matte_id.h)
    const Vec3 *lights = nullptr;           ///< [groups]; null: none shone
};

/// The sums of all pixels.
class LayerSums {
  public:
    LayerSums() = default;
    explicit LayerSums(const FilmLayers &asked) : asked_(asked) {}
    [[nodiscard]] const FilmLayers &asked() const { return asked_; }
    void resize(std::size_t pixels);

    /// `radiance`: the sample's, of which its light groups are the parts.
    void add(std::size_t pixel, const Vec3 &radiance, const LayerSample &sample);
    void merge(std::size_t pixel, const LayerSums &other, std::size_t from);
    void copy(std::size_t first, const LayerSums &other, std::size_t from, std::size_t count);
    /// Appends the values of a pixel, in channelNames() order. `rgb`: its sums of R, G and B. The variance of fewer than two samples is
    /// infinite.
    void resolve(std::size_t pixel, std::uint32_t samples, const ExactSum *rgb, std::vector<float> &values) const;

    void pack(std::size_t first, std::size_t count, std::vector<unsigned char> &out) const;
    /// Appends pixels that have these numbers of samples. Throws InputError where the bytes are damaged.
    void unpack(std::span<const std::uint32_t> samples, Unpacker &in);

    bool operator==(const LayerSums &) const = default;

  private:
    struct Count {
        std::uint32_t id = 0, samples = 0;
        bool operator==(const Count &) const = default;
    };
    /// Of one kind of id, a pixel's: in the order of the ids.
    using Counts = std::vector<Count>;

    static void addTo(Counts &counts, std::uint32_t id, std::uint32_t samples);
    void resolveMattes(const Counts &counts, std::uint32_t samples, std::vector<float> &values) const;
    [[nodiscard]] std::size_t lightSums() const { return asked_.lights ? 3 * asked_.lightGroups.size() : 0; }

    FilmLayers asked_;
    std::vector<Counts> objects_, materials_; // [pixels] each, or empty
    std::vector<ExactSum> lights_;            // [pixels x groups x 3]
    std::vector<ExactSum> squares_;           // [pixels x 3]
};

} // namespace taut
