/// Looking up and sampling the environment, one by one and many at once.

#include "taut/base/warp.h"
#include "taut/scene/environment.h"

namespace taut {

namespace {

#define TAUT_INLINE [[gnu::always_inline]] inline


/// Which of so many equal shares of [0, 1) a number falls into.
int shareOf(int count, float u) {
    return std::min(static_cast<int>(u * static_cast<float>(count)), count - 1);
}

struct Drawn {
    int index;
    float remainder; ///< uniform again in [0, 1)
};

/// The entry that u falls into; entries of weight 0 are never drawn.
Drawn draw(const Environment::TableEntry *entries, const Index *guide, int count, float u) {
    int i = static_cast<int>(guide[shareOf(count, u)]);
    while (i > 0 && entries[i - 1].cumulative > u) --i; // the share that u falls into was rounded up
    while (i + 1 < count && entries[i].cumulative <= u) ++i;
    const float below = i == 0 ? 0 : entries[i - 1].cumulative;
    const float share = entries[i].cumulative - below;
    return {i, share > 0 ? std::clamp((u - below) / share, 0.0F, kOneMinusEpsilon) : 0.5F};
}

const Environment::TableEntry *columnsOfRow(const Environment &e, int row) {
    return e.table.data() + e.height + static_cast<std::ptrdiff_t>(row) * e.width;
}

const Index *guideOfRow(const Environment &e, int row) {
    return e.guide.data() + e.height + static_cast<std::ptrdiff_t>(row) * e.width;
}

/// A number in (-1, 2] brought to [0, 1] by whole turns.
TAUT_INLINE float withinTurn(float turns) {
    const float part = turns - static_cast<float>(static_cast<int>(turns));
    return part < 0 ? part + 1 : part;
}

/// Rotation of the map in turns, [0, 1).
float rotationTurns(const Environment &e) {
    const double turns = e.rotation / kTwoPi;
    return std::min(kOneMinusEpsilon, static_cast<float>(turns - std::floor(turns)));
}

/// Map coordinates (u, v) in [0, 1] of a world direction. theta by its tangent, which keeps its digits at the poles.
TAUT_INLINE Vec2 mapCoordinates(float rotation, const Vec3 &world) {
    return {withinTurn(0.5F - turnsOf(world.x, world.y) + rotation),
            2 * turnsOf(world.z, std::sqrt(world.x * world.x + world.y * world.y))};
}

/// The four texels around map coordinates in [0, 1], by number, and the weights between them.
struct Footprint {
    int upperLeft, upperRight, lowerLeft, lowerRight;
    float fx, fy;
};
TAUT_INLINE Footprint footprintAt(const Environment &e, const Vec2 &uv) {
    const float x = uv.x * static_cast<float>(e.width) + 0.5F; // a column and a row up: never below 0, so that truncation is floor
    const float y = uv.y * static_cast<float>(e.height) + 0.5F;
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    const int left = (column == 0 ? e.width : column) - 1; // columns wrap
    const int right = column == e.width ? 0 : column;
    const int upper = (row == 0 ? 0 : row - 1) * e.width; // rows end at the poles
    const int lower = (row == e.height ? e.height - 1 : row) * e.width;
    return {upper + left, upper + right, lower + left, lower + right, x - static_cast<float>(column), y - static_cast<float>(row)};
}

Vec3 mixed(const Environment &e, const Footprint &f) {
    const auto texel = [&](int at) { return e.texels[static_cast<std::size_t>(at)]; };
    const Vec3 upper = glm::mix(texel(f.upperLeft), texel(f.upperRight), f.fx);
    const Vec3 lower = glm::mix(texel(f.lowerLeft), texel(f.lowerRight), f.fx);
    return glm::mix(upper, lower, f.fy);
}

/// Radiance at map coordinates, bilinear between texel centres.
Vec3 bilinear(const Environment &e, const Vec2 &uv) {
    return mixed(e, footprintAt(e, uv));
}

float densityOfTexel(const Environment &e, int column, int row) {
    return e.table[static_cast<std::size_t>(row)].density * columnsOfRow(e, row)[column].density;
}

/// The texel that map coordinates fall into.
struct Cell {
    int column, row;
};
TAUT_INLINE Cell cellAt(const Environment &e, const Vec2 &uv) {
    const int column = static_cast<int>(uv.x * static_cast<float>(e.width));
    const int row = static_cast<int>(uv.y * static_cast<float>(e.height));
    return {column < e.width ? column : e.width - 1, row < e.height ? row : e.height - 1};
}

/// Where a place drawn within a texel lies.
struct Aim {
    Vec3 direction; ///< world space
    Vec2 uv;
};
TAUT_INLINE Aim aimAt(float rotation, double height, float across) {
    const float r = static_cast<float>(std::sqrt(height * (2 - height)));
    const auto z = static_cast<float>(1 - height);
    return {Vec3(r * unitCircle(withinTurn(rotation + 0.5F - across)), z), Vec2(across, 2 * turnsOf(z, r))};
}

/// 1 - cos(theta) at a place drawn within a row.
double heightAt(const Environment &e, const Drawn &row) {
    const double *edge = &e.rowHeight[static_cast<std::size_t>(row.index)];
    return glm::mix(edge[0], edge[1], static_cast<double>(row.remainder));
}

float acrossAt(const Environment &e, const Drawn &column) {
    return (static_cast<float>(column.index) + column.remainder) / static_cast<float>(e.width);
}

constexpr float kUniformPdf = 0.25F * kInvPi;

} // namespace

EnvironmentLookup lookUpEnvironment(const Environment &e, const Vec3 &w) {
    if (e.constant) return {e.texels[0], kUniformPdf};
    const Vec2 uv = mapCoordinates(rotationTurns(e), w);
    const Cell cell = cellAt(e, uv);
    return {bilinear(e, uv), densityOfTexel(e, cell.column, cell.row)};
}

EnvironmentSample sampleEnvironment(const Environment &e, const Vec2 &u) {
    if (e.constant) {
        const float z = 1 - 2 * u.y;
        return {Vec3(std::sqrt(std::max(0.0F, (1 - z) * (1 + z))) * unitCircle(u.x), z), e.texels[0], kUniformPdf};
    }
    const Drawn row = draw(e.table.data(), e.guide.data(), e.height, u.y);
    const Drawn column = draw(columnsOfRow(e, row.index), guideOfRow(e, row.index), e.width, u.x);
    const Aim aim = aimAt(rotationTurns(e), heightAt(e, row), acrossAt(e, column));
    return {aim.direction, bilinear(e, aim.uv), densityOfTexel(e, column.index, row.index)};
}

namespace {

/// What stages hand on, lane by lane.
struct alignas(64) Stages {
    float u[EnvironmentLanes::kSize], v[EnvironmentLanes::kSize]; ///< map coordinates
    int upperLeft[EnvironmentLanes::kSize], upperRight[EnvironmentLanes::kSize];
    int lowerLeft[EnvironmentLanes::kSize], lowerRight[EnvironmentLanes::kSize];
    float fx[EnvironmentLanes::kSize], fy[EnvironmentLanes::kSize];
    int column[EnvironmentLanes::kSize], row[EnvironmentLanes::kSize]; ///< texel whose density counts
    double height[EnvironmentLanes::kSize];
    float across[EnvironmentLanes::kSize];
};

TAUT_INLINE void mapLoop(const Environment &e, float rotation, const EnvironmentLanes &l, Stages &s) {
    const int count = l.count;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec2 uv = mapCoordinates(rotation, l.direction.at(static_cast<std::size_t>(i)));
        const Cell cell = cellAt(e, uv);
        s.u[i] = uv.x;
        s.v[i] = uv.y;
        s.column[i] = cell.column;
        s.row[i] = cell.row;
    }
}

TAUT_INLINE void aimLoop(float rotation, EnvironmentLanes &l, Stages &s) {
    const int count = l.count;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Aim aim = aimAt(rotation, s.height[i], s.across[i]);
        l.direction.x[i] = aim.direction.x;
        l.direction.y[i] = aim.direction.y;
        l.direction.z[i] = aim.direction.z;
        s.u[i] = aim.uv.x;
        s.v[i] = aim.uv.y;
    }
}

