#include "taut/deform/surface.h"

#include "taut/deform/affine.h"
#include "taut/deform/skin_hinges.h"
#include "taut/deform/skinning.h"
#include "taut/deform/surface_fit.h"
#include "taut/mesh/tangent_space.h"
#include "taut/mesh/triangulate.h"
#include "taut/mesh/weld.h"
#include "taut/mesh/winding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace taut {

namespace {

/// Normals closer than this (about 0.6 degrees) belong to one surface vertex.
constexpr float kSameNormalCosine = 0.99995F;
/// ... and those that a morph moves apart by less than this.
constexpr float kSameNormalDelta = 0.01F;
/// Powers of two up to which a rest placement may scale and the surface is built as it stands: a million.
constexpr int kPlainScale = 20;
/// Tangents on either side of a UV seam within this angle (20 degrees) are one direction that the seam only interrupts.
constexpr float kSameTangentCosine = 0.94F;
/// A face lower than this share of its longest edge is a sliver whose normal counts less.
constexpr float kFlatSliver = 1e-3F;
constexpr float kTiny = std::numeric_limits<float>::min();

class Builder {
  public:
    Builder(const Mesh &mesh, const SurfaceOptions &options) : mesh_(mesh), options_(options) {
        surface_.restFromObject = options.restFromObject;
        canonical_ = weldPositions(mesh, options.weld);
        morphsNormals_ = !isLimit(options) && !mesh.cornerNormals.empty() && hasMorphNormals(mesh);
        if (!isLimit(options)) turned_ = cornersAgainstWinding(mesh); // those of a limit surface are made from the winding
        rest_.resize(mesh.positions.size());
        for (std::size_t i = 0; i < rest_.size(); ++i) rest_[i] = options.restFromObject * mesh.positions[i];
    }

    Surface build() {
        makeSurfaceVertices();
        makeFits({mesh_, canonical_, rest_, cornerSurface_, surfaceNormal_}, options_, surface_);
        makeWeightGradients();
        makeRenderVertices();
        makeTriangles();
        return std::move(surface_);
    }

  private:
    /// The corner triangle (this, next, previous) of a polygon's corner.
    struct Corner {
        Index self, next, previous; // corner numbers in the mesh
    };
    [[nodiscard]] Corner corner(std::size_t face, Index k) const {
        const Index begin = mesh_.faceOffsets[face];
        const Index count = mesh_.faceOffsets[face + 1] - begin;
        return {begin + k, begin + (k + 1) % count, begin + (k + count - 1) % count};
    }
    [[nodiscard]] const Vec3 &restAt(Index cornerNumber) const { return rest_[mesh_.cornerPositions[cornerNumber]]; }

    template <class F> void forEachCorner(const F &f) const {
        for (std::size_t face = 0; face < mesh_.faceCount(); ++face) {
            const Index count = mesh_.faceOffsets[face + 1] - mesh_.faceOffsets[face];
            for (Index k = 0; k < count; ++k) f(face, corner(face, k));
        }
    }

    [[nodiscard]] std::vector<Vec3> facePoints(std::size_t face) const {
        std::vector<Vec3> points;
        for (Index c = mesh_.faceOffsets[face]; c < mesh_.faceOffsets[face + 1]; ++c) points.push_back(restAt(c));
        return points;
    }

    /// What a face's normal counts: 1, less for a sliver, whose normal is what rounding left of it and whose angle may be pi.
    static float normalWeight(std::span<const Vec3> points, float twiceArea) {
        float longest = 0;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Vec3 edge = points[(k + 1) % points.size()] - points[k];
            longest = std::max(longest, glm::dot(edge, edge));
        }
        return std::min(1.0F, twiceArea / (kFlatSliver * longest + kTiny));
    }

    /// NormalsFollowWinding.
    [[nodiscard]] bool isTurned(Index cornerNumber) const { return !turned_.empty() && turned_[cornerNumber] != 0; }

