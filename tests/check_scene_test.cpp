/// check(): one mistake of every kind in a scene that is sound without it, made in memory.

#include "mesh_fixtures.h"
#include "render_fixtures.h"
#include "scene_fixtures.h"

#include "taut/plan/plan.h"
#include "taut/scene/check_scene.h"

#include <limits>

using namespace taut;
using namespace taut::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A cube under a rig of two nodes that skins and animates it, with morphs and all that a mesh may carry.
Object figure() {
    Mesh mesh = cube();
    const std::size_t n = mesh.positions.size();
    mesh.normals = {Vec3(0, 0, 1)};
    mesh.cornerNormals.assign(mesh.cornerCount(), 0);
    mesh.uvs.assign(n, Vec2(0));
    mesh.cornerUvs = mesh.cornerPositions;
    mesh.cornerUvs.back() = kNone;
    mesh.tangents = {Vec4(1, 0, 0, 1)};
    mesh.cornerTangents.assign(mesh.cornerCount(), 0);
    mesh.storedM = {Vec3(1, 0, 1)};
    mesh.faceMaterials.assign(mesh.faceCount(), 0);
    mesh.materialNames = {"shell"};
    mesh.morphs = {{"open", std::vector<Vec3>(n, Vec3(0))}};
    for (Index i = 0; i <= n; ++i) mesh.skin.offsets.push_back(i);
    mesh.skin.joints.assign(n, 0);
    mesh.skin.weights.assign(n, 1);
    mesh.creases = {{0, 1, 2}};
    mesh.corners = {{3, 2}};
    Rig rig;
    rig.nodes.resize(2);
    rig.nodes[1].parent = 0;
    rig.nodes[1].skin = 0;
    rig.skins = {{"skin", {0}, {DMat4(1)}}};
    Channel channel;
    channel.node = 0;
    channel.times = {0, 1};
    channel.values.assign(6, 0);
    rig.clips = {{"turn", {channel}, 1}};
    Object object = makeObject(std::move(mesh));
    object.rig = RigMotion{std::make_shared<const Rig>(std::move(rig)), 1, 0, false};
    return object;
}

DeformerKeys deformerOf(DeformerType type) {
    DeformerKeys keys;
    keys.type = type;
    return keys;
}

/// Figure, deformed torus and subdivided cube under every kind of light.
Scene soundScene() {
    Scene scene = smallScene(figure(), ggxMaterial(0.1F, 0.3F));
    scene.objects.push_back(shearedTorus(8, 6));
    for (const DeformerType type :
         {DeformerType::Stretch, DeformerType::Bend, DeformerType::Twist, DeformerType::Taper, DeformerType::Lattice, DeformerType::Wave})
        scene.objects[1].deformers.push_back(deformerOf(type));
    scene.objects.push_back(makeObject(cube()));
    scene.objects[2].subdivision.level = 2;
    scene.objects[2].gradient = GradientEstimator::Limit;
    scene.materials[0].name = "foil";
    scene.textures.push_back({"grey", 2, 1, 1, {0.25F, 0.5F}, {}});
    scene.materials[0].rotation = {3, 0, 0};
    for (const LightShape &shape :
         {LightShape(SphereLight()), LightShape(DirectionalLight()), LightShape(PointLight()), LightShape(SpotLight())}) {
        scene.lights.emplace_back();
        scene.lights.back().shape = shape;
    }
    scene.environment = studioEnvironment();
    return scene;
}

template <class Change> auto inMesh(std::size_t object, Change change) {
    return [=](Scene &scene) {
        Mesh mesh = *scene.objects[object].mesh;
        change(mesh);
        scene.objects[object].mesh = std::make_shared<const Mesh>(std::move(mesh));
    };
}
template <class Change> auto inRig(Change change) {
    return [=](Scene &scene) {
        Rig rig = *scene.objects[0].rig->rig;
        change(rig);
        scene.objects[0].rig->rig = std::make_shared<const Rig>(std::move(rig));
    };
}

