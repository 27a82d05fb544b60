/// What the renderer must not show: the rest tangent field, UV seams, extraordinary vertices; and what it must: the lean.

#include "assets.h"
#include "catch.h"
#include "render_fixtures.h"

#include "taut/base/sobol.h"
#include "taut/formats/point_cache.h"
#include "taut/formats/write_mesh.h"
#include "taut/scene/load_scene.h"

#include <fstream>
#include <map>

using namespace taut;
using namespace taut::test;

namespace {

DeformerKeys deformer(DeformerType type, double amount, int axis, int axis2) {
    DeformerKeys keys;
    keys.type = type;
    keys.amount = Keyed<double>(amount);
    keys.axis = axis;
    keys.axis2 = axis2;
    keys.lower = -2;
    keys.upper = 2;
    return keys;
}

SymmetricTensor between(const SymmetricTensor &a, const SymmetricTensor &b) {
    return {0.5F * (a.diagonal + b.diagonal), 0.5F * (a.offDiagonal + b.offDiagonal)};
}
float difference(const SymmetricTensor &a, const SymmetricTensor &b) {
    const Vec3 d = a.diagonal - b.diagonal;
    const Vec3 o = a.offDiagonal - b.offDiagonal;
    return std::sqrt(glm::dot(d, d) + 2 * glm::dot(o, o));
}

/// Jumps of the interpolated V across the edges of a frame's triangles, relative to |V|: at the middle of the edge, from the triangle
/// on either side; and between the middles of the two triangles.
struct Jumps {
    float onEdge = 0;
    float acrossEdge = 0;
    double rmsAcross = 0;
    float atSeams = 0; ///< between triangle middles, over edges whose sides have render vertices of their own
    std::size_t seams = 0;
};
Jumps jumpsOf(const RenderObject &object) {
    struct Side {
        SymmetricTensor onEdge, middle;
        Index a, b;
    };
    const Surface &surface = object.surface;
    const auto &stretch = object.steps[0].stretch;
    std::map<std::pair<Index, Index>, std::vector<Side>> edges;
    for (const Index3 &t : surface.triangles) {
        const SymmetricTensor middle{(stretch[t.x].diagonal + stretch[t.y].diagonal + stretch[t.z].diagonal) / 3.0F,
                                     (stretch[t.x].offDiagonal + stretch[t.y].offDiagonal + stretch[t.z].offDiagonal) / 3.0F};
        for (int k = 0; k < 3; ++k) {
            Index a = t[k];
            Index b = t[(k + 1) % 3];
            const auto position = [&](Index v) { return surface.surfacePosition[surface.vertexSurface[v]]; };
            if (position(a) > position(b)) std::swap(a, b);
            edges[{position(a), position(b)}].push_back({between(stretch[a], stretch[b]), middle, a, b});
        }
    }
    Jumps jumps;
    std::size_t count = 0;
    for (const auto &[edge, sides] : edges) {
        if (sides.size() != 2) continue;
        const float size = difference(sides[0].onEdge, {Vec3(0), Vec3(0)});
        const float across = difference(sides[0].middle, sides[1].middle) / size;
        jumps.onEdge = std::fmax(jumps.onEdge, difference(sides[0].onEdge, sides[1].onEdge) / size);
        jumps.acrossEdge = std::fmax(jumps.acrossEdge, across);
        jumps.rmsAcross += static_cast<double>(across * across);
        ++count;
        if (sides[0].a == sides[1].a && sides[0].b == sides[1].b) continue;
        ++jumps.seams;
        jumps.atSeams = std::fmax(jumps.atSeams, across);
    }
    jumps.rmsAcross = std::sqrt(jumps.rmsAcross / static_cast<double>(count));
    return jumps;
}

} // namespace

TEST_CASE("Frame independence: jittering the rest tangent field changes no pixel", "[fields][render]") {
    Mesh mesh = makeTorus(48, 24, 0.8F, 0.3F);
    const auto withTangents = [&](bool jittered) {
        Mesh m = mesh;
        m.cornerTangents = m.cornerPositions;
        m.tangents.clear();
        for (Index v = 0; v < m.positions.size(); ++v) {
            const Vec3 p = m.positions[v];
            const Vec3 around = glm::normalize(Vec3(-p.y, p.x, 0));
            const Vec3 n = glm::normalize(p - 0.8F * glm::normalize(Vec3(p.x, p.y, 0)));
            const float angle = jittered ? 6.28F * static_cast<float>(hash(v, 7U)) * 0x1p-32F : 0.0F;
            m.tangents.emplace_back(around * std::cos(angle) + glm::cross(n, around) * std::sin(angle), 1);
        }
        Object object = makeObject(std::move(m));
        object.deformers = {deformer(DeformerType::Shear, 0.8, 0, 2), deformer(DeformerType::Twist, 0.9, 2, 0)};
        Scene scene = smallScene(std::move(object), ggxMaterial(0.15F, 0.15F));
        scene.materials[0].poisson = 0.3F;
        return renderImage(scene, 1, 64);
    };
    const std::vector<float> smooth = withTangents(false);
    CHECK(greatestDifference(smooth, withTangents(true)) < 1e-4F);
}