    /// Rest normal of each corner, unit, rest space.
    [[nodiscard]] std::vector<Vec3> cornerNormals() {
        std::vector<Vec3> result(mesh_.cornerCount(), Vec3(0));
        std::vector<Vec3> smooth(mesh_.positions.size(), Vec3(0));
        std::vector<Vec3> faceNormals(mesh_.faceCount());
        std::vector<float> say(mesh_.faceCount());
        for (std::size_t face = 0; face < mesh_.faceCount(); ++face) {
            const std::vector<Vec3> points = facePoints(face);
            const Vec3 normal = polygonNormal(points);
            const float length = glm::length(normal);
            faceNormals[face] = length > 0 ? normal / length : Vec3(0);
            say[face] = normalWeight(points, length);
            if (!(length > 0)) ++surface_.degenerateFaces;
        }
        // Angle-weighted vertex normals (Thuermer & Wuethrich 1998).
        forEachCorner([&](std::size_t face, const Corner &c) {
            const Vec3 a = restAt(c.next) - restAt(c.self);
            const Vec3 b = restAt(c.previous) - restAt(c.self);
            const float angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
            smooth[canonical_[mesh_.cornerPositions[c.self]]] += faceNormals[face] * (angle * say[face]);
        });
        const Mat3 normalMatrix = glm::transpose(inverseOf(options_.restFromObject)); // normals are covectors
        forEachCorner([&](std::size_t face, const Corner &c) {
            Vec3 n(0);
            const Index given = mesh_.cornerNormals.empty() ? kNone : mesh_.cornerNormals[c.self];
            if (given != kNone) // 0 - n: no zero gets a sign, which frames would read
                n = normalMatrix * (isTurned(c.self) ? Vec3(0) - mesh_.normals[given] : mesh_.normals[given]);
            else
                n = options_.smooth ? smooth[canonical_[mesh_.cornerPositions[c.self]]] : faceNormals[face];
            float length = glm::length(n);
            if (!(length > 1e-20F)) {
                n = faceNormals[face];
                length = glm::length(n);
            }
            result[c.self] = length > 0 ? n / length : Vec3(0, 0, 1);
        });
        return result;
    }

    void makeSurfaceVertices() {
        const std::vector<Vec3> normals = cornerNormals();
        const bool onLimit = isLimit(options_);
        cornerSurface_.resize(mesh_.cornerCount());
        std::vector<std::vector<Index>> atPosition(mesh_.positions.size());
        for (Index c = 0; c < mesh_.cornerCount(); ++c) {
            const Index position = canonical_[mesh_.cornerPositions[c]];
            auto &here = atPosition[position];
            // On a limit surface the two sides of a crease keep apart even where it is flat.
            const auto same = std::find_if(here.begin(), here.end(), [&](Index s) {
                return onLimit ? surfaceNormal_[s] == mesh_.cornerNormals[c]
                               : glm::dot(surface_.normals[s], normals[c]) > kSameNormalCosine && isMorphedAlike(s, c);
            });
            if (same != here.end()) {
                cornerSurface_[c] = *same;
                continue;
            }
            cornerSurface_[c] = static_cast<Index>(surface_.normals.size());
            here.push_back(cornerSurface_[c]);
            if (onLimit) surfaceNormal_.push_back(mesh_.cornerNormals[c]);
            surface_.surfacePosition.push_back(position);
            surface_.normals.push_back(normals[c]);
            if (morphsNormals_) surface_.morphedNormals.push_back(mesh_.cornerNormals[c]);
        }
    }

    /// Whether morphs do to a corner's normal what they do to a surface vertex's.
    [[nodiscard]] bool isMorphedAlike(Index surfaceVertex, Index cornerNumber) const {
        if (!morphsNormals_) return true;
        const Index a = surface_.morphedNormals[surfaceVertex];
        const Index b = mesh_.cornerNormals[cornerNumber];
        if (a == kNone || b == kNone) return a == b;
        return std::all_of(mesh_.morphs.begin(), mesh_.morphs.end(), [&](const MorphTarget &morph) {
            return morph.normalDeltas.empty() || glm::distance(morph.normalDeltas[a], morph.normalDeltas[b]) < kSameNormalDelta;
        });
    }

