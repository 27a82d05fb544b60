/// Light groups, whose sums are the picture, and the variance of a pixel's mean.

#include "catch.h"
#include "render_fixtures.h"
#include "scene_fixtures.h"

#include "study/measures/image_error.h"
#include "taut/base/error.h"
#include "taut/render/light_groups.h"

#include <cmath>
#include <iostream>

using namespace taut;
using namespace taut::test;

namespace {

FilmLayers layersNamed(const std::vector<std::string> &names) {
    return filmContentsNamed(names, "test").layers;
}

Film filmOf(const Scene &scene, FrameOptions options) {
    RenderScene ready(scene, false);
    ready.setFrame(1);
    return renderFrame(ready, options).film;
}

/// Every kind of light, three of them in groups, over a torus that shines a little and has an unlit neighbour.
Scene manyKinds(int size = 40) {
    Scene scene = smallScene(makeObject(makeTorus(24, 12, 0.7F, 0.25F)), ggxMaterial(0.2F, 0.4F), size);
    scene.lightGroups = {"key", "rim"};
    scene.lights[0].group = 0;
    scene.lights.push_back({Vec3(9, 3, 1), SphereLight{DVec3(-1, -0.5, 1), 0.15}, true, 1});
    scene.lights.push_back({Vec3(1, 2, 3), PointLight{DVec3(1, 1, 1.5)}, false, 1});
    scene.lights.push_back({Vec3(0.5F), DirectionalLight{DVec3(0.6, 0, -0.8)}});
    scene.objects[0].emission.value = Vec3(0.1F, 0.05F, 0.02F);
    Material unlit;
    unlit.name = "unlit";
    unlit.unlit = true;
    unlit.color.value = Vec3(0.2F, 0.8F, 0.4F);
    scene.materials.push_back(unlit);
    scene.objects.push_back(makeObject(makeSphere(16, 8, 0.3F), 1));
    return scene;
}

/// The means of one layer's R, G and B.
std::vector<float> layerOf(const Film &film, const std::string &layer) {
    const std::vector<std::string> names = film.channelNames();
    const std::vector<float> values = film.resolve();
    const auto at = static_cast<std::size_t>(std::find(names.begin(), names.end(), layer.empty() ? "R" : layer + ".R") - names.begin());
    REQUIRE(at < names.size());
    std::vector<float> rgb;
    for (std::size_t i = 0; i < values.size(); i += names.size())
        rgb.insert(rgb.end(), values.begin() + static_cast<std::ptrdiff_t>(i + at),
                   values.begin() + static_cast<std::ptrdiff_t>(i + at + 3));
    return rgb;
}

} // namespace

TEST_CASE("lights: groups sum to the picture within the rounding of floats", "[lights]") {
    Scene scene = manyKinds();
    for (const bool sky : {false, true}) {
        if (sky) scene.environment = studioEnvironment();
        FrameOptions options;
        options.spp = 16;
        options.layers = layersNamed({"lights"});
        const Film film = filmOf(scene, options);
        const std::vector<std::string> groups = film.layers().lightGroups;
        CHECK(groups == std::vector<std::string>{"emission", "environment", "key", "rim", "directional"});
        const std::vector<float> whole = layerOf(film, "");
        std::vector<double> sum(whole.size());
        for (const std::string &group : groups) {
            const std::vector<float> part = layerOf(film, "Light_" + group);
            CHECK(chart::meanOf(part) > 0.001);
            for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(part[i]);
        }
        // Each is the exact sum rounded once.
        double worst = 0;
        for (std::size_t i = 0; i < sum.size(); ++i)
            if (whole[i] > 0) worst = std::max(worst, std::fabs(sum[i] / static_cast<double>(whole[i]) - 1));
        std::cout << "groups against the picture: " << worst << std::endl;
        CHECK(worst < 0x1p-23);
        // Hits that are shaded at once and one by one, with groups and without: the same bits.
        options.oneByOne = true;
        CHECK(filmOf(scene, options) == film);
        options.layers = {};
        CHECK(layerOf(filmOf(scene, options), "") == whole);
    }
}

TEST_CASE("lights: a group is what its lights alone send", "[lights]") {
    const Scene scene = manyKinds(24);
    FrameOptions options;
    options.spp = 256;
    options.layers = layersNamed({"lights"});
    const Film film = filmOf(scene, options);
    for (const std::string &group : film.layers().lightGroups) {
        Scene alone = scene;
        alone.lights.clear();
        for (const Light &light : scene.lights) {
            const std::string name = light.group == kNone ? "directional" : scene.lightGroups[light.group];
            if (name == group) alone.lights.push_back(light);
        }
        if (group != "environment") alone.environment.reset();
        if (group != "emission") {
            alone.objects[0].emission.value = Vec3(0);
            alone.materials[1].color.value = Vec3(0); // unlit and black: it still hides what is behind it
        }
        const double own = chart::meanOf(layerOf(film, "Light_" + group));
        const double expected = chart::meanOf(layerOf(filmOf(alone, options), ""));
        CAPTURE(group);
        CHECK(own == Approx(expected).epsilon(0.02));
    }
}

