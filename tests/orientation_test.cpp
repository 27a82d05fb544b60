// Which side of a surface is outside: the sign of the map's determinant at each vertex, and the winding where a file's normals contradict
// it. Pictures and exports follow.

#include "catch.h"
#include "render_fixtures.h"
#include "scene_fixtures.h"

#include "taut/export/gloss_export.h"
#include "taut/mesh/winding.h"

using namespace taut;
using namespace taut::test;

namespace {

Vec3 faceNormal(const GlossMesh &mesh, const Index3 &t) {
    return glm::normalize(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

GlossMesh glossOf(const Scene &scene, double frame = 1) {
    GlossObject out;
    prepareGlossObject(scene, scene.objects[0], out);
    glossAtFrame(scene, frame, {}, out);
    return out.mesh;
}

/// A sphere with a joint for each half of it, the halves some way apart, and a joint that moves nothing.
Object jointedSphere(const DVec3 &left, const DVec3 &right, const DVec3 &unused) {
    Mesh mesh = makeSphere(16, 8, 1);
    const std::size_t half = mesh.positions.size();
    const auto corners = static_cast<Index>(mesh.cornerCount());
    const std::size_t faces = mesh.faceCount();
    for (std::size_t i = 0; i < half; ++i) mesh.positions.push_back(mesh.positions[i] + Vec3(4, 0, 0));
    for (Index c = 0; c < corners; ++c) {
        mesh.cornerPositions.push_back(mesh.cornerPositions[c] + static_cast<Index>(half));
        if (!mesh.cornerNormals.empty()) mesh.cornerNormals.push_back(mesh.cornerNormals[c]);
        if (!mesh.cornerUvs.empty()) mesh.cornerUvs.push_back(mesh.cornerUvs[c]);
    }
    for (std::size_t f = 1; f <= faces; ++f) mesh.faceOffsets.push_back(mesh.faceOffsets[f] + corners);
    mesh.skin.offsets = {0};
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        mesh.skin.joints.push_back(i < half ? 1 : 2);
        mesh.skin.weights.push_back(1);
        mesh.skin.offsets.push_back(static_cast<Index>(i + 1));
    }
    auto rig = std::make_shared<Rig>();
    for (const DVec3 &scale : {unused, left, right, DVec3(1)}) {
        Node node;
        node.scale = scale;
        rig->nodes.push_back(node);
    }
    rig->skins = {{"skin", {0, 1, 2}, {DMat4(1), DMat4(1), DMat4(1)}}};
    rig->nodes[3].skin = 0;
    Object object = makeObject(std::move(mesh));
    object.rig = RigMotion{rig, 3, kNone, false};
    return object;
}

} // namespace

TEST_CASE("A mirrored joint turns the faces that it moves, an unused one has no say: the case", "[orientation][cases]") {
    const auto path = caseFile("mirrored-joint/a.glb");
    if (!path) return;
    Warnings warnings;
    const Scene scene = loadScene(*path, {}, warnings);
    const GlossMesh mesh = glossOf(scene);
    for (const Vec3 &n : mesh.normals) CHECK(glm::length(n - Vec3(0, -1, 0)) < 1e-5F);
    for (const Index3 &t : mesh.triangles) CHECK(glm::length(faceNormal(mesh, t) - Vec3(0, -1, 0)) < 1e-5F);
}

TEST_CASE("Each vertex is oriented by its own map", "[orientation]") {
    const DVec3 left = GENERATE(DVec3(1), DVec3(-1, 1, 1));
    const DVec3 right = GENERATE(DVec3(1), DVec3(1, 1, -1), DVec3(-1, -1, 1));
    const DVec3 unused = GENERATE(DVec3(1), DVec3(-1, 1, 1), DVec3(0));
    const int level = GENERATE(0, 1);
    const auto gradient = GENERATE(GradientEstimator::Analytic, GradientEstimator::Area);
    Object object = jointedSphere(left, right, unused);
    object.subdivision.level = level;
    if (level == 0 || gradient == GradientEstimator::Area) object.gradient = gradient;
    const Scene scene = smallScene(object, ggxMaterial(0.2F, 0.3F), 16);
    const GlossMesh mesh = glossOf(scene);
    INFO("left " << left.x << ", right " << right.x << ' ' << right.z << ", unused " << unused.x << ", level " << level);
    const Vec3 centres[] = {Vec3(0), Vec3(4, 0, 0) * Vec3(right)};
    for (const Index3 &t : mesh.triangles) {
        const Vec3 middle = (mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) / 3.0F;
        const Vec3 out = middle - (glm::length(middle - centres[0]) < glm::length(middle - centres[1]) ? centres[0] : centres[1]);
        REQUIRE(glm::dot(faceNormal(mesh, t), out) > 0);
        for (int k = 0; k < 3; ++k) REQUIRE(glm::dot(mesh.normals[t[k]], out) > 0);
    }
}

TEST_CASE("Emission and glass follow the orientation of each half", "[orientation][render]") {
    const bool glass = GENERATE(false, true);
    Material material = ggxMaterial(0.05F, 0.05F);
    if (glass) {
        material.type = BsdfType::Dielectric;
        material.ior = 1.5F;
    }
    const auto imageOf = [&](const DVec3 &left, const DVec3 &right, double move) {
        Object object = jointedSphere(left, right, DVec3(1));
        if (!glass) object.emission.value = Vec3(1);
        Scene scene = smallScene(object, material, 32);
        scene.lights.clear();
        scene.environment = constantEnvironment(Vec3(0.5F));
        scene.camera.position = DVec3(move, -12, 0);
        scene.camera.lookAt = DVec3(move, 0, 0);
        return renderImage(scene, 1, 32);
    };
    // Mirrored in y about its own centre, a ball is the same ball.
    const std::vector<float> plain = imageOf(DVec3(1), DVec3(1), 2);
    const std::vector<float> mixed = imageOf(DVec3(1), DVec3(1, -1, 1), 2);
    CHECK(shareOver(plain, mixed, 0.02F) < 0.2); // noise, and quads split along the other diagonal
    double a = 0;
    double b = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
        a += static_cast<double>(plain[i]);
        b += static_cast<double>(mixed[i]);
    }
    CHECK(b == Approx(a).epsilon(5e-3));
}

