/// Cryptomatte, read back from the file by its specification (1.2.0): hashes, metadata, ranks and coverage; parts that merge; and Blender.

#include "cli_fixtures.h"

#include "taut/render/light_groups.h"
#include "taut/render/matte_id.h"

#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>
#include <cstring>
#include <iostream>
#include <map>

using namespace taut;
using namespace taut::test;

namespace {

// --- a reader of its own -------------------------------------------------------------------------------------------------

/// MurmurHash3_x86_32 of a name, as its author wrote it.
std::uint32_t hashOfName(const std::string &name) {
    std::uint32_t h1 = 0;
    const std::size_t blocks = name.size() / 4;
    for (std::size_t i = 0; i < blocks; ++i) {
        std::uint32_t k1 = 0;
        std::memcpy(&k1, name.data() + 4 * i, 4);
        k1 *= 0xcc9e2d51;
        k1 = (k1 << 15) | (k1 >> 17);
        k1 *= 0x1b873593;
        h1 ^= k1;
        h1 = (h1 << 13) | (h1 >> 19);
        h1 = h1 * 5 + 0xe6546b64;
    }
    const auto tail = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(name[4 * blocks + i])); };
    std::uint32_t k1 = 0;
    switch (name.size() & 3) {
    case 3: k1 ^= tail(2) << 16; [[fallthrough]];
    case 2: k1 ^= tail(1) << 8; [[fallthrough]];
    case 1:
        k1 ^= tail(0);
        k1 *= 0xcc9e2d51;
        k1 = (k1 << 15) | (k1 >> 17);
        k1 *= 0x1b873593;
        h1 ^= k1;
    }
    h1 ^= static_cast<std::uint32_t>(name.size());
    h1 ^= h1 >> 16;
    h1 *= 0x85ebca6b;
    h1 ^= h1 >> 13;
    h1 *= 0xc2b2ae35;
    h1 ^= h1 >> 16;
    return h1;
}

/// "uint32_to_float32": exponents 0 and 255 are moved to 1 and 254.
float floatOfName(const std::string &name) {
    std::uint32_t bits = hashOfName(name);
    const std::uint32_t exponent = (bits >> 23) & 255;
    if (exponent == 0 || exponent == 255) bits ^= 1U << 23;
    float value = 0;
    std::memcpy(&value, &bits, 4);
    return value;
}

/// A cryptomatte of an EXR file, by nothing but its metadata and channels.
class Cryptomatte {
  public:
    Cryptomatte(const std::string &path, const std::string &layer) : image_(readImage(path)), layer_(layer) {
        const std::string bytes = readBytes(path);
        const ImagePart part = imageCodec().open("openexr", bytes, path)->parts(false).at(0);
        std::map<std::string, std::string> attributes(part.attributes.begin(), part.attributes.end());
        std::string key;
        for (const auto &[name, value] : attributes)
            if (name.starts_with("cryptomatte/") && name.ends_with("/name") && value == layer) key = name.substr(0, name.size() - 4);
        char hex[9];
        std::snprintf(hex, sizeof hex, "%08x", hashOfName(layer));
        REQUIRE(key == "cryptomatte/" + std::string(hex).substr(0, 7) + "/");
        CHECK(attributes[key + "hash"] == "MurmurHash3_32");
        CHECK(attributes[key + "conversion"] == "uint32_to_float32");
        const nlohmann::json manifest = nlohmann::json::parse(attributes[key + "manifest"]);
        for (const auto &[name, value] : manifest.items()) {
            const auto bits = static_cast<std::uint32_t>(std::stoul(value.get<std::string>(), nullptr, 16));
            manifest_[name] = std::bit_cast<float>(bits);
        }
        while (std::find(image_.channels.begin(), image_.channels.end(), level(levels_) + ".R") != image_.channels.end()) ++levels_;
    }

    [[nodiscard]] const std::map<std::string, float> &manifest() const { return manifest_; }
    [[nodiscard]] int levels() const { return levels_; }
    [[nodiscard]] const Image &image() const { return image_; }

