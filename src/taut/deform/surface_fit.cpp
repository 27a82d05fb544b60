#include "taut/deform/surface_fit.h"

#include <algorithm>
#include <array>
#include <optional>

namespace taut {

namespace {

/// A fit whose rest tangents come out this short or skewed is no fit.
constexpr float kLeastFitDeterminant = 0.02F;
/// Faces lower than this share of their longest edge stretch by what rounding says: where there are no others, none is known.
constexpr float kLeastHeight = 1e-5F;
/// By angle, a face lower than this counts less: its stretch across is uncertain, and its angle does not fall with it.
constexpr float kLowFace = 0.1F;

/// A stencil under construction: a small map from position to the weights of dx/de1 and dx/de2.
struct Row {
    std::vector<std::pair<Index, Vec2>> entries;
    float total = 0; ///< of the weights of the faces
    void add(Index position, const Vec2 &weight) {
        for (auto &[at, sum] : entries)
            if (at == position) {
                sum += weight;
                return;
            }
        entries.emplace_back(position, weight);
    }
};

/// One face's corner, as the triangle of it and its neighbours.
struct CornerTriangle {
    Index surface;                  ///< surface vertex
    std::array<Index, 3> positions; ///< welded: this, next, previous
    std::array<Vec3, 3> points;     ///< rest space
    Vec3 normal;                    ///< unit
    float area;
    float longest2; ///< square of the longest edge
};

template <class F> void forEachCornerTriangle(const FitInput &input, const Surface &surface, const F &f) {
    const Mesh &mesh = input.mesh;
    for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
        const Index begin = mesh.faceOffsets[face];
        const Index count = mesh.faceOffsets[face + 1] - begin;
        for (Index k = 0; k < count; ++k) {
            const std::array<Index, 3> corners{begin + k, begin + (k + 1) % count, begin + (k + count - 1) % count};
            CornerTriangle t{input.cornerSurface[corners[0]], {}, {}, Vec3(0), 0, 0};
            for (std::size_t i = 0; i < 3; ++i) {
                const Index position = mesh.cornerPositions[corners[i]];
                t.positions[i] = input.canonical[position];
                t.points[i] = input.rest[position];
            }
            const Vec3 twiceArea = glm::cross(t.points[1] - t.points[0], t.points[2] - t.points[0]);
            const float length = glm::length(twiceArea);
            // SkipDegenerateFace; a concave corner too.
            if (!(length > 0) || glm::dot(twiceArea, surface.normals[t.surface]) <= 0) continue;
            t.normal = twiceArea / length;
            t.area = 0.5F * length;
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3 edge = t.points[(i + 1) % 3] - t.points[i];
                t.longest2 = std::max(t.longest2, glm::dot(edge, edge));
            }
            f(t);
        }
    }
}

/// What a face counts at its corner.
float weightOf(const CornerTriangle &t, GradientFit fit) {
    if (fit != GradientFit::Angle) return t.area;
    const Vec3 a = t.points[1] - t.points[0];
    const Vec3 b = t.points[2] - t.points[0];
    return std::atan2(2 * t.area, glm::dot(a, b)) * std::min(1.0F, 2 * t.area / (kLowFace * t.longest2));
}

/// The faces around a surface vertex, summed.
struct RingSum {
    Index count = 0;
    float weight = 0;
    float area = 0;
    float squares = 0; ///< of longest edges
    float tilt = 0;    ///< weighted

    /// Stretched as rounding says.
    [[nodiscard]] bool onlySlivers() const { return 2 * area < kLeastHeight * squares; }
};

/// A face laid into the tangent plane of its vertex by the shortest rotation between their normals: the inverse of its edges there is
/// the map from the plane to the deformed face.
RingFace layOut(const CornerTriangle &t, const Frame &frame, float share) {
    const DVec3 a(t.points[1] - t.points[0]);
    const DVec3 b(t.points[2] - t.points[0]);
    const DVec3 n(frame.n);
    const DVec3 normal = glm::normalize(glm::cross(a, b));
    const DVec3 k = glm::cross(normal, n);
    const double c = glm::dot(normal, n); // > 0
    const auto laid = [&](const DVec3 &v) {
        const DVec3 rotated = v * c + glm::cross(k, v) + k * (glm::dot(k, v) / (1 + c)); // Rodrigues
        return DVec2(glm::dot(rotated, DVec3(frame.s)), glm::dot(rotated, DVec3(frame.t)));
    };
    const glm::dmat2 inverse = glm::inverse(glm::dmat2(laid(a), laid(b)));
    return {{t.positions[1], t.positions[2]}, Vec4(glm::dvec4(inverse[0], inverse[1])), share};
}