TEST_CASE("A deformer that turns space over turns the faces with it", "[orientation]") {
    Object object = makeObject(makeSphere(16, 8, 1));
    object.deformers = {stretchDeformer(DVec3(1, -0.5, 1))};
    const Scene scene = smallScene(object, ggxMaterial(0.2F, 0.3F), 16);
    const GlossMesh mesh = glossOf(scene);
    for (const Index3 &t : mesh.triangles) REQUIRE(glm::dot(faceNormal(mesh, t), mesh.positions[t.x]) > 0);
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) REQUIRE(glm::dot(mesh.normals[v], mesh.positions[v]) > 0);
}

TEST_CASE("Normals that contradict the winding are turned and counted: the case", "[orientation][winding][cases]") {
    const auto flip = caseFile("normals-inward/flip.toml");
    const auto good = caseFile("normals-inward/good.toml");
    if (!flip || !good) return;
    for (const std::string type : {"conductor", "diffuse", "dielectric", "coated"}) {
        const std::vector<std::string> overrides{"material.m.type='" + type + "'", "render.width=16", "render.height=12"};
        Warnings said;
        Warnings silent;
        const Scene a = loadScene(*flip, overrides, said);
        const Scene b = loadScene(*good, overrides, silent);
        INFO(type);
        CHECK(silent.lines.empty());
        REQUIRE(said.lines.size() == 1);
        CHECK(said.lines[0].find("1 of 1 normals") != std::string::npos);
        CHECK(renderImage(a, 1, 4) == renderImage(b, 1, 4));
    }
}

TEST_CASE("Single normals, whole patches and whole meshes against the winding are turned", "[orientation][winding]") {
    const Mesh good = makeSphere(16, 8, 1);
    REQUIRE(cornersAgainstWinding(good).empty());
    const int which = GENERATE(0, 1, 2);
    Mesh bad = good;
    std::size_t turned = 0;
    // Each corner gets a normal of its own, so that patches may disagree.
    bad.normals.clear();
    for (Index c = 0; c < good.cornerCount(); ++c) {
        Vec3 n = good.normals[good.cornerNormals[c]];
        const bool patch = good.positions[good.cornerPositions[c]].x > 0.1F;
        if (which == 0 ? c % 7 == 0 : which == 1 ? patch : true) {
            n = -n;
            ++turned;
        }
        bad.normals.push_back(n);
        bad.cornerNormals[c] = c;
    }
    CHECK(normalsAgainstWinding(bad) == turned);
    const Scene a = smallScene(makeObject(good), ggxMaterial(0.2F, 0.2F), 24);
    const Scene b = smallScene(makeObject(bad), ggxMaterial(0.2F, 0.2F), 24);
    CHECK(greatestDifference(renderImage(a, 1, 4), renderImage(b, 1, 4), 0.05F) < 1e-3F);
}

TEST_CASE("A smooth normal may lean past a face that folds away sharply", "[orientation][winding]") {
    // Two large faces and a sliver that turns back below them: its corner's normal is the large faces'.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-0.3F, 0, 0.05F}, {-0.3F, 1, 0.05F}, {-0.1F, 0.5F, -0.02F}};
    mesh.cornerPositions = {0, 1, 2, 3, 0, 3, 5, 4, 4, 5, 6};
    mesh.faceOffsets = {0, 4, 8, 11};
    mesh.normals = {Vec3(0, 0, 1), glm::normalize(Vec3(-0.2F, 0, -1))};
    mesh.cornerNormals = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    CHECK(cornersAgainstWinding(mesh).empty());
}