    [[nodiscard]] double coverage(const std::string &name, int x, int y) const {
        const float id = floatOfName(name);
        double sum = 0;
        eachRank(x, y, [&](float rank, double share) {
            if (std::bit_cast<std::uint32_t>(rank) == std::bit_cast<std::uint32_t>(id)) sum += share;
        });
        return sum;
    }
    /// Calls f(id, coverage) in the order of the ranks.
    template <class F> void eachRank(int x, int y, const F &f) const {
        for (int i = 0; i < levels_; ++i) {
            f(static_cast<float>(valueAt(image_, x, y, level(i) + ".R")), valueAt(image_, x, y, level(i) + ".G"));
            f(static_cast<float>(valueAt(image_, x, y, level(i) + ".B")), valueAt(image_, x, y, level(i) + ".A"));
        }
    }

  private:
    [[nodiscard]] std::string level(int i) const { return layer_ + (i < 10 ? "0" : "") + std::to_string(i); }

    Image image_;
    std::string layer_;
    std::map<std::string, float> manifest_;
    int levels_ = 0;
};

/// Rectangles seen from above by an orthographic camera, a pixel a unit, x and y from 0 at the upper left: edges within pixels.
struct Rectangle {
    const char *name;
    double x0, y0, x1, y1, z;
    const char *material;
};
constexpr int kPlateSide = 12;
constexpr Rectangle kRectangles[] = {
    {"left", 1.3, 1, 5, 11, 0, "red"}, {"right", 5, 2.25, 10, 9, 0, "blue"}, {"low", 7.6, 4, 9, 8, 1, "red"}};

/// Share of pixel (x, y) that rectangle `i` covers, where those above hide it.
double coveredBy(std::size_t i, int x, int y) {
    const auto within = [](double a0, double a1, double b0, double b1) { return std::max(0.0, std::min(a1, b1) - std::max(a0, b0)); };
    const auto share = [&](const Rectangle &r) { return within(x, x + 1, r.x0, r.x1) * within(y, y + 1, r.y0, r.y1); };
    return share(kRectangles[i]) - (i == 1 ? share(kRectangles[2]) : 0); // "low" lies over "right" alone
}

std::string rectangleScene(const std::string &folder, const std::string &more) {
    std::string toml =
        "[render]\nwidth = 12\nheight = 12\nfilter = \"box\"\nmax_events = 1\n[camera]\nposition = [6, -6, 20]\nlook_at = [6, -6, 0]\n"
        "up = [0, 1, 0]\northo_height = 12\n[environment]\nradiance = 1\ncamera_visible = false\n"
        "[material.red]\ncolor = [1, 0, 0]\n[material.blue]\ncolor = [0, 0, 1]\n" +
        more;
    for (const Rectangle &r : kRectangles) {
        std::ostringstream obj;
        obj << "v " << r.x0 << ' ' << -r.y1 << ' ' << r.z << "\nv " << r.x1 << ' ' << -r.y1 << ' ' << r.z << "\nv " << r.x1 << ' ' << -r.y0
            << ' ' << r.z << "\nv " << r.x0 << ' ' << -r.y0 << ' ' << r.z << "\nf 1 2 3 4\n";
        writeBytes(folder + "/" + r.name + ".obj", obj.str());
        toml += std::string("[[mesh]]\nfile = \"") + r.name + ".obj\"\nmaterial = \"" + r.material + "\"\n";
    }
    writeBytes(folder + "/scene.toml", toml);
    return folder + "/scene.toml";
}

const Arguments kLayers{"--aov", "depth,crypto_object,crypto_material,lights,samples,variance"};

Arguments with(Arguments words, const Arguments &more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

} // namespace

