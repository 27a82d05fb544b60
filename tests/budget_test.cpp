/// What small inputs may ask for, over everything together: refused before it is spent, with what would allow it.

#include "command.h"
#include "mesh_samples.h"

#include "taut/base/budget.h"
#include "taut/formats/point_cache.h"
#include "taut/mesh/triangulate.h"
#include "taut/render/embree_scene.h"
#include "taut/render/frame_render.h"
#include "taut/scene/environment.h"
#include "taut/scene/load_scene.h"
#include "taut/scene/memory_estimate.h"
#include "taut/scene/texture.h"

#include <cmath>
#include <filesystem>

using namespace taut;
using namespace taut::test;
using Catch::Contains;

namespace {

std::string polygon(int corners) {
    std::string obj;
    std::string face = "f";
    for (int i = 0; i < corners; ++i) {
        obj += "v " + std::to_string(std::cos(kTwoPi * i / corners)) + ' ' + std::to_string(std::sin(kTwoPi * i / corners)) + " 0\n";
        face += ' ' + std::to_string(i + 1);
    }
    return obj + face + '\n';
}

std::string quads(int side) {
    std::string obj;
    for (int y = 0; y <= side; ++y)
        for (int x = 0; x <= side; ++x) obj += "v " + std::to_string(x) + ' ' + std::to_string(y) + " 0\n";
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const int a = y * (side + 1) + x + 1;
            obj += "f " + std::to_string(a) + ' ' + std::to_string(a + 1) + ' ' + std::to_string(a + side + 2) + ' ' +
                   std::to_string(a + side + 1) + '\n';
        }
    return obj;
}

/// What a scene file beside `mesh.obj` is refused with; empty where it loads.
std::string refusal(const std::string &toml, const std::string &obj, std::shared_ptr<Budget> budget = nullptr) {
    writeFile("mesh.obj", obj);
    Warnings warnings;
    try {
        static_cast<void>(loadScene(writeFile("limit.toml", toml), {}, warnings, std::move(budget)));
        return {};
    } catch (const LimitError &error) {
        return error.what();
    }
}

std::string many(const std::string &before, const std::string &item, int count, const std::string &after) {
    std::string text = before;
    for (int i = 0; i < count; ++i) text += (i > 0 ? "," : "") + item;
    return text + after;
}

std::string bytesOf(std::initializer_list<int> values) {
    std::string out;
    for (const int value : values) out += static_cast<char>(value);
    return out;
}

} // namespace

TEST_CASE("A budget counts what all ask for together", "[budget]") {
    Budget budget(1000.0);
    budget.take(600, "a", "one");
    CHECK(budget.left() == Approx(400));
    budget.require(400, "a", "as much as is left");
    CHECK_THROWS_WITH(budget.take(401, "b.obj:3", "two"), Contains("b.obj:3: found two") && Contains("--max-memory"));
    CHECK(budget.left() == Approx(400));
    // Products of counts don't wrap.
    CHECK_THROWS_AS(budget.take(4294967295.0 * 4294967295.0 * 12, "c", "a product"), LimitError);
    CHECK_THROWS_WITH(budget.work(1e6, "d", "many steps"), Contains("d: found many steps") && Contains(" s to prepare"));
    Budget own;
    own.addInput(std::size_t{1} << 30);
    CHECK(own.most() == Approx(kMemoryPerInputByte * 0x1p30));
}

TEST_CASE("Memory is given as people write it", "[budget]") {
    CHECK(memorySize("8g", "--max-memory") == 8 * 0x1p30);
    CHECK(memorySize("1.5G", "--max-memory") == 1.5 * 0x1p30);
    CHECK(memorySize("512m", "--max-memory") == 512 * 0x1p20);
    CHECK(memorySize("1000", "--max-memory") == 1000);
    for (const char *wrong : {"", "8x", "-1g", "0", "g", "1gb", "inf", "nan"})
        CHECK_THROWS_WITH(memorySize(wrong, "--max-memory"), Contains("--max-memory: found"));
}

