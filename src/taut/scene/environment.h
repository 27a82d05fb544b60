#pragma once
/// Environment light: a lat-long radiance map (or a constant) with importance sampling.
///
/// Environment space is world space turned about z by -rotation: z up. A unit direction w has, in map coordinates,
/// u = 1/2 - atan2(w.y, w.x) / 2pi (left to right) and v = acos(w.z) / pi (top to bottom): the map's centre column looks
/// along +x and its left half along +y, as in Blender.

#include "taut/base/budget.h"
#include "taut/base/error.h"
#include "taut/base/instructions.h"
#include "taut/base/lanes.h"

#include <string>
#include <vector>

namespace taut {

struct Environment {
    int width = 1;
    int height = 1;
    std::vector<Vec3> texels{Vec3(1)}; ///< radiance, W / (m^2 sr); rows from the zenith (+z) down
    double rotation = 0;               ///< about world z, radians
    bool cameraVisible = true;
    bool constant = true; ///< one texel: radiance is texels[0] everywhere, sampled uniformly

    Vec3 mean{1};       ///< radiance averaged over the sphere, for choosing between lights
    float coverage = 1; ///< share of the sphere that is bright: the square of the mean luminance over the mean of its square; 1: even

    /// Importance sampling, filled by buildSampling(): inverse cumulative tables by luminance * solid angle, one over the rows and
    /// one over the columns within each row. They keep stratified points stratified, where an alias table would scatter them.
    struct TableEntry {
        float cumulative = 0; ///< up to and including this entry; the last is 1
        float density = 0;    ///< rows: P(row) / solid angle of one texel there, 1/sr; columns: P(column | row); of the rounded sums
    };
    std::vector<TableEntry> table; ///< [height] rows, then [height][width] columns; empty where constant
    std::vector<Index> guide;      ///< for each of the table's entries: where the search of numbers in its place's share begins
    std::vector<double> rowHeight; ///< [height + 1]: 1 - cos(theta) at the upper edge of each row, and 2
};

struct EnvironmentSample {
    Vec3 direction; ///< world space, unit, towards the environment
    Vec3 radiance;
    float pdf; ///< per steradian
};

/// A constant environment.
Environment constantEnvironment(const Vec3 &radiance);

/// Reads a map of radiance (readRadiance, which holds and counts single negative and not finite texels) and multiplies it by `scale`.
/// Throws InputError where that leaves float's range, or `budget` has not the memory (null: one of its own).
Environment readEnvironment(const std::string &path, double rotation, const Vec3 &scale, Warnings &warnings, Budget *budget = nullptr);

/// The built-in studio: soft boxes over a dim gradient, made here by formula.
Environment studioEnvironment();
/// The neutral one that goes with a ground (ground.h): grey all round, so that the ground can fade into it, and white soft boxes outside
/// the framed view.
Environment neutralStudioEnvironment();

/// Fills the sampling tables; called by the makers above. A map that is black throughout becomes a constant. Call it again
/// after texels change.
void buildSampling(Environment &environment);

/// What arrives from world direction `w` (unit, pointing away from the scene): radiance, bilinear between texel centres, and the
/// solid-angle density with which sampleEnvironment() returns `w`, piecewise constant over texels and positive wherever the bilinear
/// radiance is.
struct EnvironmentLookup {
    Vec3 radiance;
    float pdf;
};
EnvironmentLookup lookUpEnvironment(const Environment &environment, const Vec3 &w);

EnvironmentSample sampleEnvironment(const Environment &environment, const Vec2 &u);

/// Many at once: a map is larger than the caches, so what each lane will read is asked for before any of it is used. The bits are
/// those of one by one.
struct alignas(64) EnvironmentLanes {
    static constexpr int kSize = 64;
    int count = 0;
    float u[kSize], v[kSize]; ///< sampleEnvironment() reads them
    Lanes3<kSize> direction;  ///< world space, unit: lookUpEnvironment() reads it, sampleEnvironment() writes it
    Lanes3<kSize> radiance;
    float pdf[kSize]; ///< per steradian
};
void lookUpEnvironment(const Environment &environment, EnvironmentLanes &lanes, Instructions instructions = widest());
void sampleEnvironment(const Environment &environment, EnvironmentLanes &lanes, Instructions instructions = widest());

} // namespace taut
