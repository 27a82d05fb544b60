#include "scene_fixtures.h"

#include "taut/bsdf/metals.h"

using namespace taut;
using namespace taut::test;

TEST_CASE("a scene file fills the scene", "[scene]") {
    const std::string folder = sceneFolder("scene");
    const Scene scene = loadText(folder, R"(
[render]
width = 320
height = 200
spp = 7
max_events = 3
frames = "1-5x2"
fps = 25
seed = 4294967295
fixed_seed = true
filter = "box"

[camera]
position = [[1, [0, -4, 2]], [5, [4, 0, 2]]]
look_at = [0, 0, 1]
fov_deg = [[1, 40], [3, 60]]
aperture_radius = 0.05
focus_distance = 3

[environment]
radiance = [1, 2, 3]
scale = 2
camera_visible = false

[[light]]
type = "quad"
corner = [1, -1, 3]
u = [-2, 0, 0]
v = [0, 2, 0]
radiance = [10, 11, 12]
camera_visible = true
two_sided = true

[[light]]
type = "sphere"
centre = [1, 2, 3]
radius = 0.5
radiance = 4

[[light]]
type = "directional"
direction = [0, 0, -2]
irradiance = [1, 2, 3]

[[light]]
type = "point"
position = [3, 2, 1]
intensity = 5

[[light]]
type = "spot"
position = [0, 0, 5]
direction = [0, 3, -4]
intensity = [1, 1, 2]
inner_deg = 10
outer_deg = 30

[[light]]
type = "mesh"
mesh = "panel"
radiance = [3, 2, 1]

[material.brushed]
type = "conductor"
metal = "Al"
alpha = [0.08, 0.4]
rotation_deg = 90
poisson = 0.5
masking = "separable"
multiscatter = "off"

[material.glass]
type = "dielectric"
ior = 1.33
color = [0.9, 1, 0.9]
alpha = 0.01

[material.car]
type = "metallic_roughness"
color = 0.5
metallic = 1
roughness = 0.6
anisotropy = 0.25

[[mesh]]
file = "panel.obj"
material = "brushed"
subdivision = 2
smooth = false
follow = false
rest = "frame 2.5"
translate = [[1, [0, 0, 0]], [3, [2, 0, 0]]]
rotate_deg = [0, 0, 90]
scale = 2

[[mesh]]
file = "parts.obj"
name = "panel"
material = { Trim = "glass", Body = "car" }
)");
    CHECK(scene.render.width == 320);
    CHECK(scene.render.height == 200);
    CHECK(scene.render.spp == 7);
    CHECK(scene.render.maxEvents == 3);
    CHECK(scene.render.frames == std::vector<int>{1, 3, 5});
    CHECK(scene.render.fps == 25);
    CHECK(scene.render.seed == 4294967295U);
    CHECK(scene.render.fixedSeed);
    CHECK(scene.render.boxFilter);

    const CameraState camera = cameraAtFrame(scene.camera, 3, 25);
    CHECK(close(DVec3(camera.worldFromCamera[3]), DVec3(2, -2, 2)));
    CHECK(camera.fovY == Approx(radians(60)));
    CHECK(camera.apertureRadius == 0.05);
    CHECK(camera.focusDistance == 3);
    CHECK(cameraAtFrame(scene.camera, 2, 25).fovY == Approx(radians(50)));

    REQUIRE(scene.environment);
    CHECK(lookUpEnvironment(*scene.environment, Vec3(0, 0, 1)).radiance == Vec3(2, 4, 6));
    CHECK(!scene.environment->cameraVisible);

    REQUIRE(scene.lights.size() == 5);
    const auto &quad = std::get<QuadLight>(scene.lights[0].shape);
    CHECK(quad.corner == DVec3(1, -1, 3));
    CHECK(quad.u == DVec3(-2, 0, 0));
    CHECK(quad.v == DVec3(0, 2, 0));
    CHECK(scene.lights[0].radiance == Vec3(10, 11, 12));
    CHECK(scene.lights[0].cameraVisible);
    CHECK(quad.twoSided);
    const auto &sphere = std::get<SphereLight>(scene.lights[1].shape);
    CHECK(sphere.centre == DVec3(1, 2, 3));
    CHECK(sphere.radius == 0.5);
    CHECK(scene.lights[1].radiance == Vec3(4));
    CHECK(!scene.lights[1].cameraVisible);
    CHECK(std::get<DirectionalLight>(scene.lights[2].shape).direction == DVec3(0, 0, -1));
    CHECK(scene.lights[2].radiance == Vec3(1, 2, 3));
    CHECK(std::get<PointLight>(scene.lights[3].shape).position == DVec3(3, 2, 1));
    CHECK(scene.lights[3].radiance == Vec3(5));
    const auto &spot = std::get<SpotLight>(scene.lights[4].shape);
    CHECK(close(spot.direction, DVec3(0, 0.6, -0.8)));
    CHECK(spot.innerAngle == Approx(radians(10)));
    CHECK(spot.outerAngle == Approx(radians(30)));

    REQUIRE(scene.materials.size() == 3);
    const Material &brushed = scene.materials[0];
    CHECK(brushed.name == "brushed");
    CHECK(brushed.type == BsdfType::Metal);
    CHECK(brushed.conductorK.x > 7);
    CHECK(brushed.alphaX.value == 0.08F);
    CHECK(brushed.alphaY.value == 0.4F);
    CHECK(!brushed.alphaIsRoughness);
    CHECK(brushed.rotation.value == Approx(radians(90)));
    CHECK(brushed.poisson == 0.5F);
    CHECK(brushed.masking == Masking::Separable);
    CHECK(brushed.multiscatter == Multiscatter::Off);
    CHECK(scene.materials[1].type == BsdfType::Dielectric);
    CHECK(scene.materials[1].ior == 1.33F);
    CHECK(scene.materials[1].alphaY.value == 0.01F);
    CHECK(scene.materials[1].multiscatter == Multiscatter::Auto);
    const Material &car = scene.materials[2];
    CHECK(car.alphaIsRoughness);
    CHECK(car.alphaX.value == 0.6F);
    CHECK(car.metallic.value == 1);
    CHECK(car.anisotropyStrength == 0.25F);
    CHECK(car.color.value == Vec3(0.5F));

    REQUIRE(scene.objects.size() == 2);
    const Object &panel = scene.objects[0];
    CHECK(panel.name == "panel");
    CHECK(panel.materials == std::vector<Index>{0});
    CHECK(panel.subdivision.level == 2);
    CHECK(!panel.smooth);
    CHECK(!panel.follow);
    CHECK(!panel.rest.bind);
    CHECK(panel.rest.frame == 2.5);
    CHECK(panel.emission.value == Vec3(3, 2, 1));
    // x of the panel, turned to y and doubled, moved by (1, 0, 0) at frame 2.
    CHECK(close(transformed(placementAt(panel.placement, 2), DVec3(1, 0, 0)), DVec3(1, 2, 0)));
    const Object &parts = scene.objects[1];
    CHECK(parts.name == "panel_2");
    CHECK(parts.emission.value == Vec3(0));
    REQUIRE(parts.mesh->materialNames == std::vector<std::string>{"Body", "Trim"});
    CHECK(parts.materials == std::vector<Index>{2, 1});
}