struct Wrong {
    std::function<void(Scene &)> change;
    std::string says;
};

const std::vector<Wrong> kWrongViews{
    {[](Scene &s) { s.render.width = 0; }, "render.width: found 0, expected an integer in [1, 32768]"},
    {[](Scene &s) { s.render.height = 40000; }, "render.height: found 40000"},
    {[](Scene &s) { s.render.spp = 0; }, "render.spp: found 0"},
    {[](Scene &s) { s.render.maxEvents = -1; }, "render.maxEvents: found -1"},
    {[](Scene &s) { s.render.frames.clear(); }, "render.frames: found none, expected at least one"},
    {[](Scene &s) { s.render.frames = {2'000'000'000}; }, "render.frames: found 2000000000"},
    {[](Scene &s) { s.render.fps = 0; }, "render.fps: found 0, expected a number in (0, 1e+06]"},
    {[](Scene &s) { s.render.shutter = -0.5; }, "render.shutter: found -0.5, expected a number in [0, 1000]"},
    {[](Scene &s) { s.render.motionSteps = 1; }, "render.motionSteps: found 1, expected an integer in [2, 128]"},
    {[](Scene &s) { s.camera.fovY = radians(180.0); }, "camera.fovY: found 180, expected a number in [0.01, 179] degrees"},
    {[](Scene &s) { s.camera.apertureRadius = -1.0; }, "camera.apertureRadius: found -1"},
    {[](Scene &s) { s.camera.focusDistance = double(kNan); }, "camera.focusDistance: found nan"},
    {[](Scene &s) { s.camera.position = s.camera.lookAt; }, "camera: found position equal to look_at at frame 1, expected two points"},
    {[](Scene &s) { s.camera.up = DVec3(0); }, "camera: found up of no length at frame 1, expected a direction"},
    {[](Scene &s) { s.camera.up.keys.clear(); }, "camera.position, lookAt or up: found no key"},
    {[](Scene &s) {
         s.camera.lookAt.keys = {{2, DVec3(0)}, {2, DVec3(1)}};
     },
     "found frame 2, expected a frame after 2"},
    {[](Scene &s) { s.camera.rig = RigMotion{}; }, "camera.rig.rig: found none"},
    {[](Scene &s) { std::get<QuadLight>(s.lights[0].shape).v = 2.0 * std::get<QuadLight>(s.lights[0].shape).u; },
     "lights[0]: found u and v along one line, expected two edges of a quad"},
    {[](Scene &s) { s.lights[0].radiance.y = -1; }, "lights[0].radiance: found -1, expected a number of at least 0"},
    {[](Scene &s) { std::get<SphereLight>(s.lights[1].shape).radius = 0; }, "lights[1].radius: found 0, expected a number above 0"},
    {[](Scene &s) { std::get<SphereLight>(s.lights[1].shape).centre.x = kInfinity; },
     "lights[1].centre: found inf, expected a finite number"},
    {[](Scene &s) { std::get<DirectionalLight>(s.lights[2].shape).direction = DVec3(0, 0, 2); },
     "lights[2].direction: found another length, expected a vector of length 1"},
    {[](Scene &s) { std::get<SpotLight>(s.lights[4].shape).innerAngle = 0.8; }, "lights[4]: found inner_deg not below outer_deg"},
    {[](Scene &s) { std::get<SpotLight>(s.lights[4].shape).outerAngle = 2; },
     "lights[4].outer_deg: found 114.592, expected a number in [0, 90] degrees"},
    {[](Scene &s) { s.environment->texels[5].y = -1; }, "environment.texels: found a radiance that is negative or not finite in element 5"},
    {[](Scene &s) { s.environment->texels.pop_back(); }, "environment.texels: found "},
    {[](Scene &s) { s.environment->guide.clear(); }, "environment.table: found no tables for sampling"},
    {[](Scene &s) { s.textures[0].channels = 2; }, "textures[0] 'grey'.channels: found 2, expected 1, 3 or 4"},
    {[](Scene &s) { s.textures[0].height = 2; }, "textures[0] 'grey'.texels: found 2 elements, expected 4"},
    {[](Scene &s) {
         s.textures[0].texels = {0.25F, kNan};
     },
     "textures[0] 'grey'.texels: found a value that is not finite in element 1"},
};

const std::vector<Wrong> kWrongMaterials{
    {[](Scene &s) { s.materials[0].alphaX.value = -1; }, "materials[0] 'foil'.alphaX: found -1, expected a number in [1e-4, 10]"},
    {[](Scene &s) { s.materials[0].alphaY.value = 11; }, "materials[0] 'foil'.alphaY: found 11"},
    {[](Scene &s) { s.materials[0].alphaY.value = kNan; }, "materials[0] 'foil'.alphaY: found nan"},
    {[](Scene &s) {
         s.materials[0].alphaIsRoughness = true;
         s.materials[0].alphaX.value = 2;
     },
     "alphaX: found 2, expected a number in [0, 1]"},
    {[](Scene &s) { s.materials[0].rotation.texture = 1; }, "rotation: found 1, expected one of the 1 textures"},
    {[](Scene &s) { s.materials[0].rotation.channel = 4; }, "rotation: found 4, expected an integer in [0, 3]"},
    {[](Scene &s) { s.materials[0].color.value.z = 1.5F; }, "color: found 1.5, expected a number in [0, 1]"},
    {[](Scene &s) { s.materials[0].color.texture = 9; }, "color: found 9, expected one of the 1 textures"},
    {[](Scene &s) { s.materials[0].conductorEta.x = -1; }, "conductorEta: found -1"},
    {[](Scene &s) { s.materials[0].ior = 0.1F; }, "ior: found 0.1"},
    {[](Scene &s) { s.materials[0].metallic.value = -1; }, "metallic: found -1"},
    {[](Scene &s) { s.materials[0].anisotropyTexture = 3; }, "anisotropyTexture: found 3"},
    {[](Scene &s) { s.materials[0].anisotropyStrength = 2; }, "anisotropyStrength: found 2"},
    {[](Scene &s) { s.materials[0].poisson = 0.75F; }, "poisson: found 0.75, expected a number in [-1, 0.5]"},
    {[](Scene &s) {
         s.materials[0].type = BsdfType::Coated;
         s.materials[0].multiscatter = Multiscatter::Walk;
     },
     "multiscatter: found 'walk', which this version does not have yet for this type"},
};

const std::vector<Wrong> kWrongObjects{
    {[](Scene &s) { s.objects[0].mesh.reset(); }, "objects[0] 'cage'.mesh: found none, expected a mesh"},
    {[](Scene &s) { s.objects[0].materials.clear(); }, "objects[0] 'cage'.materials: found none, expected at least one"},
    {[](Scene &s) {
         s.objects[0].materials = {0, 5};
     },
     "materials: found 5, expected one of the 1 materials"},
    {[](Scene &s) { s.objects[0].rig->rig.reset(); }, "rig.rig: found none, expected a rig"},
    {[](Scene &s) { s.objects[0].rig->node = 2; }, "rig.node: found 2, expected one of the 2 nodes"},
    {[](Scene &s) { s.objects[0].rig->node = kNone; }, "rig.node: found none"},
    {[](Scene &s) { s.objects[0].rig->clip = 1; }, "rig.clip: found 1, expected one of the 1 clips"},
    {[](Scene &s) { s.objects[1].points = pointFunction(3, [](double, std::span<Vec3>) {}); },
     "points: found 3 points, expected as many as the mesh has positions"},
    {[](Scene &s) { s.objects[1].placement.scale = DVec3(1, kNan, 1); }, "placement.scale: found nan"},
    {[](Scene &s) { s.objects[1].placement.translation = DVec3(kInfinity); }, "placement.translation: found inf"},
    {[](Scene &s) { s.objects[1].placement.rotation.keys.clear(); }, "placement.rotation: found no key"},
    {[](Scene &s) { s.objects[1].placement.worldFromUp[1][2] = kNan; }, "placement.worldFromUp: found nan"},
    {[](Scene &s) { s.objects[2].subdivision.level = 7; }, "subdivision.level: found 7, expected an integer in [0, 6]"},
    {[](Scene &s) { s.objects[2].subdivision.creaseAngle = 4; }, "subdivision.creaseAngle: found 229.183"},
    {[](Scene &s) { s.objects[2].subdivision.scheme = SubdivisionScheme::Loop; },
     "subdivision.scheme: found face 0 with 4 corners, expected triangles for the scheme \"loop\""},
    {[](Scene &s) { s.objects[2].gradient = GradientEstimator::Analytic; },
     "gradient: found 'analytic', expected 'limit' or one of the fits"},
    {[](Scene &s) { s.objects[1].gradient = GradientEstimator::Limit; }, "gradient: found 'limit', expected 'analytic' or one of the fits"},
    {[](Scene &s) { s.objects[2].lean = true; }, "lean: found lean = true, expected lean = false"},
    {[](Scene &s) {
         s.objects[1].rest = {false, kNan};
     },
     "rest.frame: found nan"},
    {[](Scene &s) { s.objects[1].emission.value.x = -2; }, "emission: found -2"},
    {[](Scene &s) { s.objects[1].deformers[0].amount.keys.clear(); }, "deformers.amount: found no key"},
    {[](Scene &s) { s.objects[1].deformers[0].axis = 3; }, "deformers.axis: found 3, expected an integer in [0, 2]"},
    {[](Scene &s) { s.objects[1].deformers[1].factor = DVec3(0, 1, 1); }, "deformers.factor: found 0, expected a number above 0"},
    {[](Scene &s) { s.objects[1].deformers[1].centre.x = kNan; }, "deformers.centre: found nan"},
    {[](Scene &s) { s.objects[1].deformers[2].axis2 = 2; }, "deformers: found axis and towards alike, expected two different axes"},
    {[](Scene &s) { s.objects[1].deformers[3].lower = 1; }, "deformers: found [1, 1], expected lower below upper"},
    {[](Scene &s) { s.objects[1].deformers[3].amount = radians(2e6); }, "deformers.amount: found 2e+06"},
    {[](Scene &s) { s.objects[1].deformers[4].amount = -1.0; }, "deformers.amount: found -1, expected a number above -1"},
    {[](Scene &s) { s.objects[1].deformers[5].latticePoints[1] = 17; },
     "deformers.latticePoints: found 17, expected an integer in [2, 16]"},
    {[](Scene &s) { s.objects[1].deformers[5].latticeUpper = DVec3(0); }, "deformers: found a lattice box without volume"},
    {[](Scene &s) { s.objects[1].deformers[5].latticeOffsets.resize(9, DVec3(0)); },
     "deformers.latticeOffsets: found 9 elements, expected 8"},
    {[](Scene &s) { s.objects[1].deformers[6].wavelength = 0.0; }, "deformers.wavelength: found 0, expected a number above 0"},
};

const std::vector<Wrong> kWrongMeshes{
    {inMesh(0, [](Mesh &m) { m.positions.clear(); }), "mesh.positions: found none"},
    {inMesh(0, [](Mesh &m) { m.positions[4].y = kNan; }), "mesh.positions: found a number that is not finite in element 4"},
    {inMesh(0, [](Mesh &m) { m.faceOffsets.clear(); }), "mesh.faceOffsets: found no face, expected at least one"},
    {inMesh(2, [](Mesh &m) { m.faceOffsets = {0}; }), "mesh.faceOffsets: found no face"},
    {inMesh(0, [](Mesh &m) { m.faceOffsets[0] = 1; }), "mesh.faceOffsets: found another first offset"},
    {inMesh(0, [](Mesh &m) { m.faceOffsets[2] = 40; }), "mesh.faceOffsets: found a fall in element 2, expected offsets that never fall"},
    {inMesh(0, [](Mesh &m) { m.faceOffsets.back() = 23; }), "mesh.faceOffsets: found 23 at the end, expected 24"},
    {inMesh(0, [](Mesh &m) { m.faceOffsets[1] = 2; }), "mesh.faceOffsets: found a face of fewer than three corners in element 0"},
    {inMesh(0, [](Mesh &m) { m.cornerPositions[7] = 8; }), "mesh.cornerPositions: found an index beyond the positions in element 7"},
    {inMesh(0, [](Mesh &m) { m.cornerPositions[7] = kNone; }), "mesh.cornerPositions: found an index beyond the positions in element 7"},
    {inMesh(0, [](Mesh &m) { m.cornerUvs.pop_back(); }), "mesh.cornerUvs: found 23 elements, expected 24"},
    {inMesh(0, [](Mesh &m) { m.cornerUvs[3] = 8; }), "mesh.cornerUvs: found an index beyond the 8 values in element 3"},
    {inMesh(0, [](Mesh &m) { m.cornerNormals[3] = 1; }), "mesh.cornerNormals: found an index beyond the 1 values in element 3"},
    {inMesh(0, [](Mesh &m) { m.normals[0].x = kNan; }), "mesh.normals: found a number that is not finite in element 0"},
    {inMesh(0, [](Mesh &m) { m.cornerTangents[3] = 1; }), "mesh.cornerTangents: found an index beyond the 1 values in element 3"},
    {inMesh(0, [](Mesh &m) { m.tangents[0].x = kNan; }), "mesh.tangents: found a number that is not finite in element 0"},
    {inMesh(0, [](Mesh &m) { m.storedM.emplace_back(1); }), "mesh.storedM: found 2 elements, expected 1"},
    {inMesh(0, [](Mesh &m) { m.storedM[0].z = 0; }), "mesh.storedM: found a diagonal that is not above 0 in element 0"},
    {inMesh(0, [](Mesh &m) { m.faceMaterials.pop_back(); }), "mesh.faceMaterials: found 5 elements, expected 6"},
    {inMesh(0, [](Mesh &m) { m.morphs[0].positionDeltas.pop_back(); }), "mesh.morphs: found 7 elements, expected 8"},
    {inMesh(0, [](Mesh &m) { m.morphs[0].positionDeltas[2].x = kNan; }), "mesh.morphs: found a number that is not finite in element 2"},
    {inMesh(0, [](Mesh &m) { m.skin.offsets.pop_back(); }), "mesh.skin.offsets: found 8 elements, expected 9"},
    {inMesh(0, [](Mesh &m) { m.skin.offsets[3] = 0; }), "mesh.skin.offsets: found a fall in element 2"},
    {inMesh(0, [](Mesh &m) { m.skin.weights.pop_back(); }), "mesh.skin.weights: found 7 elements, expected 8"},
    {inMesh(0, [](Mesh &m) { m.skin.weights[1] = kNan; }), "mesh.skin.weights: found a number that is not finite in element 1"},
    {inMesh(0, [](Mesh &m) { m.skin.joints[6] = 1; }), "mesh.skin.joints: found an index beyond the 1 joints of the skin in element 6"},
    {inMesh(0, [](Mesh &m) { m.creases[0].b = 8; }), "mesh.creases: found an edge beyond the positions"},
    {inMesh(0, [](Mesh &m) { m.corners[0].sharpness = -1; }), "mesh.corners: found a corner beyond the positions, or no sharpness"},
    {inRig([](Rig &r) { r.nodes[0].parent = 1; }), "rig.nodes: found node 0 before its parent"},
    {inRig([](Rig &r) { r.nodes[0].skin = 1; }), "rig.nodes.skin: found 1, expected one of the 1 skins"},
    {inRig([](Rig &r) { r.nodes[0].scale.x = kInfinity; }), "rig.nodes: found numbers that are not finite in node 0"},
    {inRig([](Rig &r) { r.skins[0].joints = {2}; }), "rig.skins.joints: found 2, expected one of the 2 nodes"},
    {inRig([](Rig &r) { r.skins[0].joints.clear(); }), "rig.skins.joints: found none"},
    {inRig([](Rig &r) { r.skins[0].inverseBindMatrix.clear(); }), "rig.skins.inverseBindMatrix: found 0 elements, expected 1"},
    {inRig([](Rig &r) { r.clips[0].channels[0].node = 2; }), "rig.clips.channels.node: found 2"},
    {inRig([](Rig &r) { r.clips[0].channels[0].width = 4; }), "rig.clips.channels.width: found 4 elements, expected 3"},
    {inRig([](Rig &r) { r.clips[0].channels[0].values.pop_back(); }), "rig.clips.channels.values: found 5 elements, expected 6"},
    {inRig([](Rig &r) { r.clips[0].channels[0].times[1] = 0; }), "rig.clips.channels.times: found key 1 not after the one before"},
};

} // namespace

TEST_CASE("check: one mistake of every kind", "[check]") {
    REQUIRE_NOTHROW(check(soundScene()));
    for (const auto *table : {&kWrongViews, &kWrongMaterials, &kWrongObjects, &kWrongMeshes})
        for (const Wrong &wrong : *table) {
            Scene scene = soundScene();
            wrong.change(scene);
            const std::string line = errorOf([&] { check(scene); });
            INFO("expected '" << wrong.says << "' in '" << line << "'");
            CHECK(line.find(wrong.says) != std::string::npos);
        }
}

TEST_CASE("check: an unsound scene is neither planned nor rendered", "[check]") {
    Scene scene = smallScene(makeObject(cube()), ggxMaterial(0.1F, 0.1F));
    scene.path = "made/here";
    scene.objects[0].materials.clear();
    const std::string expected = "made/here: objects[0] 'cage'.materials: found none, expected at least one";
    CHECK(errorOf([&] { RenderScene(scene, false); }) == expected);
    CHECK(errorOf([&] { RenderScene(scene, ScenePlan{}, false); }) == expected);
    CHECK(errorOf([&] { makePlan(scene); }) == expected);
    CHECK(errorOf([&] { fullPlan(scene); }) == expected);
}

TEST_CASE("check: the last of a large mesh's indices is looked at, and the first mistake is told", "[check]") {
    Scene scene = smallScene(makeObject(makeGrid(400, 400, 2)), ggxMaterial(0.1F, 0.1F));
    Mesh mesh = *scene.objects[0].mesh;
    const std::size_t last = mesh.cornerCount() - 1;
    for (const std::size_t corner : {last, last / 2, last / 2 + 40000}) mesh.cornerPositions[corner] = kNone;
    scene.objects[0].mesh = std::make_shared<const Mesh>(std::move(mesh));
    CHECK(says(errorOf([&] { check(scene); }), "in element " + std::to_string(last / 2) + ",", {}));
}

TEST_CASE("check: what readers let through of glTF is sound", "[check]") {
    Scene scene = smallScene(makeObject(cube()), ggxMaterial(0.1F, 0.1F));
    scene.materials[0].ior = 0; // KHR_materials_ior: reflects everything
    SpotLight spot;
    spot.outerAngle = spot.innerAngle = 1.5708F; // glTF's pi / 2, rounded
    scene.lights[0].shape = spot;
    scene.materials[0].alphaX.value = 1e-4F; // a float just below the range's end
    CHECK_NOTHROW(check(scene));
}
