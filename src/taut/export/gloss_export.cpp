#include "taut/export/gloss_export.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"
#include "taut/deform/stored_gloss.h"
#include "taut/microsurface/roughening.h"
#include "taut/scene/material_gloss.h"

#include <array>
#include <atomic>
#include <map>

namespace taut {

namespace {

constexpr std::size_t kGrain = 2048;

GlossMaterial toGlossMaterial(const Material &from) {
    GlossMaterial out;
    out.name = from.name;
    out.color = from.color.value;
    out.ior = from.ior;
    const BsdfInfo &info = bsdfInfo(from.type);
    out.metal = info.reads(kMetallicKey) ? from.metallic.value > 0.5F : info.compensates();
    if (from.type == BsdfType::Metal)
        for (int c = 0; c < 3; ++c) { // reflectance at normal incidence
            const float k2 = sqr(from.conductorK[c]);
            out.color[c] = (sqr(from.conductorEta[c] - 1) + k2) / (sqr(from.conductorEta[c] + 1) + k2);
        }
    return out;
}

/// Vertices for each pair of render vertex and material, and triangles on them.
void makeVertices(const Scene &scene, GlossObject &out) {
    const Surface &surface = out.surface.surface;
    GlossMesh &mesh = out.mesh;
    std::map<Index, Index> localMaterial;                     // scene material -> mesh.materials
    std::map<std::pair<Index, Index>, Index> furtherVertices; // (render vertex, material) -> vertex
    std::vector<Index> firstVertex(surface.vertexCount(), kNone);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const Index material = materialOfTriangle(out.surface, static_cast<Index>(t));
        const auto [local, isNew] = localMaterial.try_emplace(material, static_cast<Index>(mesh.materials.size()));
        if (isNew) mesh.materials.push_back(toGlossMaterial(scene.materialAt(material)));
        Index3 triangle;
        for (int k = 0; k < 3; ++k) {
            const Index source = surface.triangles[t][k];
            const auto next = static_cast<Index>(out.sources.size());
            if (firstVertex[source] == kNone) {
                firstVertex[source] = triangle[k] = next;
            } else if (out.materials[firstVertex[source]] == material) {
                triangle[k] = firstVertex[source];
                continue;
            } else {
                const auto [found, added] = furtherVertices.try_emplace({source, material}, next);
                triangle[k] = found->second;
                if (!added) continue;
            }
            out.sources.push_back(source);
            out.materials.push_back(material);
        }
        mesh.triangles.push_back(triangle);
        mesh.triangleMaterials.push_back(local->second);
    }
    for (const Index source : out.sources) {
        mesh.restPositions.push_back(out.surface.mesh().positions[surface.surfacePosition[surface.vertexSurface[source]]]);
        if (!surface.uvs.empty()) mesh.uvs.push_back(surface.uvs[source]);
    }
}

void resizeFrame(GlossMesh &mesh, std::size_t count, bool convention) {
    for (auto *array : {&mesh.positions, &mesh.normals, &mesh.ds, &mesh.dt, &mesh.m, &mesh.stretch, &mesh.stretchDirection, &mesh.alpha,
                        &mesh.alphaDirection})
        array->resize(count);
    mesh.tangents.resize(count);
    mesh.lean.resize(count, Vec2(0));
    if (convention) mesh.conventionValues.resize(count);
}

/// The world from which the object's placement is taken out again.
DMat4 objectFromWorld(const Object &object, double frame) {
    const DMat4 placement = placementAt(object.placement, frame);
    if (orientationOf(DMat3(placement)) == 0)
        throw RunError("mesh '" + object.name + "': its placement at frame " + std::to_string(frame) +
                       " is flat, so it has no positions in object space");
    return glm::inverse(placement);
}

/// Rest frame of a render vertex in object space: the normal is a covector, the tangent a vector of rest space.
void restFrame(const Surface &surface, const Mat3 &objectFromRest, Index source, Vec3 &normal, Vec3 &tangent) {
    const Index s = surface.vertexSurface[source];
    const Frame frame = surface.frameAt(s);
    normal = glm::normalize(glm::transpose(surface.restFromObject) * frame.n);
    tangent = glm::normalize(objectFromRest * tangentsFrom(surface.tangentCoefficients[source], frame.s, frame.t).ds);
}

} // namespace

void prepareGlossObject(const Scene &scene, const Object &object, GlossObject &out) {
    prepareObjectSurface(object, scene.render.fps, out.surface);
    out.rigid = isRigid(object);
    out.mesh.name = object.name;
    makeVertices(scene, out);
}