TEST_CASE("Small files that ask for much are refused before it is spent", "[budget]") {
    const std::string mesh = "[[mesh]]\nfile = \"mesh.obj\"\n";
    SECTION("a polygon under subdivision") {
        CHECK_THAT(refusal(mesh + "subdivision = 1\n", polygon(16000)), Contains("mesh 'mesh'") && Contains("--max-memory"));
        CHECK(refusal(mesh + "subdivision = 1\n", polygon(500)).empty());
    }
    SECTION("a level") {
        CHECK_THAT(refusal(mesh + "subdivision = 5\n", quads(100)), Contains("at level 5"));
        CHECK(refusal(mesh + "subdivision = 5\n", quads(100), std::make_shared<Budget>(64 * 0x1p30)).empty());
    }
    SECTION("one mesh many times") {
        CHECK_THAT(refusal(many("mesh = [", "{ file = \"mesh.obj\" }", 2000, "]\n"), quads(100)), Contains("mesh 'mesh_"));
    }
    SECTION("times within the shutter") {
        const std::string moving = mesh + "deform = [{ type = \"twist\", angle_deg = [[1, 0], [9, 90]] }]\nsubdivision = 3\n";
        CHECK_THAT(refusal("[render]\nshutter = 1\nmotion_steps = 128\n" + moving, quads(100)), Contains("triangles"));
    }
    SECTION("deformers") {
        CHECK_THAT(refusal(mesh + many("deform = [", "{ type = \"twist\", angle_deg = 1 }", 20000, "]\n"), quads(100)),
                   Contains("20000 deformers") && Contains(" s to prepare"));
    }
    SECTION("lattices") {
        CHECK_THAT(refusal(mesh + many("deform = [", "{ type = \"lattice\", points = [16, 16, 16] }", 6000, "]\n"), quads(1)),
                   Contains("a lattice"));
    }
    SECTION("lights over materials") {
        std::string toml = many("light = [", "{ type = \"point\" }", 20000, "]\n");
        toml += many("mesh = [", "{ file = \"mesh.obj\" }", 1000, "]\n");
        CHECK_THAT(refusal(toml, quads(1)), Contains("20000 lights"));
    }
}

TEST_CASE("A polygon that comes back to few places is cut in bounded time", "[budget]") {
    std::vector<Vec3> points;
    for (int i = 0; i < 100000; ++i) points.emplace_back(i % 4 == 1 || i % 4 == 2 ? 1 : 0, i % 4 >= 2 ? 1 : 0, 0);
    std::vector<Index3> triangles;
    triangulate(points, triangles);
    CHECK(triangles.size() == points.size() - 2);
}

TEST_CASE("Automatic levels stay within the limit", "[budget]") {
    writeFile("mesh.obj", quads(60));
    Warnings warnings;
    const std::string path = writeFile("auto.toml", "[[mesh]]\nfile = \"mesh.obj\"\nsubdivision = \"auto\"\n");
    const Scene small = loadScene(path, {}, warnings);
    const Scene large = loadScene(path, {}, warnings, std::make_shared<Budget>(64 * 0x1p30));
    const int level = levelWithin(small.budget.get(), small.objects[0], small.render, 5);
    CHECK(level < levelWithin(large.budget.get(), large.objects[0], large.render, 5));
    CHECK(objectBytes(small.objects[0], small.render, level) <= small.budget->left());
}

TEST_CASE("A picture's film is counted", "[budget]") {
    writeFile("mesh.obj", quads(1));
    Warnings warnings;
    const std::string path = writeFile("film.toml", "[render]\nwidth = 32768\nheight = 32768\n[[mesh]]\nfile = \"mesh.obj\"\n");
    RenderScene ready(loadScene(path, {}, warnings), false);
    StageTimes times;
    ready.setFrame(1, times);
    FrameOptions options;
    CHECK_THROWS_WITH(FrameRender(ready, options), Contains("32768 x 32768 pixels of 4 channels") && Contains("--max-memory"));
    options.window = {0, 0, 16, 16};
    CHECK_NOTHROW(FrameRender(ready, options));
}

