// Rigid is what the matrices say: rotations below non-uniform scales deform, and placements of any scale give a picture.

#include "assets.h"
#include "catch.h"
#include "cli_fixtures.h"
#include "render_fixtures.h"

#include "taut/export/gloss_export.h"
#include "taut/scene/load_scene.h"

#include <numeric>

using namespace taut;
using namespace taut::test;

namespace {

GlossMesh glossOf(const Scene &scene, const Object &object, double frame) {
    GlossObject out;
    prepareGlossObject(scene, object, out);
    glossAtFrame(scene, frame, {}, out);
    return out.mesh;
}

/// An object carried by a chain of nodes, from the root on; channels name nodes by their place in it.
Object chained(Mesh mesh, std::vector<Node> nodes, std::vector<Channel> channels) {
    auto rig = std::make_shared<Rig>();
    for (Index i = 0; i < nodes.size(); ++i) nodes[i].parent = i == 0 ? kNone : i - 1;
    rig->nodes = std::move(nodes);
    rig->clips = {{"clip", std::move(channels), 1}};
    Object object = makeObject(std::move(mesh));
    object.rig = RigMotion{rig, static_cast<Index>(rig->nodes.size() - 1), 0, false};
    return object;
}

Node scaled(const DVec3 &scale) {
    Node node;
    node.scale = scale;
    return node;
}

/// From no turn to `angle` about `axis` in one second.
Channel turning(Index node, const Vec3 &axis, float angle) {
    Channel channel{node, ChannelPath::Rotation, Interpolation::Linear, 4, {0, 1}, {0, 0, 0, 1}};
    const Vec3 v = axis * std::sin(angle / 2);
    channel.values.insert(channel.values.end(), {v.x, v.y, v.z, std::cos(angle / 2)});
    return channel;
}

Channel scaling(Index node, const Vec3 &from, const Vec3 &to) {
    return {node, ChannelPath::Scale, Interpolation::Linear, 3, {0, 1}, {from.x, from.y, from.z, to.x, to.y, to.z}};
}

Scene sceneOf(Object object) {
    Scene scene = smallScene(std::move(object), ggxMaterial(0.25F, 0.25F), 16);
    scene.render.frames = {1, 25};
    return scene;
}

} // namespace

TEST_CASE("A rotation under a constant non-uniform scale deforms: the case", "[rest][placement][cases]") {
    const auto path = caseFile("rotating-under-scale/rotating_under_nonuniform_scale.gltf");
    if (!path) return;
    Warnings warnings;
    const Scene scene = loadScene(*path, {}, warnings);
    CHECK_FALSE(isRigid(scene.objects[0]));
    const GlossMesh rest = glossOf(scene, scene.objects[0], 1);
    const GlossMesh turned = glossOf(scene, scene.objects[0], 25);
    for (std::size_t v = 0; v < turned.vertexCount(); ++v) {
        CHECK(rest.alpha[v].x == Approx(0.25).epsilon(1e-5));
        CHECK(turned.stretch[v].x == Approx(2).epsilon(1e-5));
        CHECK(turned.stretch[v].y == Approx(0.5).epsilon(1e-5));
        CHECK(turned.alpha[v].x == Approx(0.5).epsilon(1e-5));
        CHECK(turned.alpha[v].y == Approx(0.125).epsilon(1e-5));
    }
}

