/// Images lit by 1 to 100,000 emitters of the same light together, and by a large mesh that glows close to the ground.

#include "study/charts.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/scenes/scenes.h"
#include "study/text.h"

#include "taut/base/sobol.h"

namespace taut::chart {

namespace {

/// Uniform in [0, 1), by a count.
class Numbers {
  public:
    double operator()() { return hash(++count_) * 0x1p-32; }

  private:
    std::uint32_t count_ = 0;
};

/// Down, within 60 degrees: the camera looks down and sees no emitter, whose edges would be most of the noise.
DVec3 direction(Numbers &next) {
    const double z = -0.5 - 0.5 * next();
    const double r = std::sqrt(1 - z * z);
    const double phi = 2 * std::numbers::pi * next();
    return {r * std::cos(phi), r * std::sin(phi), z};
}

DVec3 across(const DVec3 &n) {
    return glm::normalize(glm::cross(n, std::fabs(n.x) < 0.6 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
}

/// Brushed torus on grey ground.
Scene ground(int size) {
    Scene scene = torusScene(makeTorus(200, 50, 0.7F, 0.3F), -0.3, {brushedMetal(0.08F, 0.4F), Material{}}, size, 3);
    scene.materials[1].color.value = Vec3(0.5F);
    scene.camera.position = DVec3(0, -1, 5.5);
    return scene;
}

/// A place among the emitters, not within the torus.
DVec3 placeOf(Numbers &next) {
    const double x = 12 * next() - 6;
    const double y = 12 * next() - 6;
    return {x, y, 0.2 + 2.5 * next()};
}

constexpr double kTotalArea = 0.5; ///< m^2, of one side
constexpr float kRadiance = 60;

void addTriangles(Scene &scene, int count) {
    Numbers next;
    Mesh mesh;
    const double edge = std::sqrt(kTotalArea / count * 4 / std::sqrt(3.0));
    for (int i = 0; i < count; ++i) {
        const DVec3 centre = placeOf(next);
        const DVec3 n = direction(next);
        const DVec3 s = across(n);
        const DVec3 t = glm::cross(n, s);
        for (int k = 0; k < 3; ++k) {
            const double phi = 2 * std::numbers::pi * k / 3;
            mesh.cornerPositions.push_back(static_cast<Index>(mesh.positions.size()));
            mesh.positions.emplace_back(centre + (s * std::cos(phi) + t * std::sin(phi)) * (edge / std::sqrt(3.0)));
        }
        mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
    }
    scene.objects.push_back(objectOf(std::move(mesh), 1));
    scene.objects.back().smooth = false;
    scene.objects.back().emission.value = Vec3(kRadiance);
}

void addLights(Scene &scene, bool quads, int count) {
    Numbers next;
    for (int i = 0; i < count; ++i) {
        const DVec3 at = placeOf(next);
        const DVec3 n = direction(next);
        const double edge = std::sqrt(kTotalArea / count);
        const DVec3 u = edge * across(n);
        if (quads)
            scene.lights.push_back({Vec3(kRadiance), QuadLight{at, u, glm::cross(n, u)}});
        else
            scene.lights.push_back({Vec3(static_cast<float>(kRadiance * kTotalArea / 2 / count)), PointLight{at}});
    }
}

/// A flat glowing torus that nearly lies on the ground around the other.
void addGlowingTorus(Scene &scene, int triangles) {
    const int across = std::max(4, static_cast<int>(std::sqrt(triangles / 16.0)));
    scene.objects.push_back(objectOf(makeTorus(triangles / 2 / across, across, 1.4F, 0.1F), 1));
    scene.objects.back().placement.translation = DVec3(0, 0, -0.18);
    scene.objects.back().emission.value = Vec3(4);
}

} // namespace

Chart measureLights(const ChartOptions &options) {
    const int spp = options.pick(4, 16);
    const int size = options.pick(64, 128);
    Chart chart{"lights", "Many lights",
                "A brushed torus on grey ground under emitters of the same light together, one to 100,000: triangles, quads and "
                "points; and beside a large mesh that glows close to the ground.",
                "Error is the relative mean square, of two seeds over the square of the mean. Error times seconds does not change "
                "with the number of samples: compare versions by it."};
    Panel panel = lines({"noise",
                         "Error times seconds by the number of emitters",
                         printed("%d x %d pixels, %d samples a pixel, all threads", size, size, spp),
                         {"emitters", ""},
                         {"relative MSE x seconds", "s"},
                         {}});
    Table table{"emitters", "Error and time", {"emitters", "", "mean", "rel. MSE", "render s", "build ms", "MSE x seconds"}, {}};
    const auto measure = [&](const char *name, int count, const Scene &scene) {
        RenderScene ready(scene, false);
        StageTimes times;
        ready.setFrame(1, times);
        const RenderedImage a = renderReady(ready, spp, 1);
        const RenderedImage b = renderReady(ready, spp, 2);
        const double mean = (meanOf(a.values) + meanOf(b.values)) / 2;
        const double error = errorOfTwo(a.values, b.values) / (mean * mean);
        const double seconds = (a.render + b.render) / 2;
        table.rows.push_back({name, std::to_string(count), printed("%.4f", mean), printed("%.3e", error), printed("%.3f", seconds),
                              printed("%.3f", 1e3 * times.bvh), printed("%.3e", error * seconds)});
        panel.points.push_back({name, "", {static_cast<double>(count)}, {error * seconds, 0, 2}});
    };
    for (const int count : {1, 10, 1000, 100000}) {
        Scene scene = ground(size);
        addTriangles(scene, count);
        measure("triangles", count, scene);
        for (const bool quads : {true, false}) {
            scene = ground(size);
            addLights(scene, quads, count);
            measure(quads ? "quads" : "points", count, scene);
        }
    }
    for (const int count : {1000, 100000}) {
        Scene scene = ground(size);
        addGlowingTorus(scene, count);
        measure("glowing torus", count, scene);
    }
    chart.panels.push_back(std::move(panel));
    chart.tables.push_back(std::move(table));
    return chart;
}

} // namespace taut::chart