TEST_CASE("A subdivided, deformed character shows no seam at UV borders or extraordinary vertices", "[fields][assets]") {
    const auto path = asset("static/spot_control_mesh.obj");
    if (!path) return;
    const auto jumpsAt = [&](int level) {
        Warnings warnings;
        Scene scene = loadScene(*path, {"mesh.0.subdivision=" + std::to_string(level)}, warnings);
        scene.objects[0].deformers = {deformer(DeformerType::Shear, 0.7, 0, 2), deformer(DeformerType::Bend, 0.4, 0, 1)};
        RenderScene ready(scene, false);
        StageTimes times;
        ready.setFrame(1, times);
        return jumpsOf(ready.objects()[0]);
    };
    const Jumps coarse = jumpsAt(2);
    const Jumps middle = jumpsAt(3);
    const Jumps fine = jumpsAt(4);
    std::cout << "spot, sheared and bent: jump of V on edges " << fine.onEdge << ", across edges " << coarse.acrossEdge << ", "
              << middle.acrossEdge << ", " << fine.acrossEdge << " (root mean square " << coarse.rmsAcross << ", " << middle.rmsAcross
              << ", " << fine.rmsAcross << ") at levels 2, 3, 4; across " << fine.seams << " seam edges " << fine.atSeams << std::endl;
    CHECK(fine.seams > 100);
    CHECK(fine.onEdge < 1e-6F); // continuous, seams included
    // And smooth: the step between neighbours shrinks with them; its maximum, where the model is tightly curved, more slowly.
    CHECK(fine.rmsAcross < 0.6 * middle.rmsAcross);
    CHECK(middle.rmsAcross < 0.6 * coarse.rmsAcross);
    CHECK(fine.acrossEdge < middle.acrossEdge);
    CHECK(middle.acrossEdge < coarse.acrossEdge);
    CHECK(fine.atSeams <= fine.acrossEdge);
}

TEST_CASE("A leaning mesh takes the deformers' column 3 into M", "[fields][lean]") {
    // Shear of x along z by 0.6 of a plate in z = 0, stretched to twice its height: F n0 = (0.6 * 2, 0, 2).
    Object plate = makeObject(makeGrid(2, 2, 2));
    DeformerKeys tall;
    tall.type = DeformerType::Stretch;
    tall.factor = Keyed<DVec3>(DVec3(1, 1, 2));
    plate.deformers = {tall, deformer(DeformerType::Shear, 0.6, 0, 2)};
    for (const bool lean : {false, true}) {
        plate.lean = lean;
        Scene scene = smallScene(plate, ggxMaterial(0.2F, 0.5F));
        RenderScene ready(scene, false);
        StageTimes times;
        ready.setFrame(1, times);
        const auto materials = prepareMaterials(scene, ready.plan());
        Hit hit;
        hit.geometry = 0;
        hit.primitive = 3;
        hit.u = 0.3F;
        hit.v = 0.2F;
        for (const bool fromAbove : {true, false}) {
            const Vec3 up = Vec3(glm::transpose(DMat3(ready.worldFromRender())) * DVec3(0, 0, fromAbove ? 1 : -1));
            const SurfacePoint point = surfacePointAt(ready, materials, hit, up);
            const MicroTransform &m = point.bsdf.micro;
            // World x seen in the shading frame.
            const Vec3 x = Vec3(glm::transpose(DMat3(ready.worldFromRender())) * DVec3(1, 0, 0));
            const Vec2 along(glm::dot(point.frame.s, x), glm::dot(point.frame.t, x));
            const Vec2 column(m.p, m.q);
            const float sign = fromAbove ? 1.0F : -1.0F;
            CHECK(glm::length(column - along * (lean ? sign * 0.6F : 0.0F)) < 1e-5F);
            // lambda = 2 makes the microsurface twice as rough; without lean the height is the surface's own.
            CHECK(m.det == Approx((lean ? 0.25F : 1.0F) / (0.2F * 0.5F)).epsilon(1e-4));
        }
    }
}

TEST_CASE("A point cache moves a mesh and its gloss", "[fields][cache]") {
    const std::string folder = outputFolder("cache_motion");
    const Mesh sheet = makeGrid(6, 6, 1);
    writeObj(sheet, folder + "/sheet.obj");
    for (const char *name : {"sheet.pc2", "sheet.mdd"}) {
        PointCacheInfo info;
        info.format = std::string(name) == "sheet.pc2" ? PointCacheFormat::Pc2 : PointCacheFormat::Mdd;
        info.points = static_cast<std::uint32_t>(sheet.positions.size());
        info.samples = 3;
        info.firstFrame = 1;
        info.seconds = {0, 1.0F / 24, 2.0F / 24};
        PointCacheWriter writer(folder + "/" + name, info);
        for (int sample = 0; sample < 3; ++sample) {
            std::vector<Vec3> moved = sheet.positions;
            for (Vec3 &p : moved) p.x *= static_cast<float>(1 + sample);
            writer.write(moved);
        }
        writer.finish();
        std::ofstream(folder + "/scene.toml") << "[[mesh]]\nfile = \"sheet.obj\"\ncache = \"" << name << "\"\n";
        Warnings warnings;
        const Scene scene = loadScene(folder + "/scene.toml", {}, warnings);
        for (const auto &[frame, stretch] :
             {std::pair(1.0, 1.0F), std::pair(2.0, 2.0F), std::pair(2.5, 2.5F), std::pair(9.0, 3.0F), std::pair(-2.0, 1.0F)}) {
            const DeformedVertices surface = surfaceOf(scene.objects[0], frame);
            for (const Vec3 &ds : surface.ds) REQUIRE(glm::length(ds) == Approx(stretch).epsilon(1e-4));
            for (const Vec3 &dt : surface.dt) REQUIRE(glm::length(dt) == Approx(1).epsilon(1e-4));
        }
    }
    std::ofstream(folder + "/wrong.toml") << "[[mesh]]\nfile = \"" TAUT_SOURCE_DIR "/meshes/plate.obj\"\ncache = \"sheet.pc2\"\n";
    Warnings warnings;
    CHECK_THROWS_WITH(loadScene(folder + "/wrong.toml", {}, warnings), Catch::Contains("49 points") && Catch::Contains("1089"));
}