TEST_CASE("mattes: hashes of names are those that Cryptomatte's own tests know", "[mattes]") {
    // MurmurHash3's published vectors, seed 0.
    CHECK(murmurHash3("") == 0);
    CHECK(murmurHash3("test") == 0xba6bd213U);
    CHECK(murmurHash3("Hello, world!") == 0xc0363e43U);
    CHECK(murmurHash3("The quick brown fox jumps over the lazy dog") == 0x2e4ff723U);
    // Psyop's examples, as floats.
    CHECK(std::bit_cast<float>(matteId("hello")) == 6.0705627102400005616e-17F);
    CHECK(std::bit_cast<float>(matteId("cube")) == Approx(-4.08461912519e+15F));
    CHECK(std::bit_cast<float>(matteId("sphere")) == Approx(2.79018604383e+15F));
    CHECK(std::bit_cast<float>(matteId("plane")) == Approx(3.66557617593e-11F));
    int moved = 0;
    for (int i = 0; i < 20000; ++i) {
        const std::string name = "object_" + std::to_string(i);
        const auto id = std::bit_cast<float>(matteId(name));
        REQUIRE(std::isnormal(id));
        REQUIRE(std::bit_cast<std::uint32_t>(id) == std::bit_cast<std::uint32_t>(floatOfName(name)));
        moved += matteId(name) != murmurHash3(name) ? 1 : 0;
    }
    CHECK(moved > 50); // of about 156: exponents 0 and 255 come once in 128
}

TEST_CASE("mattes: coverage of objects and materials is that of their areas, within 1/255", "[mattes]") {
    const std::string folder = freshFolder("mattes");
    const std::string scene = rectangleScene(folder, "");
    const std::string path = folder + "/m.exr";
    requireSuccess(runTaut({"render", scene, "-q", "--spp", "1024", "--aov", "crypto_object,crypto_material", "-o", path}));
    const Cryptomatte objects(path, "CryptoObject");
    const Cryptomatte materials(path, "CryptoMaterial");
    CHECK(objects.levels() == 3);
    REQUIRE(objects.manifest().size() == 3);
    for (const auto &[name, id] : objects.manifest()) CHECK(id == floatOfName(name));
    CHECK(materials.manifest().size() == 2);
    double worst = 0;
    for (int y = 0; y < kPlateSide; ++y)
        for (int x = 0; x < kPlateSide; ++x) {
            CAPTURE(x, y);
            std::map<std::string, double> byMaterial;
            double all = 0;
            for (std::size_t i = 0; i < std::size(kRectangles); ++i) {
                const double covered = coveredBy(i, x, y);
                worst = std::max(worst, std::fabs(objects.coverage(kRectangles[i].name, x, y) - covered));
                byMaterial[kRectangles[i].material] += covered;
                all += covered;
            }
            for (const auto &[name, covered] : byMaterial) worst = std::max(worst, std::fabs(materials.coverage(name, x, y) - covered));
            // Ranks fall; what is seen of anything is alpha, and where nothing is there is no id.
            double before = 1;
            double sum = 0;
            objects.eachRank(x, y, [&](float id, double share) {
                CHECK(share <= before);
                CHECK((share > 0) == (id != 0));
                before = share;
                sum += share;
            });
            CHECK(sum == Approx(valueAt(objects.image(), x, y, "A")).epsilon(1e-6));
            if (all == 0) CHECK(sum == 0);
        }
    std::cout << "greatest error of coverage: " << worst * 255 << " / 255" << std::endl;
    CHECK(worst < 1.0 / 255);
}