TEST_CASE("A rotation under a scene's non-uniform scale deforms; normals are the deformed surface's", "[rest][placement]") {
    // World = S R(t) of a sphere; S = diag(1, 1, 3). Relative to the rest shape S: A = S R S^-1, normals S^-1 R n0.
    const DVec3 scale(1, 1, 3);
    const float angle = 1.2F;
    Object object = chained(makeSphere(24, 12, 1), {scaled(DVec3(1))}, {turning(0, Vec3(1, 0, 0), angle)});
    object.placement.scale = Keyed<DVec3>(scale);
    const Scene scene = sceneOf(object);
    REQUIRE_FALSE(isRigid(scene.objects[0]));
    GlossObject out;
    prepareGlossObject(scene, scene.objects[0], out);
    glossAtFrame(scene, 25, {}, out);
    const DMat3 s(DVec3(1, 0, 0), DVec3(0, 1, 0), DVec3(0, 0, 3));
    const double c = std::cos(static_cast<double>(angle));
    const double sine = std::sin(static_cast<double>(angle));
    const DMat3 r(DVec3(1, 0, 0), DVec3(0, c, sine), DVec3(0, -sine, c));
    const DMat3 a = s * r * glm::inverse(s);
    double worstNormal = 0;
    double worstAlpha = 0;
    for (std::size_t v = 0; v < out.mesh.vertexCount(); ++v) {
        const DVec3 p(out.mesh.restPositions[v]); // on the unit sphere: its own normal
        worstNormal = std::max(worstNormal, glm::length(DVec3(out.mesh.normals[v]) - glm::normalize(glm::inverse(s) * r * p)));
        // Singular values of A on the tangent plane at rest, whose normal is S^-1 p.
        const DVec3 n0 = glm::normalize(glm::inverse(s) * p);
        const DVec3 e1 = glm::normalize(glm::cross(std::fabs(n0.x) < 0.7 ? DVec3(1, 0, 0) : DVec3(0, 1, 0), n0));
        const DVec3 f1 = a * e1;
        const DVec3 f2 = a * glm::cross(n0, e1);
        const double half = 0.5 * (glm::dot(f1, f1) + glm::dot(f2, f2));
        const double radius = std::hypot(0.5 * (glm::dot(f1, f1) - glm::dot(f2, f2)), glm::dot(f1, f2));
        worstAlpha = std::max(worstAlpha, std::fabs(static_cast<double>(out.mesh.alpha[v].y) * std::sqrt(half + radius) / 0.25 - 1));
        worstAlpha = std::max(worstAlpha, std::fabs(static_cast<double>(out.mesh.alpha[v].x) * std::sqrt(half - radius) / 0.25 - 1));
    }
    CHECK(worstNormal < 2e-5);
    CHECK(worstAlpha < 2e-4);
}

TEST_CASE("Rigid is what the matrices say over the frames, not the kind of channel", "[rest][placement][rigid]") {
    const Mesh grid = makeGrid(2, 2, 1);
    const auto rigid = [&](std::vector<Node> nodes, std::vector<Channel> channels) {
        return isRigid(chained(grid, std::move(nodes), std::move(channels)));
    };
    const Vec3 z(0, 0, 1);
    CHECK(rigid({scaled({2, 2, 2}), scaled({1, 3, 1})}, {turning(0, z, 1), turning(1, z, 2)})); // non-uniform below all rotations
    CHECK(rigid({scaled({2, 2, 1}), scaled({1, 1, 1})}, {turning(1, z, 2)}));                   // turns within the two equal directions
    CHECK(rigid({scaled({-1, 1, 1}), scaled({1, 1, 1})}, {turning(1, z, 2)}));                  // a mirror is no stretch
    CHECK(rigid({scaled({2, 1, 1})}, {scaling(0, {3, 1, 1}, {3, 1, 1})}));                      // a scale channel that holds still
    CHECK_FALSE(rigid({scaled({2, 1, 1}), scaled({1, 1, 1})}, {turning(1, z, 2)}));
    CHECK_FALSE(rigid({scaled({2, 1, 1}), scaled({1, 1, 1})}, {turning(1, z, 3.1415927F)})); // the same at both keys, not between
    CHECK_FALSE(rigid({scaled({2, 1, 1}), scaled({1, 1, 1}), scaled({1, 1, 1})}, {turning(1, z, 1)}));
    CHECK_FALSE(rigid({scaled({1, 1, 1})}, {scaling(0, {1, 1, 1}, {2, 2, 2})}));
    Node sheared;
    sheared.matrix = DMat4(1);
    (*sheared.matrix)[1][0] = 0.5;
    CHECK_FALSE(rigid({sheared, scaled({1, 1, 1})}, {turning(1, z, 1)}));
    CHECK(rigid({sheared, scaled({1, 1, 1})}, {}));
    Object placed = makeObject(grid);
    placed.placement.scale = Keyed<DVec3>(DVec3(1, 2, 3));
    placed.placement.rotation.keys = {{1, DVec3(0)}, {5, DVec3(1, 2, 3)}};
    CHECK(isRigid(placed)); // world = T R S: the rotation comes after
}