TEST_CASE("Parts of glTF files that are shared count each time", "[budget]") {
    GltfBuilder b;
    std::vector<float> positions;
    for (int i = 0; i < 3999; ++i) positions.insert(positions.end(), {static_cast<float>(i % 60), static_cast<float>(i / 60), static_cast<float>(i * 7 % 5)});
    const int accessor = b.addFloats("VEC3", positions);
    b.json["nodes"] = {{{"mesh", 0}}};
    b.json["scenes"] = {{{"nodes", {0}}}};
    const auto refused = [&](const std::string &name) {
        Warnings warnings;
        try {
            static_cast<void>(loadScene(writeFile(name, b.gltf()), {}, warnings));
        } catch (const LimitError &error) {
            return std::string(error.what());
        }
        return std::string();
    };
    SECTION("primitives over one accessor") {
        const nlohmann::json primitive = {{"attributes", {{"POSITION", accessor}}}, {"mode", 5}};
        b.json["meshes"] = {{{"primitives", std::vector<nlohmann::json>(700, primitive)}}};
        CHECK_THAT(refused("shared.gltf"), Contains("triangles") && Contains("--max-memory"));
    }
    SECTION("morph targets that say nothing") {
        b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", accessor}}}, {"targets", std::vector<nlohmann::json>(50000, nlohmann::json::object())}}}}}};
        CHECK_THAT(refused("morphs.gltf"), Contains("50000 morph targets"));
    }
    SECTION("materials of variants") {
        nlohmann::json primitives = nlohmann::json::array();
        for (int p = 0; p < 3000; ++p)
            primitives.push_back({{"attributes", {{"POSITION", accessor}}},
                                  {"extensions", {{"KHR_materials_variants", {{"mappings", {{{"material", 0}, {"variants", {p}}}}}}}}}});
        b.json["meshes"] = {{{"primitives", primitives}}};
        b.json["materials"] = {nlohmann::json::object()};
        b.json["extensions"] = {{"KHR_materials_variants", {{"variants", std::vector<nlohmann::json>(20000, {{"name", "a"}})}}}};
        CHECK_THAT(refused("variants.gltf"), Contains("--max-memory"));
    }
    SECTION("a chain of nodes with a mesh each") {
        nlohmann::json nodes = nlohmann::json::array();
        for (int n = 0; n < 5000; ++n) nodes.push_back({{"mesh", 0}, {"children", {n + 1}}});
        nodes.push_back({{"mesh", 0}});
        b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0})}}}}}}}};
        b.json["nodes"] = nodes;
        CHECK_THAT(refused("chain.gltf"), Contains("within") && Contains(" s to prepare"));
    }
    SECTION("a motion of many keys under a scale, of many nodes") {
        // A rotation about the axis of the scale: every key has to be looked at.
        constexpr int kKeys = 4000;
        std::vector<float> times(kKeys);
        std::vector<float> turns;
        for (int i = 0; i < kKeys; ++i) {
            times[static_cast<std::size_t>(i)] = static_cast<float>(i);
            turns.insert(turns.end(), {0, std::sin(0.01F * static_cast<float>(i)), 0, std::cos(0.01F * static_cast<float>(i))});
        }
        b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0})}}}}}}}};
        nlohmann::json nodes = {{{"scale", {1, 2, 1}}, {"children", nlohmann::json::array()}}};
        nlohmann::json channels = nlohmann::json::array();
        for (int n = 1; n <= 1200; ++n) {
            nodes.push_back({{"mesh", 0}});
            nodes[0]["children"].push_back(n);
            channels.push_back({{"sampler", 0}, {"target", {{"node", n}, {"path", "rotation"}}}});
        }
        b.json["nodes"] = nodes;
        b.json["animations"] = {{{"samplers", {{{"input", b.addFloats("SCALAR", times)}, {"output", b.addFloats("VEC4", turns)}}}}, {"channels", channels}}};
        CHECK_THAT(refused("keys.gltf"), Contains("placements of nodes") && Contains(" s to prepare"));
    }
    SECTION("instances of a node with a long name") {
        std::vector<float> places(3 * 5000, 0.0F);
        b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", accessor}}}}}}}};
        b.json["nodes"] = {{{"mesh", 0}, {"name", std::string(400000, 'n')}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", b.addFloats("VEC3", places)}}}}}}}}};
        CHECK_THAT(refused("instances.gltf"), Contains("5000 instances"));
    }
}

TEST_CASE("budget: what an export takes is counted", "[budget][export]") {
    const std::string folder = freshFolder("export_many");
    writeBytes(folder + "/quad.obj", quads(1));
    const std::string meshes = many("mesh = [", "{file = \"quad.obj\"}", 20000, "]\n");
    writeBytes(folder + "/many.toml", meshes);
    for (const auto &[output, says] : {std::pair<std::string, std::string>{"all.csv", "20000 files, with which a frame takes"},
                                       {"all.glb", "20000 meshes in a glTF file"}}) {
        const CommandResult refused = runTaut({"export", folder + "/many.toml", "--frames", "1", "-o", folder + "/" + output, "--max-memory", "500m"});
        INFO(refused.err);
        CHECK(refused.exitCode == 2);
        CHECK(errorLine(refused).find(says) != std::string::npos);
    }
    CHECK(namesIn(folder).size() == 2);
}

TEST_CASE("Images are measured by their headers before a decoder is asked", "[budget]") {
    Warnings warnings;
    const auto read = [&](const std::string &bytes) {
        return readTextureFromMemory("image", {bytes.begin(), bytes.end()}, ColorSpace::Auto, warnings);
    };
    const std::string exr = bytesOf({0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0});
    const auto attribute = [](const std::string &name, const std::string &type, std::initializer_list<std::int32_t> words) {
        std::string out = name + '\0' + type + '\0';
        append(out, static_cast<std::uint32_t>(4 * words.size()));
        appendAll(out, words);
        return out;
    };
    SECTION("an attribute longer than the file") {
        CHECK_THROWS_WITH(read(exr + std::string("a\0b\0\xff\xff\xff\x7f", 8)), Contains("OpenEXR attribute of 2147483647 bytes"));
    }
    SECTION("a window") {
        const std::string header = exr + attribute("dataWindow", "box2i", {0, 0, 2147483646, 0}) + attribute("displayWindow", "box2i", {0, 0, 9, 9});
        CHECK_THROWS_WITH(read(header + '\0'), Contains("32768 texels a side"));
    }
    SECTION("tiles") {
        const std::string header = exr + attribute("dataWindow", "box2i", {0, 0, 99, 99}) + attribute("displayWindow", "box2i", {0, 0, 99, 99}) +
                                   std::string("tiles\0tiledesc\0\x09\0\0\0\xff\xff\xff\x7f\xff\xff\xff\x7f\0", 28) +
                                   std::string("channels\0chlist\0\x13\0\0\0R\0", 22) + std::string(16, '\0') + '\0';
        CHECK_THROWS_AS(read(header + '\0'), LimitError);
    }
    SECTION("a table of chunks") {
        CHECK_THROWS_WITH(read(exr + attribute("dataWindow", "box2i", {0, 0, 9, 9}) + attribute("displayWindow", "box2i", {0, 0, 9, 9}) +
                               attribute("chunkCount", "int", {0x10000000}) + '\0'),
                          Contains("268435456 chunks"));
    }
    SECTION("an attribute that is not as long as its type") {
        CHECK_THROWS_WITH(read(exr + attribute("displayWindow", "box2i", {0, 0}) + '\0'), Contains("'box2i'") && Contains("not as long as its type"));
        CHECK_THROWS_WITH(read(exr + attribute("a", "stringvector", {0x40000000}) + '\0'), Contains("not as long as its type"));
    }
    SECTION("a map of radiance") {
        const std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 32768\n" + std::string(50000, '\2');
        CHECK_THROWS_WITH(readEnvironment(writeFile("large.hdr", hdr), 0, Vec3(1), warnings), Contains("32768 x 8192 texels") && Contains("--max-memory"));
    }
    SECTION("a progressive JPEG") {
        const std::string jpeg = bytesOf({0xff, 0xd8, 0xff, 0xc2, 0, 17, 8, 0x40, 0, 0x40, 0, 3}) + std::string(9, '\1') + bytesOf({0xff, 0xd9});
        CHECK_THROWS_WITH(read(jpeg), Contains("16384 x 16384 texels"));
    }
    SECTION("WebP and TGA") {
        const std::string webp = "RIFF" + std::string(4, '\1') + "WEBPVP8X" + std::string(8, '\0') + bytesOf({0xff, 0x3f, 0, 0xff, 0x3f, 0});
        CHECK_THROWS_WITH(read(webp), Contains("16384 x 16384 texels"));
        std::string tga(18, '\0');
        tga[2] = 2;
        tga[12] = tga[14] = '\0';
        tga[13] = tga[15] = '\x40';
        tga[16] = 32;
        CHECK_THROWS_WITH(readTextureFromMemory("a.tga", {tga.begin(), tga.end()}, ColorSpace::Auto, warnings), Contains("16384 x 16384 texels"));
    }
}

TEST_CASE("A point cache whose counts wrap as products is refused", "[budget]") {
    std::string pc2("POINTCACHE2\0", 12);
    appendAll<std::uint32_t>(pc2, {1, 1824726041, 0x3f800000, 0x3f800000, 842443544});
    const std::string path = writeFile("wrap.pc2", pc2 + std::string(32, '\0')); // 12 x points x samples, modulo 2^64
    CHECK_THROWS_WITH(PointCacheReader(path), Contains("wrap.pc2") && Contains("fewer points and samples"));
    std::string mdd;
    appendAll<std::uint32_t>(mdd, {0x7fffffff, 0x7fffffff}, true);
    CHECK_THROWS_AS(PointCacheReader(writeFile("wrap.mdd", mdd + std::string(64, '\0'))), InputError);
}

TEST_CASE("URIs that no file system takes are bad input", "[budget]") {
    GltfBuilder b;
    const int accessor = b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", accessor}}}}}}}};
    nlohmann::json file = b.json;
    const auto refused = [&](const std::string &uri) {
        file["buffers"] = {{{"byteLength", 36}, {"uri", uri}}};
        Warnings warnings;
        try {
            readGltf(writeFile("uri.gltf", file.dump()), warnings);
        } catch (const InputError &error) {
            return std::string(error.what());
        }
        return std::string();
    };
    CHECK_THAT(refused(std::string(300, 'x') + ".bin"), Contains("which is no file"));
    const std::filesystem::path loop = std::filesystem::path(outputFolder("mesh")) / "loop.bin";
    std::filesystem::remove(loop);
    std::filesystem::create_symlink("loop.bin", loop);
    CHECK_THAT(refused("loop.bin"), Contains("which is no file"));
}

TEST_CASE("budget: --max-memory raises the limit by hand", "[budget][cli]") {
    writeFile("mesh.obj", quads(60));
    const std::string scene = writeFile("raised.toml", "[[mesh]]\nfile = \"mesh.obj\"\nsubdivision = 5\n");
    const CommandResult refused = runTaut({"render", "--check", "-q", scene});
    CHECK(refused.exitCode == 2);
    CHECK_THAT(errorLine(refused), Contains("--max-memory"));
    CHECK(runTaut({"render", "--check", "-q", scene, "-D", "mesh.0.subdivision=1"}).exitCode == 0);
    CHECK_THAT(errorLine(runTaut({"render", "--check", scene, "-D", "mesh.0.subdivision=1", "--max-memory", "1m"})), Contains("expected at most 1 MB"));
    CHECK_THAT(errorLine(runTaut({"info", "--max-memory", "5x", scene})), Contains("an amount of memory"));
}

TEST_CASE("Rays that Embree would end the process at meet nothing", "[render]") {
    EmbreeScene embree(false);
    const std::vector<Vec3> corners{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0), Vec3(0)};
    const std::vector<Index3> triangle{Index3(0, 1, 2)};
    embree.addTriangles({std::span<const Vec3>(corners)}, {triangle});
    embree.commit();
    const float nan = std::nanf("");
    std::vector<Ray> rays(20);
    for (Ray &ray : rays) ray = {Vec3(0, 0, 1), 0, Vec3(0, 0, -1), kInfinity, 0};
    rays[1].origin.x = nan;
    rays[2].direction.y = nan;
    rays[3].origin.z = 3e18F;
    rays[4].direction.z = -kInfinity;
    rays[5].farthest = nan;
    std::vector<Hit> hits(rays.size());
    std::vector<unsigned char> blocked(rays.size());
    for (const bool coherent : {true, false}) {
        embree.intersect(rays, coherent, hits, nullptr);
        for (std::size_t i = 0; i < rays.size(); ++i) CHECK((hits[i].geometry != kNone) == (i == 0 || i > 5));
    }
    embree.occluded(rays, blocked, nullptr);
    for (const unsigned char one : blocked) CHECK(one == 1);
}