    void makeWeightGradients() {
        const SkinWeights &skin = mesh_.skin;
        if (skin.empty()) return;
        surface_.weightGradientOffsets.assign(1, 0);
        std::map<Index, Vec2> sums;
        for (std::size_t s = 0; s < surface_.normals.size(); ++s) {
            sums.clear();
            for (Index k = surface_.stencilOffsets[s]; k < surface_.stencilOffsets[s + 1]; ++k) {
                const Index position = surface_.stencilPositions[k];
                for (Index i = skin.offsets[position]; i < skin.offsets[position + 1]; ++i)
                    sums[skin.joints[i]] += surface_.stencilWeights[k] * skin.weights[i];
            }
            for (const auto &[joint, gradient] : sums) {
                if (gradient == Vec2(0)) continue;
                surface_.weightGradientJoints.push_back(joint);
                surface_.weightGradients.push_back(gradient);
            }
            surface_.weightGradientOffsets.push_back(static_cast<Index>(surface_.weightGradients.size()));
        }
        findHinges(skin, surface_);
    }

    /// A render vertex while it is made: dP/du summed over the faces that share it.
    struct VertexSum {
        Index surface, uv, tangent, mapTangent, color;
        bool mirrored, turned;
        Vec3 dPdu;
    };

    void makeRenderVertices() {
        makeMapTangents();
        std::map<std::tuple<Index, Index, Index, bool, Index>, Index> known;
        std::vector<VertexSum> sums;
        cornerVertex_.resize(mesh_.cornerCount());
        const auto attribute = [](const std::vector<Index> &indices, Index c) { return indices.empty() ? kNone : indices[c]; };
        forEachCorner([&](std::size_t face, const Corner &c) {
            const Index uv = attribute(mesh_.cornerUvs, c.self);
            const Index tangent = attribute(mesh_.cornerTangents, c.self);
            const Index mapTangent = attribute(mapTangents_.corners, c.self);
            Vec3 dPdu(0);
            const bool mirrored = uv != kNone && cornerDerivative(face, c, dPdu);
            const Index color = attribute(mesh_.cornerColors, c.self);
            const auto [at, isNew] = known.try_emplace(
                {cornerSurface_[c.self], uv, mapTangent == kNone ? tangent : mapTangent, mirrored, color}, static_cast<Index>(sums.size()));
            if (isNew) sums.push_back({cornerSurface_[c.self], uv, tangent, mapTangent, color, mirrored, isTurned(c.self), Vec3(0)});
            sums[at->second].dPdu += dPdu;
            cornerVertex_[c.self] = at->second;
        });
        joinTangents(sums);
        const bool hasUvs = !mesh_.cornerUvs.empty();
        for (const VertexSum &sum : sums) {
            surface_.vertexSurface.push_back(sum.surface);
            if (!mesh_.cornerTangents.empty()) surface_.vertexTangents.push_back(sum.tangent);
            if (hasUvs) surface_.uvs.push_back(sum.uv == kNone ? Vec2(0) : mesh_.uvs[sum.uv]);
            if (hasUvs && !mesh_.uvs1.empty()) surface_.uvs1.push_back(sum.uv == kNone ? Vec2(0) : mesh_.uvs1[sum.uv]);
            if (!mesh_.cornerColors.empty()) surface_.colors.push_back(sum.color == kNone ? Vec4(1) : mesh_.colors[sum.color]);
            surface_.tangentCoefficients.push_back(restFrame(sum));
            surface_.mirroredVertices += sum.mirrored ? 1 : 0;
            surface_.turnedVertices += sum.turned ? 1 : 0;
        }
    }