TEST_CASE("Two scales over time that undo each other leave an object rigid", "[rest][placement][rigid]") {
    Channel up{0, ChannelPath::Scale, Interpolation::Step, 3, {0, 1}, {1, 1, 1, 2, 2, 2}};
    Channel down{1, ChannelPath::Scale, Interpolation::Step, 3, {0, 1}, {1, 1, 1, 0.5F, 0.5F, 0.5F}};
    CHECK(isRigid(chained(makeGrid(2, 2, 1), {scaled(DVec3(1)), scaled(DVec3(1))}, {up, down})));
}

TEST_CASE("A placement that turns over between two frames is no instance", "[rest][placement][rigid]") {
    const Channel flip{0, ChannelPath::Scale, Interpolation::Step, 3, {0, 1}, {1, 1, 1, -1, 1, 1}};
    CHECK_FALSE(isRigid(chained(makeGrid(2, 2, 1), {scaled(DVec3(1))}, {flip})));
}

TEST_CASE("An instance and a deformed mesh agree about what a rotation under a scale looks like", "[rest][placement][render]") {
    // One surface, moved by a rotation under diag(2, 1, 1) and by the stretched mesh's own positions with fitted gradients.
    Object carried = chained(makeGrid(6, 6, 1), {scaled(DVec3(2, 1, 1)), scaled(DVec3(1))}, {turning(1, Vec3(0, 0, 1), 1)});
    const Scene scene = sceneOf(carried);
    Object fitted = carried;
    fitted.gradient = GradientEstimator::Area;
    const std::vector<float> a = renderImage(scene, 25, 16);
    const std::vector<float> b = renderImage(sceneOf(fitted), 25, 16);
    CHECK(greatestDifference(a, b, 0.05F) < 0.02F);
}

TEST_CASE("Placements of any scale give a picture: the case", "[rest][placement][cases]") {
    const auto path = caseFile("flat-placement/scale_flat.gltf");
    if (!path) return;
    const Workplace place("flat_case");
    const Arguments small{"-D", "render.width=24", "-D", "render.height=16", "--spp", "2", "-q"};
    Arguments frames{"render", *path, "--frames", "1,2", "-o", place.path("f.##.exr")};
    frames.insert(frames.end(), small.begin(), small.end());
    requireSuccess(runTaut(frames));
    Arguments blurred{"render", *path, "-D", "render.shutter=0.5", "-o", place.path("b.exr")};
    blurred.insert(blurred.end(), small.begin(), small.end());
    requireSuccess(runTaut(blurred));
    for (const std::string name : {"f.01.exr", "f.02.exr", "b.exr"})
        for (const float value : readImage(place.path(name)).values) REQUIRE(std::isfinite(value));
}