TEST_CASE("One material of a mesh shines", "[scene][light]") {
    const std::string folder = sceneFolder("scene");
    const std::string scene = R"(
[[light]]
type = "mesh"
mesh = "parts"
slot = "Trim"
radiance = [1, 2, 3]
two_sided = true
[[mesh]]
file = "parts.obj"
)";
    const Object parts = loadText(folder, scene).objects.at(0);
    CHECK(emissionOf(parts, 0).radiance.value == Vec3(0));
    CHECK(emissionOf(parts, 1).radiance.value == Vec3(1, 2, 3));
    CHECK(emissionOf(parts, 1).twoSided);
    CHECK(!loadText(folder, scene).environment); // it lights the scene
    // The rest of it may shine otherwise.
    const Object both = loadText(folder, "[[light]]\ntype = \"mesh\"\nmesh = \"parts\"\nradiance = 5\n" + scene).objects.at(0);
    CHECK(emissionOf(both, 0).radiance.value == Vec3(5));
    CHECK(emissionOf(both, 1).radiance.value == Vec3(1, 2, 3));
}

TEST_CASE("an empty table takes the defaults of the structures", "[scene]") {
    const std::string folder = sceneFolder("scene");
    const Scene scene =
        loadText(folder, "[render]\n[camera]\n[material.plain]\n[[light]]\n[[mesh]]\nfile = \"panel.obj\"\n[[mesh.deform]]\n");
    const RenderSettings render;
    CHECK(scene.render.width == render.width);
    CHECK(scene.render.spp == render.spp);
    CHECK(scene.render.frames == render.frames);
    CHECK(scene.render.fps == render.fps);
    CHECK(!scene.render.boxFilter);
    CHECK(scene.materials[0].type == Material().type);
    CHECK(scene.materials[0].color.value == Vec3(1));
    CHECK(scene.lights.at(0).radiance == Light().radiance);
    CHECK(scene.objects.at(0).follow);
    CHECK(scene.objects[0].rest.bind);
    CHECK(isIdentity(deformerAtFrame(scene.objects[0].deformers.at(0), 7)));
    CHECK(!scene.environment); // there is a light
    // What has no material is brushed steel.
    const Material &steel = scene.materials.at(scene.objects[0].materials.at(0));
    CHECK(steel.type == BsdfType::Metal);
    CHECK(steel.conductorEta == std::find_if(metals().begin(), metals().end(), [](const Metal &m) { return m.name == "Fe"; })->eta);
    CHECK(steel.alphaX.value == 0.08F);
    CHECK(steel.alphaY.value == 0.3F);
}