    void makeMapTangents() {
        if (!options_.mapTangents || !mesh_.cornerTangents.empty() || mesh_.cornerUvs.empty()) return;
        std::vector<Vec3> normals(mesh_.cornerCount());
        for (Index c = 0; c < normals.size(); ++c) normals[c] = surface_.normals[cornerSurface_[c]];
        mapTangents_ = tangentSpace(mesh_, rest_, normals);
    }

    /// Where the UV map runs on across a seam (a texture that wraps), each side sees half of the faces around a vertex: the halves
    /// are put together, so that the tangent field does not jump.
    static void joinTangents(std::vector<VertexSum> &sums) {
        std::map<Index, std::vector<Index>> atSurface;
        for (Index v = 0; v < sums.size(); ++v) atSurface[sums[v].surface].push_back(v);
        for (const auto &[surfaceVertex, vertices] : atSurface) {
            if (vertices.size() < 2) continue;
            std::vector<Vec3> joined;
            for (const Index v : vertices) {
                Vec3 total(0);
                for (const Index other : vertices) {
                    const float lengths = glm::length(sums[v].dPdu) * glm::length(sums[other].dPdu);
                    const bool same =
                        sums[v].mirrored == sums[other].mirrored && glm::dot(sums[v].dPdu, sums[other].dPdu) > kSameTangentCosine * lengths;
                    if (v == other || same) total += sums[other].dPdu;
                }
                joined.push_back(total);
            }
            for (std::size_t i = 0; i < vertices.size(); ++i) sums[vertices[i]].dPdu = joined[i];
        }
    }

    /// dP/du of a corner triangle weighted by its area; returns true where the UV map is mirrored there.
    bool cornerDerivative(std::size_t face, const Corner &c, Vec3 &dPdu) const {
        const Index uv1 = mesh_.cornerUvs[c.next];
        const Index uv2 = mesh_.cornerUvs[c.previous];
        if (uv1 == kNone || uv2 == kNone) return false;
        const Vec2 d1 = mesh_.uvs[uv1] - mesh_.uvs[mesh_.cornerUvs[c.self]];
        const Vec2 d2 = mesh_.uvs[uv2] - mesh_.uvs[mesh_.cornerUvs[c.self]];
        const float det = d1.x * d2.y - d1.y * d2.x;
        if (!std::isfinite(det)) return false;
        if (det == 0) return faceMirrored(face);
        const Vec3 e1 = restAt(c.next) - restAt(c.self);
        const Vec3 e2 = restAt(c.previous) - restAt(c.self);
        const float area = glm::length(glm::cross(e1, e2));
        const Vec3 derivative = (e1 * d2.y - e2 * d1.y) * (det < 0 ? -1.0F : 1.0F);
        const float length = glm::length(derivative);
        if (length > 0) dPdu = derivative * (area / length);
        return det < 0;
    }

    /// Orientation of a whole face's UV polygon, for corners whose own triangle has no UV area.
    [[nodiscard]] bool faceMirrored(std::size_t face) const {
        float area = 0;
        const Index begin = mesh_.faceOffsets[face];
        const Index end = mesh_.faceOffsets[face + 1];
        for (Index c = begin; c < end; ++c) {
            const Index next = c + 1 == end ? begin : c + 1;
            if (mesh_.cornerUvs[c] == kNone || mesh_.cornerUvs[next] == kNone) return false;
            const Vec2 &a = mesh_.uvs[mesh_.cornerUvs[c]];
            const Vec2 &b = mesh_.uvs[mesh_.cornerUvs[next]];
            area += a.x * b.y - a.y * b.x;
        }
        return area < 0;
    }

