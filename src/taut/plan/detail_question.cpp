#include "taut/plan/detail_question.h"

#include "taut/plan/light_coverage.h"
#include "taut/scene/texture_pyramid.h"

#include <algorithm>
#include <array>

namespace taut {

namespace {

/// Total variation of lobes to relative RMS of an image: reliefs of a million facets under the studio's lights came out at 1.8 and 2.0 times
/// it for sigma / alpha of 1/3 and 1/2; at 1, where the tails of lobes lit a dark part, at 4.
constexpr float kFitToImage = 2;

/// Metres of a mesh's surface at rest for a unit of u or v, by area; 0 without UVs.
double metresPerUv(const Object &object) {
    const Mesh &mesh = *object.mesh;
    if (mesh.cornerUvs.empty()) return 0;
    const DMat3 rest = placementRest(object.placement);
    double area = 0;
    double uvArea = 0;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const Index a = mesh.faceOffsets[f];
        for (Index c = a + 1; c + 1 < mesh.faceOffsets[f + 1]; ++c) {
            const auto at = [&](Index k) { return rest * DVec3(mesh.positions[mesh.cornerPositions[k]]); };
            if (mesh.cornerUvs[a] == kNone || mesh.cornerUvs[c] == kNone || mesh.cornerUvs[c + 1] == kNone) continue;
            const auto uv = [&](Index k) { return DVec2(mesh.uvs[mesh.cornerUvs[k]]); };
            area += glm::length(glm::cross(at(c) - at(a), at(c + 1) - at(a)));
            const DVec2 d1 = uv(c) - uv(a);
            const DVec2 d2 = uv(c + 1) - uv(a);
            uvArea += std::fabs(d1.x * d2.y - d1.y * d2.x);
        }
    }
    return uvArea > 0 ? std::sqrt(area / uvArea) : 0;
}

/// Width in metres of what a pixel sees of an object's middle.
double pixelWidth(const Scene &scene, const Object &object, int frame) {
    const CameraState camera = cameraAtFrame(scene.camera, frame, scene.render.fps);
    if (camera.orthoHeight > 0) return camera.orthoHeight / scene.render.height;
    const Bounds box = worldBounds(object, frame, scene.render.fps);
    const double distance = glm::length(DVec3(camera.worldFromCamera[3]) - DVec3(box.centre()));
    return 2 * std::tan(0.5 * camera.fovY) * distance / scene.render.height;
}

} // namespace

float momentsFitError(float sigmaOverAlpha) {
    constexpr std::array<Vec2, 6> kFit{Vec2(0, 0), {0.25F, 0.02F}, {0.5F, 0.06F}, {1, 0.11F}, {2, 0.15F}, {4, 0.17F}};
    for (std::size_t i = 1; i < kFit.size(); ++i)
        if (sigmaOverAlpha <= kFit[i].x)
            return glm::mix(kFit[i - 1].y, kFit[i].y, (sigmaOverAlpha - kFit[i - 1].x) / (kFit[i].x - kFit[i - 1].x));
    return kFit.back().y;
}

std::optional<Question> detailQuestion(const Scene &scene, Index index, float leastAlpha, int frame) {
    const Material &material = scene.materials[index];
    if (material.detail != TextureDetail::Auto || !material.slopes.isGiven()) return std::nullopt;
    const Texture &texture = scene.textures[material.slopes.texture];
    const auto pyramid = slopePyramid(texture, material.slopes.kind);
    float variance = 0;
    for (const Object &object : scene.objects) {
        if (std::find(object.materials.begin(), object.materials.end(), index) == object.materials.end()) continue;
        const double metres = metresPerUv(object);
        if (!(metres > 0)) continue;
        const Vec2 tiles =
            texture.sampler.moved ? Vec2(glm::length(Vec2(texture.sampler.moveU)), glm::length(Vec2(texture.sampler.moveV))) : Vec2(1);
        const double texels = pixelWidth(scene, object, frame) / metres *
                              std::sqrt(static_cast<double>(texture.width) * texture.height * static_cast<double>(tiles.x * tiles.y));
        float scale = std::fabs(material.slopes.scale);
        if (material.slopes.kind == SlopeMap::Kind::Height) scale *= std::sqrt(tiles.x * tiles.y) / static_cast<float>(metres);
        const auto level = static_cast<float>(std::log2(std::max(texels, 1e-6)));
        if (level > 0) variance = std::max(variance, scale * scale * meanVariance(*pyramid, level));
    }
    const float error = kFitToImage * momentsFitError(std::sqrt(variance) / std::fmax(leastAlpha, 1e-4F));
    // The map's variance over the lobe's own, which is that of alpha: so many more samples average it as far.
    const float samples = 1 + variance / sqr(std::fmax(leastAlpha, 1e-4F));
    return Question{{{TextureDetail::Moments, error, 1, 0, {}}, {TextureDetail::Map, 0, samples, 0, {}}}, 0};
}

DetailPlan planDetail(const Material &material, std::optional<Question> question, float budget) {
    DetailPlan plan;
    if (!question) {
        if (material.detail != TextureDetail::Auto) plan.detail = material.detail;
        return plan;
    }
    float left = budget;
    take(*question, left);
    if (!(question->choices.back().cost > 1)) question->taken = 1; // no pixel sees more than a texel
    plan.detail = question->answer<TextureDetail>();
    plan.error = question->choices[question->taken].error;
    plan.question = std::move(question);
    return plan;
}

} // namespace taut