TEST_CASE("without lights a scene gets the studio", "[scene]") {
    const std::string folder = sceneFolder("scene");
    const std::string mesh = "[[mesh]]\nfile = \"panel.obj\"\n";
    CHECK(loadText(folder, mesh).environment);
    CHECK(!loadText(folder, mesh + "[[light]]\ntype = \"mesh\"\nmesh = \"panel\"\n").environment);
    CHECK(loadText(folder, mesh + "[environment]\npreset = \"studio\"\nscale = 0.5\nrotation_deg = 90\n").environment->rotation ==
          Approx(radians(90)));
    const Scene file = loadText(folder, mesh + "[environment]\nfile = \"studio.exr\"\nscale = [2, 2, 4]\n");
    CHECK(lookUpEnvironment(*file.environment, Vec3(1, 0, 0)).radiance == Vec3(1, 1, 2));
}

TEST_CASE("textures of a material", "[scene]") {
    const std::string folder = sceneFolder("scene");
    const Scene scene = loadText(folder, R"(
[material.a]
type = "conductor"
f0 = { file = "brushed.png", scale = [1, 0.5, 0.25] }
alpha = [{ file = "brushed.png", channel = "g", scale = 0.5 }, 0.3]
rotation_deg = { file = "brushed.png", channel = "b" }
[material.b]
type = "coated"
color = { file = "brushed.png", color_space = "linear", repeat = false }
alpha = { file = "brushed.png" }
rotation_deg = { file = "brushed.png", scale = 180 }
)");
    const Material &a = scene.materials.at(0);
    const Material &b = scene.materials.at(1);
    CHECK(a.color.value == Vec3(1, 0.5F, 0.25F));
    CHECK(a.alphaX.value == 0.5F);
    CHECK(a.alphaX.channel == 1);
    CHECK(a.alphaY.texture == kNone);
    CHECK(a.rotation.value == Approx(radians(360)));
    CHECK(a.rotation.channel == 2);
    CHECK(a.rotation.texture == a.alphaX.texture); // one image, one decoding, one texture
    CHECK(a.color.texture != a.alphaX.texture);    // a colour is decoded from sRGB, a number is not
    CHECK(lookup(scene.textures.at(a.color.texture), {0.25F, 0.75F}).z == Approx(0.2158605).epsilon(1e-3));
    CHECK(lookup(scene.textures.at(a.alphaX.texture), {0.25F, 0.75F}).z == Approx(128 / 255.0));
    CHECK(scene.textures.at(b.color.texture).sampler.wrapU == TextureWrap::Clamp);
    CHECK(b.alphaX.texture == b.alphaY.texture);
    CHECK(b.rotation.value == Approx(radians(180)));
    CHECK(scene.textures.size() == 3);
}