    /// (t0, b0) in (e1, e2): an orthonormal frame, mirrored where the UV map is.
    Vec4 restFrame(const VertexSum &sum) {
        const Frame frame = surface_.frameAt(sum.surface);
        Vec3 direction = sum.dPdu;
        float hand = sum.mirrored ? -1.0F : 1.0F;
        if (sum.tangent != kNone) {
            const Vec4 &tangent = mesh_.tangents[sum.tangent];
            direction = options_.restFromObject * Vec3(tangent);
            hand = (tangent.w < 0) != sum.turned ? -1.0F : 1.0F; // the bitangent stays where the file has it
        } else if (sum.mapTangent != kNone) {
            const Vec4 &tangent = mapTangents_.tangents[sum.mapTangent];
            direction = Vec3(tangent);
            hand = tangent.w;
        }
        Vec2 t(frame.toLocal(direction));
        const float length = glm::length(t);
        if (length > 1e-6F * glm::length(direction) && length > 0) {
            t /= length;
        } else { // SmoothFieldNoUv
            t = glm::normalize(Vec2(frame.toLocal(smoothTangentFromNormal(frame.n))));
            ++surface_.fallbackTangents;
        }
        return {t.x, t.y, -hand * t.y, hand * t.x};
    }

    void makeTriangles() {
        std::vector<Index3> local;
        for (std::size_t face = 0; face < mesh_.faceCount(); ++face) {
            local.clear();
            triangulate(facePoints(face), local);
            const Index begin = mesh_.faceOffsets[face];
            for (const Index3 &t : local) {
                surface_.triangles.emplace_back(cornerVertex_[begin + t.x], cornerVertex_[begin + t.y], cornerVertex_[begin + t.z]);
                if (!mesh_.faceMaterials.empty()) surface_.triangleSlots.push_back(mesh_.faceMaterials[face]);
            }
        }
    }

    const Mesh &mesh_;
    const SurfaceOptions &options_;
    Surface surface_;
    std::vector<unsigned char> turned_; // [corners] cornersAgainstWinding()
    bool morphsNormals_ = false;        // morphs say what normals do
    std::vector<Index> canonical_;      // position -> welded position
    std::vector<Vec3> rest_;            // rest space
    std::vector<Index> cornerSurface_;  // corner -> surface vertex
    std::vector<Index> surfaceNormal_;  // surface vertex -> normal, on a limit surface
    std::vector<Index> cornerVertex_;   // corner -> render vertex
    TangentSpace mapTangents_;          // TangentOfMaps
};

} // namespace

Surface buildSurface(const Mesh &mesh, const SurfaceOptions &options) {
    float size = 0;
    for (int c = 0; c < 3; ++c) size = std::fmax(size, glm::length(options.restFromObject[c]));
    const int exponent = std::ilogb(size);
    if (std::abs(exponent) <= kPlainScale) return Builder(mesh, options).build();
    // Squares of areas leave float: the rest shape is built near its own size, and what has a length in it is scaled back, exactly.
    SurfaceOptions near = options;
    near.restFromObject *= std::ldexp(1.0F, -exponent);
    Surface surface = Builder(mesh, near).build();
    surface.restFromObject = options.restFromObject;
    for (std::vector<Vec2> *weights : {&surface.stencilWeights, &surface.weightGradients})
        for (Vec2 &w : *weights) w *= std::ldexp(1.0F, -exponent);
    for (RingFace &face : surface.ringFaces) face.fromEdges *= std::ldexp(1.0F, -exponent);
    return surface;
}

void compact(Surface &surface, bool fits) {
    if (!fits) keepHinges(surface);
    const auto shrink = [](auto &...arrays) { (arrays.shrink_to_fit(), ...); };
    shrink(surface.triangles, surface.triangleSlots, surface.vertexSurface, surface.uvs, surface.uvs1, surface.colors,
           surface.vertexTangents, surface.tangentCoefficients, surface.surfacePosition, surface.normals, surface.morphedNormals,
           surface.stencilOffsets, surface.stencilPositions, surface.stencilWeights, surface.stencilPoints, surface.slope,
           surface.ringOffsets, surface.ringFaces, surface.ringTilts, surface.weightGradientOffsets, surface.weightGradientJoints,
           surface.weightGradients, surface.hinges);
}

} // namespace taut
