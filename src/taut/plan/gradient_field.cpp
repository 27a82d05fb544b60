#include "taut/plan/gradient_field.h"

#include "taut/deform/stretch.h"
#include "taut/microsurface/transform.h"

#include <algorithm>

namespace taut {

namespace {

/// A stretch below this share of the greater one is a collapse.
constexpr float kCollapsed = 1e-3F;

float distance(const SymmetricTensor &a, const SymmetricTensor &b) {
    const Vec3 d = a.diagonal - b.diagonal;
    const Vec3 o = a.offDiagonal - b.offDiagonal;
    return std::sqrt(glm::dot(d, d) + 2 * glm::dot(o, o));
}

} // namespace

void GradientField::add(const ObjectSurface &object) {
    const std::size_t count = object.surface.vertexCount();
    std::vector<SymmetricTensor> tensors(count);
    std::vector<float> least(count);
    DVec3 diagonal(0);
    DVec3 offDiagonal(0);
    std::size_t collapsedNow = 0;
    for (std::size_t v = 0; v < count; ++v) {
        const auto [ds, dt, n] = gradientAt(object.surface, object.gradient, v);
        const float a = glm::length(ds);
        const float b = a > 0 ? glm::dot(ds, dt) / a : 0;
        const float d = a > 0 ? glm::length(glm::cross(ds, dt)) / a : glm::length(dt);
        const Vec2 sigma = singularValues(a, b, 0, d);
        greatestStretch = std::fmax(greatestStretch, sigma.x);
        leastStretch = std::fmin(leastStretch, std::fmax(sigma.y, kLeastSingularValue));
        if (d > 0) greatestShear = std::fmax(greatestShear, std::fabs(b) / d);
        if (sigma.y < kCollapsed * sigma.x) ++collapsedNow;
        logStretch = std::fmax(logStretch, std::fabs(std::log(std::fmax(sigma.x, kLeastSingularValue))));
        logStretch = std::fmax(logStretch, std::fabs(std::log(std::fmax(sigma.y, kLeastSingularValue))));
        tensors[v] = polarAt(object.surface, object.gradient, v).stretch;
        least[v] = std::fmax(sigma.y, kLeastSingularValue);
        diagonal += DVec3(tensors[v].diagonal);
        offDiagonal += DVec3(tensors[v].offDiagonal);
        if (object.gradient.normalImage.empty()) continue;
        const Vec3 &image = object.gradient.normalImage[object.surface.vertexSurface[v]];
        const float along = std::fabs(glm::dot(image, n));
        if (!(along > 1e-6F * glm::length(image))) continue;
        lean = std::fmax(lean, glm::length(image - n * glm::dot(image, n)) / along);
        logNormalStretch = std::fmax(logNormalStretch, std::fabs(std::log(along)));
    }
    collapsed = std::max(collapsed, collapsedNow);
    const double n = std::max<double>(1, static_cast<double>(count));
    const SymmetricTensor mean{Vec3(diagonal / n), Vec3(offDiagonal / n)};
    for (std::size_t v = 0; v < count; ++v) fromMean = std::fmax(fromMean, distance(tensors[v], mean) / least[v]);

    std::size_t foldedNow = 0;
    for (Index i = 0; i < object.surface.triangles.size(); ++i) {
        const Index3 &t = object.surface.triangles[i];
        SymmetricTensor middle{Vec3(0), Vec3(0)};
        for (int k = 0; k < 3; ++k) {
            middle.diagonal += tensors[t[k]].diagonal / 3.0F;
            middle.offDiagonal += tensors[t[k]].offDiagonal / 3.0F;
        }
        for (int k = 0; k < 3; ++k) withinFace = std::fmax(withinFace, distance(tensors[t[k]], middle) / least[t[k]]);
        const auto position = [&](int k) { return object.gradient.position[object.surface.vertexSurface[t[k]]]; };
        const auto normal = [&](int k) { return object.gradient.normal[object.surface.vertexSurface[t[k]]]; };
        const Vec3 up = glm::cross(position(1) - position(0), position(2) - position(0)) * (object.isMirrored(i) ? -1.0F : 1.0F);
        if (glm::dot(up, normal(0)) < 0 && glm::dot(up, normal(1)) < 0 && glm::dot(up, normal(2)) < 0) ++foldedNow;
    }
    folded = std::max(folded, foldedNow);
}

void GradientField::add(const GradientField &other) {
    for (float GradientField::*most :
         {&GradientField::greatestStretch, &GradientField::greatestShear, &GradientField::logStretch, &GradientField::fromMean,
          &GradientField::withinFace, &GradientField::lean, &GradientField::logNormalStretch})
        this->*most = std::fmax(this->*most, other.*most);
    leastStretch = std::fmin(leastStretch, other.leastStretch);
    collapsed = std::max(collapsed, other.collapsed);
    folded = std::max(folded, other.folded);
}

} // namespace taut
