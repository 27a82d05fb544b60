/// Cost in proportion to a scene: a pose once a time however many objects hang from a rig, names and warnings looked up, instances of
/// one mesh on one BVH. Counts, no clock.

#include "mesh_samples.h"
#include "render_fixtures.h"
#include "scene_fixtures.h"

#include <set>

using namespace taut;
using namespace taut::test;

namespace {

/// `count` nodes beside one another, all of one name and one mesh, each with a clip's channel of its own.
GltfBuilder row(std::size_t count) {
    GltfBuilder b = triangleGltf();
    const int times = b.addFloats("SCALAR", {0, 1});
    b.json["nodes"] = nlohmann::json::array();
    nlohmann::json channels;
    nlohmann::json samplers;
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < count; ++i) {
        const auto x = static_cast<float>(i);
        b.json["nodes"].push_back({{"name", "Cube"}, {"mesh", 0}, {"translation", {x, 0, 0}}});
        samplers.push_back({{"input", times}, {"output", b.addFloats("VEC3", {x, 0, 0, x, 1, 0})}});
        channels.push_back({{"sampler", i}, {"target", {{"node", i}, {"path", "translation"}}}});
        roots.push_back(i);
    }
    b.json["scenes"] = {{{"nodes", roots}}};
    b.json.erase("cameras");
    b.json["animations"] = {{{"channels", channels}, {"samplers", samplers}}};
    return b;
}

std::size_t evaluations(const RenderScene &scene) {
    return scene.scene().objects[0].rig->poses->evaluations();
}

} // namespace

TEST_CASE("many nodes: each pose is evaluated once, however many objects ask for it", "[nodes]") {
    const std::string folder = outputFolder("nodes");
    for (const std::size_t count : {10UL, 300UL})
        for (const double shutter : {0.0, 0.5}) {
            INFO(count << " nodes, shutter " << shutter);
            Scene scene = loadText(folder, "[[mesh]]\nfile = \"" +
                                               std::filesystem::path(writeTo(folder, "row.glb", row(count).glb())).filename().string() +
                                               "\"\n[render]\nshutter = " + std::to_string(shutter) + "\nmotion_steps = 4\n");
            REQUIRE(scene.objects.size() == count);
            const std::size_t loaded = scene.objects[0].rig->poses->evaluations();
            CHECK(loaded < 8); // the default camera looks at all objects
            RenderScene ready(std::move(scene), true);
            for (const double frame : {1.0, 2.0, 3.0}) {
                const std::size_t before = evaluations(ready);
                ready.setFrame(frame);
                CHECK(evaluations(ready) - before <= (shutter > 0 ? 4 : 1));
            }
            CHECK(evaluations(ready) - loaded <= (shutter > 0 ? 13 : 4));
        }
}

TEST_CASE("many nodes: objects that a program hangs from one rig share its poses too", "[nodes]") {
    Rig rig;
    rig.nodes.resize(50);
    for (std::size_t i = 0; i < rig.nodes.size(); ++i) rig.nodes[i].translation.x = static_cast<double>(i);
    const auto shared = std::make_shared<const Rig>(rig);
    Scene scene = smallScene(makeObject(makeGrid(1, 1, 1)), ggxMaterial(0.2F, 0.2F));
    scene.objects.resize(1);
    for (Index i = 0; i < 50; ++i) {
        Object object = scene.objects[0];
        object.rig = RigMotion{shared, i};
        scene.objects.push_back(object);
    }
    scene.objects.erase(scene.objects.begin());
    RenderScene ready(scene, true);
    ready.setFrame(1);
    CHECK(evaluations(ready) <= 3);
    // Nodes stand where their own translations put them.
    const DVec3 apart = DVec3(ready.objects()[49].placements[0][3]) - DVec3(ready.objects()[0].placements[0][3]);
    CHECK(glm::length(apart) == Approx(49));
}

TEST_CASE("many nodes: poses of other clips, times and rigs are told apart", "[nodes]") {
    Rig rig;
    rig.nodes.resize(2);
    rig.nodes[1].parent = 0;
    rig.clips.resize(2);
    for (std::size_t c = 0; c < 2; ++c) {
        Channel channel;
        channel.node = 0;
        channel.path = c == 0 ? ChannelPath::Translation : ChannelPath::Scale;
        channel.times = {0, 1};
        channel.values = {1, 1, 1, 2, 2, 2};
        rig.clips[c].channels = {channel};
    }
    const auto first = std::make_shared<const Rig>(rig);
    RigPoses poses;
    CHECK(poses.at(first, &first->clips[0], 0.5)->worldFromNode[1][3].x == Approx(1.5));
    CHECK(poses.at(first, &first->clips[0], 1)->worldFromNode[1][3].x == Approx(2));
    CHECK(poses.at(first, &first->clips[1], 1)->worldFromNode[1][0].x == Approx(2));
    CHECK(poses.at(first, nullptr, 1)->worldFromNode[1] == DMat4(1));
    CHECK(poses.rest(first, &first->clips[1])->worldFromNode[1] == DMat4(1));
    CHECK(poses.evaluations() == 5);
    CHECK(poses.at(first, &first->clips[0], 0.5) == poses.at(first, &first->clips[0], 0.5));
    CHECK(poses.evaluations() == 5);
    CHECK(poses.isMoved(first, &first->clips[1], 1, ChannelPath::Scale)); // by its parent
    CHECK_FALSE(poses.isMoved(first, &first->clips[0], 1, ChannelPath::Scale));
    CHECK_FALSE(poses.isMoved(first, nullptr, 1, ChannelPath::Scale));
    rig.nodes[0].translation.x = 7;
    const auto second = std::make_shared<const Rig>(rig);
    CHECK(poses.at(second, nullptr, 1)->worldFromNode[1][3].x == Approx(7));
    for (int i = 0; i < 1000; ++i) CHECK(poses.at(second, &second->clips[0], 0.001 * i)->worldFromNode[1][3].x == Approx(1 + 0.001 * i));
}