TEST_CASE("mattes: a veil has the share of its opacity, glass hides what is behind it, blur and lens give fractions", "[mattes]") {
    const std::string folder = freshFolder("mattes_veil");
    const std::string veil = "[material.veil]\nopacity = 0.25\n[material.glass]\ntype = \"dielectric\"\n";
    writeBytes(folder + "/cover.obj", "v -20 -40 2\nv 60 -40 2\nv -20 40 2\nf 1 2 3\n");
    const std::string scene = rectangleScene(folder, veil + "[[mesh]]\nfile = \"cover.obj\"\nmaterial = \"veil\"\n");
    const auto render = [&](const std::string &name, const Arguments &more) {
        requireSuccess(runTaut(with({"render", scene, "-q", "--aov", "crypto_object,depth", "-o", folder + "/" + name}, more)));
        return Cryptomatte(folder + "/" + name, "CryptoObject");
    };
    const Cryptomatte seen = render("veil.exr", {"--spp", "256"});
    CHECK(std::fabs(seen.coverage("cover", 3, 5) - 0.25) < 1.0 / 255);
    CHECK(std::fabs(seen.coverage("left", 3, 5) - 0.75) < 1.0 / 255);
    CHECK(std::fabs(seen.coverage("cover", 0, 0) - 0.25) < 1.0 / 255);
    const Cryptomatte behind = render("glass.exr", {"--spp", "256", "-D", "mesh.0.material=glass"});
    CHECK(behind.coverage("cover", 3, 5) == 1);
    CHECK(behind.coverage("left", 3, 5) == 0);
    // A plate that goes from one pixel to the next while the shutter is open.
    const Cryptomatte blurred = render("blur.exr", {"--spp", "4096", "-D", "mesh.0.material=glass", "-D", "mesh.0.translate=[0,0,-100]",
                                                    "-D", "render.shutter=1", "-D", "mesh.3.translate=[[0,[-2,0,0]],[2,[2,0,0]]]"});
    for (int x = 5; x < 11; ++x) {
        double expected = 0;
        constexpr int kSteps = 1000;
        for (int i = 0; i < kSteps; ++i) {
            const double moved = -1 + 2 * (i + 0.5) / kSteps;
            expected += std::max(0.0, std::min(x + 1.0, 9 + moved) - std::max(static_cast<double>(x), 7.6 + moved)) / kSteps;
        }
        CAPTURE(x, expected);
        CHECK(blurred.coverage("low", x, 5) == Approx(expected).margin(0.02));
    }
}

TEST_CASE("mattes: parts of a frame with every layer merge into the very file of the whole, and so does one that was stopped",
          "[mattes][lights]") {
    const Workplace place("mattes_parts");
    const Arguments base =
        with({"render", place.scene, "-q", "--spp", "10", "-D", "render.shutter=0.7", "-D", "camera.aperture_radius=0.1"}, kLayers);
    const auto render = [&](const std::string &name, const Arguments &more) {
        return runTaut(with(with(base, {"-o", place.path(name)}), more));
    };
    requireSuccess(render("whole.exr", {}));
    const std::string whole = readBytes(place.path("whole.exr"));
    for (const std::string by : {"samples", "rows"}) {
        const std::string name = by + ".exr";
        for (const char *part : {"1/3", "2/3", "3/3"}) requireSuccess(render(name, {"--shard", part, "--shard-by", by}));
        requireSuccess(runTaut({"merge", "-q", "-o", place.path(name), place.path(name + ".1-of-3.shard"),
                                place.path(name + ".2-of-3.shard"), place.path(name + ".3-of-3.shard")}));
        CHECK(readBytes(place.path(name)) == whole);
    }
    // Stopped at once, then again and again.
    const CommandResult stopped = render("stopped.exr", {"--time-limit", "0.000001s"});
    CHECK(stopped.exitCode == 75);
    int stops = 1;
    while (render("stopped.exr", {"--resume", "--time-limit", "0.000001s"}).exitCode == 75 && stops < 1000) ++stops;
    CHECK(readBytes(place.path("stopped.exr")) == whole);
    // The picture is the one of those who ask for nothing.
    requireSuccess(runTaut({"render", place.scene, "-q", "--spp", "10", "-D", "render.shutter=0.7", "-D", "camera.aperture_radius=0.1",
                            "-o", place.path("plain.exr")}));
    const Image plain = readImage(place.path("plain.exr"));
    const Image all = readImage(place.path("whole.exr"));
    for (const std::string channel : {"R", "G", "B", "A"})
        for (int y = 0; y < plain.height; ++y)
            for (int x = 0; x < plain.width; ++x) REQUIRE(valueAt(plain, x, y, channel) == valueAt(all, x, y, channel));
    // Shards of other layers are no shards of this frame.
    requireSuccess(runTaut({"render", place.scene, "-q", "--spp", "10", "--aov", "samples", "--shard", "1/3", "--shard-by", "rows", "-o",
                            place.path("other.exr")}));
    checkUsageError(runTaut({"merge", "-o", place.path("m.exr"), place.path("other.exr.1-of-3.shard"), place.path("rows.exr.2-of-3.shard"),
                             place.path("rows.exr.3-of-3.shard")}),
                    "AOVs");
}