/// The rings of surface vertices that have a stencil.
void makeRings(const FitInput &input, const SurfaceOptions &options, const std::vector<RingSum> &sums, Surface &surface) {
    const auto isKnown = [&](std::size_t s) { return surface.stencilOffsets[s] != surface.stencilOffsets[s + 1]; };
    surface.ringOffsets.assign(sums.size() + 1, 0);
    for (std::size_t s = 0; s < sums.size(); ++s) surface.ringOffsets[s + 1] = surface.ringOffsets[s] + (isKnown(s) ? sums[s].count : 0);
    surface.ringFaces.resize(surface.ringOffsets.back());
    for (const RingSum &sum : sums) surface.ringTilts.push_back(sum.weight > 0 ? sum.tilt / sum.weight : 0.0F);
    std::vector<Index> next(surface.ringOffsets.begin(), surface.ringOffsets.end() - 1);
    forEachCornerTriangle(input, surface, [&](const CornerTriangle &t) {
        if (!isKnown(t.surface)) return;
        const float share = weightOf(t, options.fit) / sums[t.surface].weight;
        surface.ringFaces[next[t.surface]++] = layOut(t, surface.frameAt(t.surface), share);
    });
}

/// Weighted mean of the corner triangles' gradients, grad(phi_k) = n x (opposite edge) / (2 area), by area or by the corner's angle.
void addMean(const CornerTriangle &t, float weight, const Frame &frame, Row &row) {
    row.total += weight;
    const float scale = 0.5F * weight / t.area;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 g = scale * glm::cross(t.normal, t.points[(i + 2) % 3] - t.points[(i + 1) % 3]);
        row.add(t.positions[i], Vec2(glm::dot(g, frame.s), glm::dot(g, frame.t)));
    }
}

/// Least squares over the one-ring: F minimises sum |x_k - x_0 - F a_k|^2, a_k the neighbours in the rest tangent plane. First
/// the neighbours with their a_k are gathered, then F = sum (x_k - x_0) a_k^T (sum a a^T)^-1 makes them weights.
void addNeighbours(const CornerTriangle &t, const Frame &frame, Row &row) {
    row.total = 1;
    for (std::size_t i = 1; i < 3; ++i) {
        const Vec3 edge = t.points[i] - t.points[0];
        const bool known =
            std::any_of(row.entries.begin(), row.entries.end(), [&](const auto &entry) { return entry.first == t.positions[i]; });
        if (!known) row.entries.emplace_back(t.positions[i], Vec2(glm::dot(edge, frame.s), glm::dot(edge, frame.t)));
    }
}
void solveLeastSquares(Index centre, Row &row) {
    float xx = 0;
    float xy = 0;
    float yy = 0;
    for (const auto &[position, a] : row.entries) {
        xx += a.x * a.x;
        xy += a.x * a.y;
        yy += a.y * a.y;
    }
    const float det = xx * yy - xy * xy;
    if (!(det > 0)) {
        row = {};
        return;
    }
    Vec2 sum(0);
    for (auto &[position, a] : row.entries) {
        a = Vec2(yy * a.x - xy * a.y, xx * a.y - xy * a.x) / det;
        sum += a;
    }
    row.add(centre, -sum);
}

/// Makes the fit exact at rest in the tangent plane and records the slope along the normal.
bool normaliseFit(const FitInput &input, Row &row, std::size_t s, Surface &surface) {
    if (!(row.total > 0)) return false;
    Vec3 f1(0);
    Vec3 f2(0);
    for (auto &[position, weight] : row.entries) {
        weight /= row.total;
        f1 += input.rest[position] * weight.x;
        f2 += input.rest[position] * weight.y;
    }
    const auto [e1, e2, n] = surface.frameAt(s);
    const Mat2 tangent(glm::dot(f1, e1), glm::dot(f1, e2), glm::dot(f2, e1), glm::dot(f2, e2)); // columns: f1, f2 in (e1, e2)
    if (!(glm::determinant(tangent) > kLeastFitDeterminant)) return false;
    const Mat2 correction = glm::inverse(tangent); // [f1 f2] * correction = [e1 e2] in the plane
    for (auto &[position, weight] : row.entries)
        weight = {weight.x * correction[0][0] + weight.y * correction[0][1], weight.x * correction[1][0] + weight.y * correction[1][1]};
    const Vec3 g1 = f1 * correction[0][0] + f2 * correction[0][1];
    const Vec3 g2 = f1 * correction[1][0] + f2 * correction[1][1];
    surface.slope[s] = {glm::dot(g1, n), glm::dot(g2, n)};
    return true;
}

/// Rows of a subdivided mesh on its cage's points: the limit tangents R1, R2, taken to the frame (e1, e2); where there are none,
/// the fit over the refined faces, put through the rows of its positions.
class LimitRows {
  public:
    explicit LimitRows(const SurfaceOptions &options) : limit_(*options.limit), options_(options) {}