TAUT_INLINE void footprintLoop(const Environment &e, int count, Stages &s) {
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Footprint f = footprintAt(e, {s.u[i], s.v[i]});
        s.upperLeft[i] = f.upperLeft;
        s.upperRight[i] = f.upperRight;
        s.lowerLeft[i] = f.lowerLeft;
        s.lowerRight[i] = f.lowerRight;
        s.fx[i] = f.fx;
        s.fy[i] = f.fy;
    }
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void map(const Environment &e, float r, const EnvironmentLanes &l, Stages &s) {                \
            mapLoop(e, r, l, s);                                                                                                           \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void aim(float r, EnvironmentLanes &l, Stages &s) { aimLoop(r, l, s); }                        \
        [[gnu::flatten __VA_ARGS__]] static void footprints(const Environment &e, int n, Stages &s) { footprintLoop(e, n, s); }            \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

/// Radiance and density from footprints and cells.
void fetch(const Environment &e, const Stages &s, EnvironmentLanes &l) {
    const auto count = static_cast<std::size_t>(l.count);
    for (std::size_t i = 0; i < count; ++i) {
        __builtin_prefetch(&e.texels[static_cast<std::size_t>(s.upperLeft[i])]);
        __builtin_prefetch(&e.texels[static_cast<std::size_t>(s.lowerLeft[i])]);
        __builtin_prefetch(columnsOfRow(e, s.row[i]) + s.column[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
        l.radiance.set(i, mixed(e, {s.upperLeft[i], s.upperRight[i], s.lowerLeft[i], s.lowerRight[i], s.fx[i], s.fy[i]}));
        l.pdf[i] = densityOfTexel(e, s.column[i], s.row[i]);
    }
}

} // namespace

void lookUpEnvironment(const Environment &e, EnvironmentLanes &l, Instructions instructions) {
    const auto count = static_cast<std::size_t>(l.count);
    if (e.constant) {
        for (std::size_t i = 0; i < count; ++i) {
            l.radiance.set(i, e.texels[0]);
            l.pdf[i] = kUniformPdf;
        }
        return;
    }
    Stages s;
    onInstructions(instructions, [&](auto loops) {
        decltype(loops)::map(e, rotationTurns(e), l, s);
        decltype(loops)::footprints(e, l.count, s);
    });
    fetch(e, s, l);
}

void sampleEnvironment(const Environment &e, EnvironmentLanes &l, Instructions instructions) {
    const auto count = static_cast<std::size_t>(l.count);
    if (e.constant) {
        for (std::size_t i = 0; i < count; ++i) {
            const EnvironmentSample one = sampleEnvironment(e, {l.u[i], l.v[i]});
            l.direction.set(i, one.direction);
            l.radiance.set(i, one.radiance);
            l.pdf[i] = one.pdf;
        }
        return;
    }
    Stages s;
    for (std::size_t i = 0; i < count; ++i) {
        const Drawn row = draw(e.table.data(), e.guide.data(), e.height, l.v[i]);
        s.row[i] = row.index;
        s.height[i] = heightAt(e, row);
        __builtin_prefetch(guideOfRow(e, row.index) + shareOf(e.width, l.u[i]));
    }
    for (std::size_t i = 0; i < count; ++i)
        __builtin_prefetch(columnsOfRow(e, s.row[i]) + guideOfRow(e, s.row[i])[shareOf(e.width, l.u[i])]);
    for (std::size_t i = 0; i < count; ++i) {
        const Drawn column = draw(columnsOfRow(e, s.row[i]), guideOfRow(e, s.row[i]), e.width, l.u[i]);
        s.column[i] = column.index;
        s.across[i] = acrossAt(e, column);
    }
    onInstructions(instructions, [&](auto loops) {
        decltype(loops)::aim(rotationTurns(e), l, s);
        decltype(loops)::footprints(e, l.count, s);
    });
    fetch(e, s, l);
}

} // namespace taut