TEST_CASE("mattes: what is asked for in words", "[mattes]") {
    const Workplace place("mattes_words");
    checkUsageError(runTaut({"render", place.scene, "--aov", "crypto_objects"}), "did you mean 'crypto_object'?");
    checkUsageError(runTaut({"render", place.scene, "--aov", "varianse"}), "did you mean 'variance'?");
    CHECK(runTaut({"render", place.scene, "--aov", "crypto_object", "--crypto-ranks", "3"}).exitCode == 2);
    requireSuccess(runTaut({"render", place.scene, "-q", "--aov", "crypto_object", "--crypto-ranks", "2", "-o", place.path("two.exr"), "-o",
                            place.path("two.png")}));
    CHECK(Cryptomatte(place.path("two.exr"), "CryptoObject").levels() == 1);
    CHECK(metadata(place.path("two.png"), "taut:spp") == "4");
    for (const std::string &name : readImage(place.path("two.exr")).channels) CHECK((name.size() == 1 || name.starts_with("Crypto")));
}

TEST_CASE("mattes: Blender's compositor keys an object where Blender is, and reads every layer", "[mattes][blender]") {
    if (runProgram({"blender", "--version"}, 60).exitCode != 0) {
        std::cout << "SKIPPED: there is no Blender on this machine" << std::endl;
        return;
    }
    const std::string folder = freshFolder("mattes_blender");
    const std::string scene = rectangleScene(folder, "");
    const std::string path = folder + "/m.exr";
    requireSuccess(
        runTaut({"render", scene, "-q", "--spp", "64", "--aov", "all,crypto_object,crypto_material,lights,samples,variance", "-o", path}));
    for (const auto &[layer, name] : {std::pair<std::string, std::string>{"CryptoObject", "right"}, {"CryptoMaterial", "red"}}) {
        const std::string matte = folder + "/" + name + ".exr";
        const CommandResult ran =
            runProgram({"env", "PATH=/usr/bin:/bin:/usr/sbin", "blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P",
                        TAUT_SOURCE_DIR "/tests/blender/matte_key.py", "--", path, "12", "12", matte, layer, name},
                       300);
        INFO(ran.out << ran.err);
        REQUIRE(ran.exitCode == 0);
        for (const std::string &channel : readImage(path).channels) {
            const std::string pass = channel == "Z" ? "Depth"
                                     : channel.size() == 1 && std::string("RGBA").find(channel) != std::string::npos
                                         ? "Combined"
                                         : channel.substr(0, channel.find('.'));
            CAPTURE(channel, pass);
            CHECK(ran.out.find("pass " + pass + "\n") != std::string::npos);
        }
        CHECK(ran.out.find("unknown channel") == std::string::npos);
        const Image keyed = readImage(matte);
        const Cryptomatte own(path, layer);
        double worst = 0;
        double sum = 0;
        for (int y = 0; y < kPlateSide; ++y)
            for (int x = 0; x < kPlateSide; ++x) {
                worst = std::max(worst, std::fabs(valueAt(keyed, x, y, "R") - own.coverage(name, x, y)));
                sum += own.coverage(name, x, y);
            }
        std::cout << "Blender's matte of " << name << ": greatest difference " << worst << ", " << sum << " pixels" << std::endl;
        CHECK(worst < 1e-5);
        CHECK(sum > 10);
    }
}