void glossAtFrame(const Scene &scene, double frame, const GlossOptions &options, GlossObject &out) {
    const Object &object = *out.surface.object;
    double ignored = 0;
    surfaceAtFrame(out.surface, frame, scene.render.fps, DMat4(1), ignored, ignored);
    const Surface &surface = out.surface.surface;
    const DeformedVertices &from = out.surface.vertices;
    GlossMesh &mesh = out.mesh;
    mesh.convention = options.convention;
    resizeFrame(mesh, out.sources.size(), options.convention != nullptr);
    if (out.flipped.empty()) out.flipped.resize(mesh.triangles.size(), 0);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const unsigned char flip = out.surface.isMirrored(t) && !options.restPositions ? 1 : 0;
        if (flip != out.flipped[t]) std::swap(mesh.triangles[t].y, mesh.triangles[t].z);
        out.flipped[t] = flip;
    }
    const Mat3 objectFromRest = inverseOf(surface.restFromObject);
    const bool follows = object.follow && !out.rigid;
    const bool leans = follows && object.lean && !out.surface.gradient.normalImage.empty();
    const bool stored = hasStoredGloss(out.surface.mesh(), surface);
    std::atomic<std::size_t> clipped{0};
    parallelFor(out.sources.size(), kGrain, [&](std::size_t v) {
        const Index source = out.sources[v];
        const Vec3 n = from.normals[source];
        const Vec3 ds = from.ds[source];
        const Vec3 dt = from.dt[source];
        const PolarGradient polar = polarGradient(ds, dt, n);
        const float length = glm::length(ds);
        const Vec3 s = length > 0 ? ds / length : Vec3(polar.tangent);
        const Vec3 t = glm::cross(n, s);
        // V and R t0 in (s, t), as shading has them at a hit.
        const auto [vss, vst, vtt] =
            std::array{glm::dot(s, polar.stretch.times(s)), glm::dot(t, polar.stretch.times(s)), glm::dot(t, polar.stretch.times(t))};
        const Vec2 turned = object.follow ? Vec2(glm::dot(s, Vec3(polar.tangent)), glm::dot(t, Vec3(polar.tangent))) : Vec2(1, 0);
        const Material &material = scene.materialAt(out.materials[v]);
        Vec3 stretch = follows ? Vec3(vss, vst, vtt) : Vec3(1, 0, 1);
        Vec2 column(0);
        if (leans) {
            const Lean lean = leanOf(out.surface.gradient.normalImage[surface.vertexSurface[source]], n);
            stretch *= lean.inverseLambda;
            column = {glm::dot(s, lean.tangential), glm::dot(t, lean.tangential)};
        }
        RestRoughness rest = restRoughness(material, scene, mesh.uvs.empty() ? Vec2(0) : mesh.uvs[v]);
        if (!out.restAlphas.empty()) rest = {out.restAlphas[v].x, out.restAlphas[v].y, rest.rotation};
        MicroTransform m = transformAt(material, rest, stretch, turned, polar.tangent.w, object.lean ? &column : nullptr);
        if (stored) {
            const StoredColumns columns = storedColumns(out.surface.mesh(), surface, source, ds, dt, n, object.follow, material.poisson);
            m = microTransform(glm::dot(s, columns.x), glm::dot(s, columns.y), glm::dot(t, columns.x), glm::dot(t, columns.y));
        }
        const Vec2 sigma = singularValues(vss, vst, vst, vtt);
        if (follows && !stored && material.roughening > 0)
            m = roughened(m, addedAlpha(equivalentStrain(static_cast<double>(sigma.x), static_cast<double>(sigma.y)),
                                        static_cast<double>(material.roughening), static_cast<double>(material.yield)));
        mesh.positions[v] = from.positions[source];
        mesh.normals[v] = n;
        mesh.tangents[v] = Vec4(s, polar.tangent.w);
        mesh.ds[v] = ds;
        mesh.dt[v] = dt;
        mesh.m[v] = {m.a, m.b, m.d};
        mesh.lean[v] = {m.p, m.q};
        mesh.stretch[v] = {sigma.x, sigma.y, std::fabs(glm::dot(glm::cross(ds, dt), n))};
        const float stretchAngle = 0.5F * std::atan2(2 * vst, vss - vtt);
        const EquivalentAlpha alpha = equivalentAlpha(m);
        mesh.alpha[v] = {alpha.max, alpha.min, alpha.phi};
        Vec3 restNormal = n;
        Vec3 restTangent = s;
        if (options.restPositions) {
            restFrame(surface, objectFromRest, source, restNormal, restTangent);
            mesh.positions[v] = mesh.restPositions[v];
            mesh.normals[v] = restNormal;
            mesh.tangents[v] = Vec4(restTangent, polar.tangent.w);
        }
        mesh.stretchDirection[v] = s * std::cos(stretchAngle) + t * std::sin(stretchAngle);
        mesh.alphaDirection[v] = restTangent * std::cos(alpha.phi) + glm::cross(restNormal, restTangent) * std::sin(alpha.phi);
        if (options.convention != nullptr) {
            const ConventionValues values = toConvention(options.convention->convention, alpha);
            mesh.conventionValues[v] = {values.roughness, values.anisotropy, values.rotation};
            if (values.clipped && bsdfInfo(scene.materialAt(out.materials[v]).type).microsurface)
                clipped.fetch_add(1, std::memory_order_relaxed);
        }
    });
    out.clipped += clipped;
}

void pointsAtFrame(const Scene &scene, double frame, PointSpace space, GlossObject &object, std::vector<Vec3> &out) {
    const Object &source = *object.surface.object;
    const DMat4 target = space == PointSpace::Object ? objectFromWorld(source, frame) : DMat4(1);
    ObjectSurface &surface = object.surface;
    motionAtFrame(source, frame, scene.render.fps, target, surface.motion);
    evaluatePositions(surface.motion.state, source.mesh->skin, surface.subdivision ? surface.cage : out);
    if (surface.subdivision) applyStencils(surface.subdivision->positions, surface.cage, out);
}

} // namespace taut