TEST_CASE("Placements of any scale give a picture", "[rest][placement][collapse]") {
    const std::vector<DVec3> scales{{1, 0, 1}, {0, 0, 0},     {1e-20, 1e-20, 1e-20}, {1e12, 1e12, 1e12},  {-1, 1, 1},  {-1, 0, 1},
                                    {0, 0, 1}, {1, 1e-20, 1}, {1e12, 1, 1e-12},      {-1e12, 1e12, 1e12}, {1e-9, 2, 1}};
    const DVec3 scale = GENERATE_REF(from_range(scales));
    const bool animated = GENERATE(false, true);
    const double shutter = GENERATE(0.0, 0.5);
    const int kind = GENERATE(0, 1, 2, 3);
    Object object = makeObject(makeSphere(12, 6, 1));
    if (kind == 0) object.placement.scale = Keyed<DVec3>(scale);
    if (kind == 1) object.placement.scale.keys = {{1, DVec3(0)}, {2, scale}}; // growing from zero
    if (kind == 2) object = chained(makeSphere(12, 6, 1), {scaled(scale), scaled(DVec3(1))}, {turning(1, Vec3(0, 0, 1), 1)});
    if (kind == 3) {
        object.subdivision.level = 1;
        object.placement.scale = Keyed<DVec3>(scale);
    }
    if (kind != 2) object.placement.rotation.keys = {{1, DVec3(0)}, {2, DVec3(0.3, 0.2, 0.1)}};
    object.emission.value = Vec3(0.1F);
    Scene scene = smallScene(object, ggxMaterial(0.25F, 0.4F), 12);
    scene.objects.push_back(makeObject(makeGrid(1, 1, 4)));
    scene.objects[1].placement.translation = Keyed<DVec3>(DVec3(0, 0, -1.5));
    scene.render.shutter = shutter;
    scene.render.frames = {1, 2};
    INFO("scale " << scale.x << ' ' << scale.y << ' ' << scale.z << ", animated " << animated << ", shutter " << shutter << ", kind "
                  << kind);
    PlannedScene planned = planScene(scene);
    RenderScene ready(scene, std::move(planned.plan), animated, std::move(planned.surfaces));
    for (const double frame : {1.0, 1.5, 2.0}) {
        ready.setFrame(frame);
        FrameOptions frameOptions;
        frameOptions.spp = 2;
        const FrameResult result = renderFrame(ready, frameOptions);
        CHECK(result.counts.notFinite == 0);
        for (const float value : result.film.resolve()) REQUIRE(std::isfinite(value));
    }
    const GlossMesh gloss = glossOf(scene, scene.objects[0], 1.5);
    for (std::size_t v = 0; v < gloss.vertexCount(); ++v) {
        REQUIRE(isFinite(gloss.normals[v]));
        REQUIRE(glm::length(gloss.normals[v]) == Approx(1).epsilon(1e-4));
        REQUIRE(isFinite(gloss.alpha[v]));
        REQUIRE(isFinite(gloss.m[v]));
    }
}

TEST_CASE("A scene a million million times as large is the same picture", "[rest][placement][render]") {
    const double factor = GENERATE(3.0, 1e-5, 1e9, 1e12);
    Scene near = smallScene(makeObject(makeSphere(24, 12, 1)), ggxMaterial(0.25F, 0.4F), 24);
    near.lights.clear();
    near.environment = constantEnvironment(Vec3(0.7F));
    Scene far = near;
    far.objects[0].placement.scale = Keyed<DVec3>(DVec3(factor));
    far.camera.position = Keyed<DVec3>(near.camera.position.first() * factor);
    const bool smooth = GENERATE(true, false);
    for (Scene *scene : {&near, &far})
        if (!smooth) { // normals of the faces, which the placement has to survive
            Mesh mesh = *scene->objects[0].mesh;
            mesh.cornerNormals.clear();
            scene->objects[0].mesh = std::make_shared<const Mesh>(mesh);
        }
    const std::vector<float> a = renderImage(near, 1, 16);
    const std::vector<float> b = renderImage(far, 1, 16);
    INFO("factor " << factor << ", smooth " << smooth);
    // Rounding turns single paths over, at the outline most: by a factor of 3, which strains nothing, in 1.3 % of the values.
    CHECK(shareOver(a, b, 1e-3F) < 0.05);
    CHECK(std::accumulate(b.begin(), b.end(), 0.0) == Approx(std::accumulate(a.begin(), a.end(), 0.0)).epsilon(1e-3));
}

TEST_CASE("A flat placement keeps the gloss of what stays flat in it", "[rest][placement]") {
    // A plate in the directions that stay: nothing is stretched, so nothing changes, though its own scale is 3.
    Object plate = makeObject(makeGrid(4, 4, 1));
    plate.placement.scale = Keyed<DVec3>(DVec3(3, 3, 0));
    const Scene scene = sceneOf(plate);
    const GlossMesh gloss = glossOf(scene, scene.objects[0], 1);
    for (std::size_t v = 0; v < gloss.vertexCount(); ++v) {
        CHECK(gloss.alpha[v].x == Approx(0.25).epsilon(1e-5));
        CHECK(gloss.alpha[v].y == Approx(0.25).epsilon(1e-5));
        CHECK(std::fabs(gloss.normals[v].z) == Approx(1));
    }
}