TEST_CASE("lights: groups in scene files, by default and by name", "[lights][scene]") {
    const std::string folder = sceneFolder("light_groups");
    const auto groupsOf = [&](const std::string &toml) {
        writeTo(folder, "scene.toml", toml);
        Warnings warnings;
        return lightGroupNames(loadScene(folder + "/scene.toml", {}, warnings));
    };
    const std::string mesh = "[[mesh]]\nfile = \"panel.obj\"\n";
    CHECK(groupsOf(mesh) == std::vector<std::string>{"emission", "environment"});
    CHECK(groupsOf(mesh + "[[light]]\n[[light]]\ntype = \"point\"\n[[light]]\ngroup = \"key\"\n") ==
          std::vector<std::string>{"emission", "environment", "quad", "point", "key"});
    // A light may join the environment; a mesh that shines has its light's group, else its own.
    CHECK(groupsOf(mesh + "[[light]]\ngroup = \"environment\"\n[[light]]\ntype = \"mesh\"\nmesh = \"panel\"\ngroup = \"lamp\"\n") ==
          std::vector<std::string>{"emission", "environment", "lamp"});
    CHECK(groupsOf(mesh + "group = \"neon\"\n[[light]]\ntype = \"mesh\"\nmesh = \"panel\"\n") ==
          std::vector<std::string>{"emission", "environment", "neon"});
    CHECK(errorOfText(folder, mesh + "[[light]]\ngroup = \"a.b\"\n").find(":4:9: found 'a.b', expected a name of 1 to 40 letters") !=
          std::string::npos);
    CHECK(errorOfText(folder, mesh + "[[light]]\ngroup = 3\n").find(":4:9: found") != std::string::npos);
    CHECK(errorOfText(folder, mesh + "[[light]]\ngruop = \"a\"\n").find("did you mean 'group'?") != std::string::npos);
}

TEST_CASE("variance: of known samples it is s^2 / n, of equal ones zero, of one infinite", "[lights][film]") {
    const FilmLayers layers = layersNamed({"samples", "variance"});
    const auto filmWith = [&](const std::vector<float> &values) {
        Film film({0, 0, 1, 1}, {}, layers);
        for (const float v : values) {
            film.add(0, 0, Vec3(v, 0.1F, v * v), 1, nullptr);
            film.addLayers(0, 0, Vec3(v, 0.1F, v * v), {});
        }
        return film;
    };
    const Film film = filmWith({1, 2, 3, 4});
    CHECK(film.channelNames() == std::vector<std::string>{"R", "G", "B", "A", "Samples.X", "Variance.R", "Variance.G", "Variance.B"});
    const std::vector<float> values = film.resolve();
    CHECK(values[4] == 4);
    CHECK(values[5] == Approx(5.0 / 3 / 4)); // mean 2.5, squares 2.25 + .25 + .25 + 2.25
    CHECK(values[6] == 0);
    CHECK(values[7] == Approx(129.0 / 3 / 4)); // 1, 4, 9, 16: mean 7.5
    CHECK(filmWith({7}).resolve()[5] == kInfinity);
    // A little noise on much light, which single precision would lose.
    const std::vector<float> bright = filmWith({1000, 1000.001F, 1000, 1000.001F}).resolve();
    CHECK(bright[5] == Approx(sqr(static_cast<double>(1000.001F - 1000.0F)) / 12).epsilon(1e-4));
    // Merged it is the same.
    Film parts = filmWith({1, 2});
    parts.merge(filmWith({3, 4}));
    CHECK(parts == film);
}

TEST_CASE("variance: without bias where samples are independent, adaptive too; else an upper bound on average", "[lights]") {
    const Scene scene = manyKinds(16);
    constexpr int kSeeds = 48;
    for (const auto &[independent, adaptive] : {std::pair{true, false}, {true, true}, {false, false}}) {
        FrameOptions options;
        options.spp = adaptive ? 64 : 24;
        if (adaptive) options.noise = 0.1;
        options.independent = independent;
        options.layers = layersNamed({"variance"});
        std::vector<std::vector<double>> means;
        double said = 0;
        for (int seed = 0; seed < kSeeds; ++seed) {
            options.seed = static_cast<std::uint32_t>(seed);
            const Film film = filmOf(scene, options);
            const std::vector<float> rgb = layerOf(film, "");
            means.emplace_back(rgb.begin(), rgb.end());
            said += chart::meanOf(layerOf(film, "Variance")) / kSeeds;
        }
        double found = 0;
        for (std::size_t i = 0; i < means[0].size(); ++i) {
            double mean = 0;
            double squares = 0;
            for (const std::vector<double> &m : means) mean += m[i] / kSeeds;
            for (const std::vector<double> &m : means) squares += sqr(m[i] - mean);
            found += squares / (kSeeds - 1) / static_cast<double>(means[0].size());
        }
        std::cout << "variance of the mean: " << said << " said, " << found << " over seeds" << (independent ? ", independent" : "")
                  << (adaptive ? ", adaptive" : "") << std::endl;
        if (independent)
            CHECK(said == Approx(found).epsilon(0.12));
        else
            CHECK(said > found);
    }
}