TEST_CASE("many nodes: names alike are numbered on", "[nodes]") {
    const std::string folder = outputFolder("nodes");
    writeTo(folder, "alike.glb", row(2500).glb());
    const Scene scene = loadText(folder, "[[mesh]]\nfile = \"alike.glb\"\n[[mesh]]\nfile = \"alike.glb\"\n");
    REQUIRE(scene.objects.size() == 5000);
    std::set<std::string> names;
    for (const Object &object : scene.objects) names.insert(object.name);
    CHECK(names.size() == 5000);
    CHECK(scene.objects[0].name == "alike/Cube");
    CHECK(scene.objects[1].name == "alike/Cube_2");
    CHECK(scene.objects[2499].name == "alike/Cube_2500");
    CHECK(scene.objects[2500].name == "alike_2/Cube");
}

TEST_CASE("many nodes: a warning is said once, among any number", "[nodes]") {
    Warnings warnings;
    for (int round = 0; round < 2; ++round)
        for (int i = 0; i < 20000; ++i) warnings.add("line " + std::to_string(i));
    REQUIRE(warnings.lines.size() == 20000);
    CHECK(warnings.lines[19999] == "line 19999");
    warnings.lines.clear();
    warnings.add("line 7");
    warnings.add("line 7");
    CHECK(warnings.lines == std::vector<std::string>{"line 7"});
}

TEST_CASE("instances of one mesh share one BVH; another shape has its own", "[nodes][rigid]") {
    Scene scene = smallScene(makeObject(makeTorus(12, 8, 0.3F, 0.1F)), ggxMaterial(0.2F, 0.4F));
    for (int i = 1; i < 20; ++i) {
        Object copy = scene.objects[0];
        copy.placement.translation = Keyed<DVec3>(DVec3(0.1 * i, 0, 0));
        copy.placement.rotation = Keyed<DVec3>(DVec3(0.2 * i, 0.1, 0));
        scene.objects.push_back(copy);
    }
    RenderScene ready(scene, true);
    ready.setFrame(1);
    CHECK(ready.embree().instancedBvhs() == 1);
    scene.objects[3].placement.scale = Keyed<DVec3>(DVec3(1, 2, 1));
    scene.objects[4].placement.scale = Keyed<DVec3>(DVec3(1, 2, 1));
    scene.objects[5].mesh = std::make_shared<const Mesh>(makeTorus(12, 8, 0.3F, 0.2F));
    RenderScene three(scene, true);
    three.setFrame(1);
    CHECK(three.embree().instancedBvhs() == 3);
    // The picture is that of meshes with BVHs of their own.
    const auto picture = [&](RenderScene &of) {
        of.setFrame(2);
        FrameOptions options;
        options.spp = 16;
        options.seed = 1;
        return renderFrame(of, options).film.resolve();
    };
    Scene apart = scene;
    for (Object &object : apart.objects) object.mesh = std::make_shared<const Mesh>(*object.mesh);
    RenderScene own(apart, true);
    own.setFrame(1);
    CHECK(own.embree().instancedBvhs() == 20);
    CHECK(picture(three) == picture(own));
}

TEST_CASE("many nodes: case many-nodes renders", "[nodes]") {
    const auto path = caseFile("many-nodes/m2000s.glb");
    if (!path) return;
    Warnings warnings;
    RenderScene ready(loadScene(*path, {}, warnings), true);
    REQUIRE(ready.objects().size() == 2000);
    const std::size_t before = evaluations(ready);
    CHECK(before <= 4);
    ready.setFrame(1);
    ready.setFrame(2);
    CHECK(evaluations(ready) - before <= 2);
    CHECK(ready.embree().instancedBvhs() == 1);
}

TEST_CASE("loop on faces that are no triangles names file and face: case loop-quads", "[nodes][loop]") {
    if (const auto path = caseFile("loop-quads/a.toml")) {
        Warnings warnings;
        const std::string line = errorOf([&] { loadScene(*path, {}, warnings); });
        CHECK(line.find("a.toml:") != std::string::npos);
        CHECK(line.find("a.obj") != std::string::npos);
        CHECK(line.find("face 0 with 4 corners") != std::string::npos);
    }
    const std::string folder = outputFolder("nodes");
    writeTo(folder, "five.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0 0\nf 1 2 3\nf 1 3 4\nf 5 1 2 3 4\n");
    CHECK(says(errorOfText(folder, "[[mesh]]\nfile = \"five.obj\"\nsubdivision = 2\nscheme = \"loop\"\n"),
               "scene.toml:4:", {"face 2 with 5 corners", "five.obj", "triangles"}));
    CHECK(errorOfText(folder, "[[mesh]]\nfile = \"five.obj\"\nscheme = \"loop\"\n").empty()); // not subdivided
}