    /// Appends the row of surface vertex s, whose normal is number `normal`; false where there is no gradient.
    bool append(std::size_t s, Index normal, const Row &fit, Surface &surface) {
        entries_.clear();
        addPoint(surface.surfacePosition[s], [](float w) { return Vec3(w, 0, 0); });
        const bool exact = addTangents(normal, surface.frameAt(s));
        if (exact)
            surface.slope[s] = Vec2(0);
        else
            for (const auto &[refined, weight] : fit.entries) addPoint(refined, [scale = weight](float w) { return Vec3(0, w * scale); });
        std::sort(entries_.begin(), entries_.end(), [](const auto &a, const auto &b) { return a.first < b.first; });
        for (std::size_t i = 0; i < entries_.size();) {
            Vec3 sum(0);
            const Index at = entries_[i].first;
            for (; i < entries_.size() && entries_[i].first == at; ++i) sum += entries_[i].second;
            surface.stencilPositions.push_back(at);
            surface.stencilPoints.push_back(sum.x);
            surface.stencilWeights.emplace_back(sum.y, sum.z);
        }
        return exact || !fit.entries.empty();
    }

  private:
    template <class F> void addPoint(Index vertex, const F &weights) {
        const StencilTable &table = limit_.positions;
        for (Index k = table.offsets[vertex]; k < table.offsets[vertex + 1]; ++k)
            entries_.emplace_back(table.indices[k], weights(table.weights[k]));
    }
    /// With rest tangents R = [e1 e2] T the weights along e1, e2 are those of the tangents times T^-1.
    bool addTangents(Index normal, const Frame &frame) {
        const TangentTable &table = limit_.tangents;
        DVec3 r1(0);
        DVec3 r2(0);
        for (Index k = table.offsets[normal]; k < table.offsets[normal + 1]; ++k) {
            const DVec3 p(options_.cage[table.indices[k]]);
            r1 += p * static_cast<double>(table.weights[k].x);
            r2 += p * static_cast<double>(table.weights[k].y);
        }
        r1 = DMat3(options_.restFromObject) * r1;
        r2 = DMat3(options_.restFromObject) * r2;
        const DVec3 e1(frame.s);
        const DVec3 e2(frame.t);
        const glm::dmat2 t(glm::dot(r1, e1), glm::dot(r1, e2), glm::dot(r2, e1), glm::dot(r2, e2));
        const double det = glm::determinant(t);
        if (!(det > 1e-6 * glm::length(r1) * glm::length(r2))) return false;
        const glm::dmat2 toFrame = glm::transpose(glm::inverse(t));
        for (Index k = table.offsets[normal]; k < table.offsets[normal + 1]; ++k)
            entries_.emplace_back(table.indices[k], Vec3(0, Vec2(toFrame * DVec2(table.weights[k]))));
        return true;
    }

    const Subdivision &limit_;
    const SurfaceOptions &options_;
    std::vector<std::pair<Index, Vec3>> entries_; ///< weights of position, dx/de1, dx/de2
};

} // namespace

void makeFits(const FitInput &input, const SurfaceOptions &options, Surface &surface) {
    std::vector<Row> rows(surface.normals.size());
    std::vector<RingSum> sums(rows.size());
    forEachCornerTriangle(input, surface, [&](const CornerTriangle &t) {
        const Frame frame = surface.frameAt(t.surface);
        const float weight = weightOf(t, options.fit);
        if (options.fit == GradientFit::LeastSquares)
            addNeighbours(t, frame, rows[t.surface]);
        else
            addMean(t, weight, frame, rows[t.surface]);
        RingSum &sum = sums[t.surface];
        ++sum.count;
        sum.weight += weight;
        sum.area += t.area;
        sum.squares += t.longest2;
        sum.tilt += weight * std::fmax(0.0F, 1 - glm::dot(t.normal, frame.n));
    });
    surface.stencilOffsets.assign(1, 0);
    surface.slope.assign(rows.size(), Vec2(0));
    const bool onLimit = isLimit(options);
    std::optional<LimitRows> limit;
    if (onLimit) limit.emplace(options);
    for (std::size_t s = 0; s < rows.size(); ++s) {
        if (options.fit == GradientFit::LeastSquares) solveLeastSquares(surface.surfacePosition[s], rows[s]);
        if (sums[s].onlySlivers() || !normaliseFit(input, rows[s], s, surface)) rows[s].entries.clear();
        bool known = !rows[s].entries.empty();
        if (onLimit) {
            known = limit->append(s, input.surfaceNormal[s], rows[s], surface);
        } else {
            for (const auto &[position, weight] : rows[s].entries) {
                surface.stencilPositions.push_back(position);
                surface.stencilWeights.push_back(weight);
            }
        }
        if (!known) { // RestAtLoneVertex
            ++surface.loneVertices;
            if (onLimit) surface.slope[s] = Vec2(kInfinity);
        }
        surface.stencilOffsets.push_back(static_cast<Index>(surface.stencilPositions.size()));
    }
    rows = {};
    if (!onLimit) makeRings(input, options, sums, surface);
}

} // namespace taut
