#include "study/render_image.h"

#include "taut/base/stopwatch.h"

#include <memory>

namespace taut::chart {

RenderedImage renderReady(const RenderScene &ready, int spp, std::uint32_t seed) {
    FrameOptions options;
    options.spp = spp;
    options.seed = seed;
    Stopwatch watch;
    const FrameResult result = renderFrame(ready, options);
    RenderedImage image;
    image.seconds = image.render = watch.lap();
    const std::vector<float> values = result.film.resolve(); // R G B A
    for (std::size_t i = 0; i < values.size(); i += 4)
        image.values.insert(image.values.end(), values.begin() + static_cast<std::ptrdiff_t>(i),
                            values.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    return image;
}

RenderedImage renderImage(const Scene &scene, ScenePlan plan, double frame, int spp, std::uint32_t seed) {
    Stopwatch watch;
    RenderScene ready(scene, std::move(plan), true);
    StageTimes times;
    ready.setFrame(frame, times);
    const double before = watch.lap();
    RenderedImage image = renderReady(ready, spp, seed);
    image.seconds += before;
    return image;
}

bool sameModels(const ScenePlan &a, const ScenePlan &b) {
    if (a.bearableWaste != b.bearableWaste) return false;
    for (std::size_t i = 0; i < a.meshes.size(); ++i) {
        const MeshPlan &x = a.meshes[i];
        const MeshPlan &y = b.meshes[i];
        if (x.stretch != y.stretch || x.estimator != y.estimator || x.interpolation != y.interpolation ||
            x.subdivisionLevel != y.subdivisionLevel)
            return false;
    }
    for (std::size_t i = 0; i < a.materials.size(); ++i) {
        const MultiscatterPlan &x = a.materials[i];
        const MultiscatterPlan &y = b.materials[i];
        if (x.model != y.model || (x.model == Multiscatter::Auto && x.negligibleLoss != y.negligibleLoss)) return false;
    }
    return true;
}

double relativeRms(std::span<const float> image, std::span<const float> reference) {
    double difference = 0;
    double size = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        difference += sqr(static_cast<double>(image[i] - reference[i]));
        size += sqr(static_cast<double>(reference[i]));
    }
    return std::sqrt(difference / size);
}

double relativeMse(std::span<const float> image, std::span<const float> reference) {
    const auto lit = [&](std::size_t pixel) {
        float sum = 0;
        for (std::size_t c = 0; c < 3; ++c) sum += reference[3 * pixel + c] + image[3 * pixel + c];
        return sum > 0;
    };
    double mean = 0;
    std::size_t count = 0;
    for (std::size_t pixel = 0; pixel < image.size() / 3; ++pixel) {
        if (!lit(pixel)) continue;
        for (std::size_t c = 0; c < 3; ++c) mean += static_cast<double>(reference[3 * pixel + c]);
        count += 3;
    }
    mean /= static_cast<double>(count);
    double sum = 0;
    for (std::size_t pixel = 0; pixel < image.size() / 3; ++pixel) {
        if (!lit(pixel)) continue;
        for (std::size_t c = 3 * pixel; c < 3 * pixel + 3; ++c)
            sum += sqr(static_cast<double>(image[c] - reference[c])) / (sqr(static_cast<double>(reference[c])) + 0.01 * mean * mean);
    }
    return sum / static_cast<double>(count);
}

Object objectOf(Mesh mesh) {
    Object object;
    object.name = "object";
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {0};
    return object;
}

Material brushedMetal(float alphaX, float alphaY) {
    Material material;
    material.name = "metal";
    material.type = BsdfType::Conductor;
    material.alphaX.value = alphaX;
    material.alphaY.value = alphaY;
    return material;
}

DeformerKeys constantDeformer(DeformerType type, double amount, int axis, int axis2) {
    DeformerKeys keys;
    keys.type = type;
    keys.axis = axis;
    keys.axis2 = axis2;
    keys.lower = -2;
    keys.upper = 2;
    if (type == DeformerType::Wave) {
        keys.amplitude = amount;
        keys.wavelength = 0.65;
    } else {
        keys.amount = amount;
    }
    return keys;
}

Scene studyScene(Object object, const Material &material, int size) {
    Scene scene;
    scene.render.width = scene.render.height = size;
    scene.render.maxEvents = 4;
    scene.render.boxFilter = true;
    scene.materials = {material};
    scene.objects.push_back(std::move(object));
    scene.camera.position = Keyed<DVec3>(DVec3(0.3, -2.4, 2.1));
    scene.environment = constantEnvironment(Vec3(0.2F, 0.25F, 0.3F));
    scene.lights.push_back({Vec3(6, 5, 4), QuadLight{DVec3(-0.8, 1, 1.2), DVec3(0, 0, 0.8), DVec3(1.6, 0, 0), true}});
    return scene;
}

} // namespace taut::chart