TEST_CASE("deformers of a mesh", "[scene]") {
    const std::string folder = sceneFolder("scene");
    const Scene scene = loadText(folder, R"(
[[mesh]]
file = "panel.obj"
[[mesh.deform]]
type = "stretch"
centre = [1, 0, 0]
factor = [[1, 1], [3, [3, 1, 0.5]]]
[[mesh.deform]]
type = "shear"
plane = "zy"
amount = [[1, 0], [48, 1.2]]
[[mesh.deform]]
type = "bend"
axis = "x"
towards = "z"
angle_deg = 90
range = [-2, 3]
[[mesh.deform]]
type = "twist"
angle_deg = [[1, 0], [2, 180]]
[[mesh.deform]]
type = "taper"
axis = "y"
amount = -0.5
[[mesh.deform]]
type = "wave"
axis = "x"
direction = "z"
amplitude = 0.1
wavelength = 2
phase_deg = 90
[[mesh.deform]]
type = "lattice"
lower = [-1, -1, -1]
upper = [1, 1, 1]
points = [3, 2, 2]
offsets = [[2, 1, 0, 0.1, 0.2, 0.3], { at = [1, 0, 1], offset = [[1, [0, 0, 0]], [2, [0, 0, 1]]] }]
)");
    const auto &d = scene.objects.at(0).deformers;
    REQUIRE(d.size() == 7);
    CHECK(d[0].centre == DVec3(1, 0, 0));
    CHECK(close(d[0].factor.at(2), DVec3(2, 1, 0.75)));
    CHECK(close(deform(deformerAtFrame(d[0], 3), DVec3(2, 1, 1)).position, DVec3(4, 1, 0.5)));
    CHECK(d[1].type == DeformerType::Shear);
    CHECK(close(deform(deformerAtFrame(d[1], 48), DVec3(0, 1, 0)).position, DVec3(0, 1, 1.2))); // z displaced by y
    CHECK(d[2].axis == 0);
    CHECK(d[2].axis2 == 2);
    CHECK(d[2].lower == -2);
    CHECK(d[2].upper == 3);
    CHECK(d[2].amount.first() == Approx(radians(90)));
    CHECK(d[3].axis == 2);
    CHECK(d[3].amount.at(1.5) == Approx(radians(90)));
    CHECK(d[4].amount.first() == -0.5);
    CHECK(d[5].axis2 == 2);
    CHECK(d[5].wavelength.first() == 2);
    CHECK(d[5].phase.first() == Approx(radians(90)));
    CHECK(d[6].latticePoints == std::array<int, 3>{3, 2, 2});
    REQUIRE(d[6].latticeOffsets.size() == 12);
    CHECK(d[6].latticeOffsets[2 + 3 * 1].first() == DVec3(0.1, 0.2, 0.3));
    CHECK(d[6].latticeOffsets[1 + 3 * (0 + 2 * 1)].at(1.5) == DVec3(0, 0, 0.5));
}

TEST_CASE("overrides on the command line", "[scene]") {
    const std::string folder = sceneFolder("scene");
    const std::string toml = "[render]\nwidth = 100\n[material.brushed]\ntype = \"conductor\"\nalpha = 0.1\n[[mesh]]\nfile = "
                             "\"panel.obj\"\nmaterial = \"brushed\"\n";
    const Scene scene = loadText(folder, toml,
                                 {"render.width=320", "render.frames=1-3", "mesh.0.follow=false", "material.brushed.alpha=[0.1,0.3]",
                                  "material.brushed.metal=Cu", "mesh.1.file=parts.obj", "mesh.0.deform.0.type=shear",
                                  "mesh.0.deform.0.amount=[[1, 0], [2, 1]]", "camera = { position = [1, 2, 3], look_at = [0, 0, 0] }",
                                  "environment.radiance = 1", "light.0.type=sphere"});
    CHECK(scene.render.width == 320);
    CHECK(scene.render.frames.size() == 3);
    CHECK(!scene.objects.at(0).follow);
    CHECK(scene.materials[0].alphaY.value == 0.3F);
    CHECK(scene.materials[0].conductorEta.y > 1);
    CHECK(scene.objects.size() == 2);
    CHECK(scene.objects[0].deformers.at(0).type == DeformerType::Shear);
    CHECK(scene.objects[0].deformers[0].amount.at(1.5) == 0.5);
    CHECK(scene.camera.position.first() == DVec3(1, 2, 3));
    CHECK(std::holds_alternative<SphereLight>(scene.lights.at(0).shape));
}
