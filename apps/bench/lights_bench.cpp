/// taut_lights_bench [samples a pixel] [width and height] [most emitters]: error and time of small images lit by 1 to 100,000
/// emitters of the same light together, and by a large mesh that glows close to the ground. Error: relative mean square, of two
/// seeds (chart/equal_error.h) over the square of the mean. Compare two versions by the last column, error x seconds.

#include "study/equal_error.h"
#include "study/render_image.h"

#include "taut/base/sobol.h"
#include "taut/mesh/shapes.h"

#include <cstdio>
#include <cstdlib>

namespace {

using namespace taut;
using namespace taut::chart;

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
    const double phi = 6.283185307179586 * next();
    return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Brushed torus on grey ground.
Scene ground(int size) {
    Scene scene;
    scene.render.width = scene.render.height = size;
    scene.render.boxFilter = true;
    scene.render.maxEvents = 3;
    scene.materials = {brushedMetal(0.08F, 0.4F), Material{}};
    scene.materials[1].color.value = Vec3(0.5F);
    scene.objects = {objectOf(makeTorus(200, 50, 0.7F, 0.3F)), objectOf(makeGrid(1, 1, 20))};
    scene.objects[1].materials = {1};
    scene.objects[1].placement.translation = DVec3(0, 0, -0.3);
    scene.camera.position = DVec3(0, -1, 5.5);
    scene.camera.lookAt = DVec3(0);
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
        const DVec3 s = glm::normalize(glm::cross(n, std::fabs(n.x) < 0.6 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
        const DVec3 t = glm::cross(n, s);
        for (int k = 0; k < 3; ++k) {
            const double phi = 6.283185307179586 * k / 3;
            mesh.cornerPositions.push_back(static_cast<Index>(mesh.positions.size()));
            mesh.positions.emplace_back(centre + (s * std::cos(phi) + t * std::sin(phi)) * (edge / std::sqrt(3.0)));
        }
        mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
    }
    scene.objects.push_back(objectOf(std::move(mesh)));
    scene.objects.back().materials = {1};
    scene.objects.back().smooth = false;
    scene.objects.back().emission.value = Vec3(kRadiance);
}

void addLights(Scene &scene, bool quads, int count) {
    Numbers next;
    for (int i = 0; i < count; ++i) {
        const DVec3 at = placeOf(next);
        const DVec3 n = direction(next);
        const double edge = std::sqrt(kTotalArea / count);
        const DVec3 u = edge * glm::normalize(glm::cross(n, std::fabs(n.x) < 0.6 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
        if (quads)
            scene.lights.push_back({Vec3(kRadiance), QuadLight{at, u, glm::cross(n, u)}});
        else
            scene.lights.push_back({Vec3(static_cast<float>(kRadiance * kTotalArea / 2 / count)), PointLight{at}});
    }
}

/// A flat glowing torus that nearly lies on the ground around the other.
void addGlowingTorus(Scene &scene, int triangles) {
    const int across = std::max(4, static_cast<int>(std::sqrt(triangles / 16.0)));
    scene.objects.push_back(objectOf(makeTorus(triangles / 2 / across, across, 1.4F, 0.1F)));
    scene.objects.back().placement.translation = DVec3(0, 0, -0.18);
    scene.objects.back().materials = {1};
    scene.objects.back().emission.value = Vec3(4);
}

void measure(const char *name, int count, const Scene &scene, int spp) {
    RenderScene ready(scene, false);
    StageTimes times;
    ready.setFrame(1, times);
    const RenderedImage a = renderReady(ready, spp, 1);
    const RenderedImage b = renderReady(ready, spp, 2);
    double mean = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) mean += 0.5 * static_cast<double>(a.values[i] + b.values[i]);
    mean /= static_cast<double>(a.values.size());
    const double error = errorOfTwo(a.values, b.values) / (mean * mean);
    const double seconds = 0.5 * (a.render + b.render);
    std::printf("%-14s %8d %10.4f %11.3e %10.3f %10.3f %14.3e\n", name, count, mean, error, seconds, 1e3 * times.bvh, error * seconds);
    std::fflush(stdout);
}

} // namespace

int main(int argc, char **argv) {
    const auto argument = [&](int i, int otherwise) { return argc > i ? std::max(1, std::atoi(argv[i])) : otherwise; };
    const int spp = argument(1, 16);
    const int size = argument(2, 128);
    const int most = argument(3, 100000);
    std::printf("%-14s %8s %10s %11s %10s %10s %14s\n", "emitters", "", "mean", "rel. MSE", "render s", "build ms", "MSE x seconds");
    for (const int count : {1, 10, 1000, 100000}) {
        if (count > most) break;
        Scene scene = ground(size);
        addTriangles(scene, count);
        measure("triangles", count, scene, spp);
        for (const bool quads : {true, false}) {
            scene = ground(size);
            addLights(scene, quads, count);
            measure(quads ? "quads" : "points", count, scene, spp);
        }
    }
    for (const int count : {1000, 100000}) {
        if (count > most) break;
        Scene scene = ground(size);
        addGlowingTorus(scene, count);
        measure("glowing torus", count, scene, spp);
    }
    return 0;
}
