#include "inspect.h"

#include "../info_report.h"
#include "../lobe_picture.h"
#include "../probe_arguments.h"

#include "taut/render/aov.h"
#include "taut/render/shading.h"

#include <fmt/format.h>

namespace taut::app {

namespace {

using Json = nlohmann::json;

constexpr int kLobeWidth = 96;
constexpr DVec2 kBeside(0.011, 0.017); // pixels

/// The double of the fewest digits that name this float.
double digits(float x) {
    return std::isfinite(x) ? std::stod(fmt::format("{}", x + 0.0F)) : static_cast<double>(x);
}

/// The pinhole or parallel rays of a picture: render space to pixels and back.
struct Eye {
    double pixel; ///< height of a pixel on the plane at distance one, or of parallel rays
    DVec2 centre;
    bool parallel;

    explicit Eye(const RenderScene &scene) {
        const RenderSettings &render = scene.scene().render;
        const CameraState &camera = scene.camera();
        parallel = camera.orthoHeight > 0;
        pixel = (parallel ? camera.orthoHeight : 2 * std::tan(0.5 * camera.fovY)) / render.height;
        centre = 0.5 * DVec2(render.width, render.height);
    }
    [[nodiscard]] Ray ray(double x, double y) const {
        const DVec2 at((x - centre.x) * pixel, (centre.y - y) * pixel);
        Ray ray{};
        ray.origin = parallel ? Vec3(DVec3(at.x, at.y, 0)) : Vec3(0);
        ray.direction = parallel ? Vec3(0, 0, -1) : glm::normalize(Vec3(DVec3(at.x, at.y, -1)));
        return ray;
    }
    /// How a small step on the surface is seen: pixels, y down, a length of one at that distance being one.
    [[nodiscard]] DVec2 seen(const Vec3 &position, const Vec3 &step) const {
        const DVec3 p(position);
        const DVec3 d(step);
        if (parallel) return {d.x, -d.y};
        return {d.x - p.x * d.z / p.z, -(d.y - p.y * d.z / p.z)};
    }
};

Json pair(const DVec2 &v) {
    return {v.x, v.y};
}

/// Values of an output variable at a hit.
std::vector<float> valuesOf(const RenderScene &scene, const SurfacePoint &point, std::string_view name) {
    const AovInfo &info = infoOf(*findAov(name));
    std::vector<float> values(info.channels.size());
    info.write(scene, point, values.data());
    return values;
}

Json triple(const std::vector<float> &v) {
    return {digits(v[0]), digits(v[1]), digits(v[2])};
}

/// The greater singular value's direction of V, [ss st; st tt].
Vec2 directionOfStretch(const Vec3 &v) {
    const float angle = 0.5F * std::atan2(2 * v.y, v.x - v.z);
    return {std::cos(angle), std::sin(angle)};
}

Json gloss(const RenderScene &scene, const SurfacePoint &point, const Eye &eye, const Vec3 &wo) {
    const std::vector<float> m = valuesOf(scene, point, "m");
    const std::vector<float> lean = valuesOf(scene, point, "lean");
    const std::vector<float> alpha = valuesOf(scene, point, "alpha");
    const Frame &facet = point.facet;
    // The rotated tangent in the facet's plane, as the output variables have it.
    Vec2 t = point.tangent;
    if (point.tilted) {
        const Vec2 seen(facet.toLocal(point.frame.fromLocal(Vec3(t, 0))));
        if (glm::length(seen) > 0) t = seen / glm::length(seen);
    }
    const Vec3 x = facet.s * t.x + facet.t * t.y;
    const Vec3 y = glm::cross(facet.n, x);
    const double theta = glm::degrees(std::acos(std::clamp(static_cast<double>(glm::dot(wo, facet.n)), -1.0, 1.0)));
    const double phi = glm::degrees(std::atan2(static_cast<double>(glm::dot(wo, y)), static_cast<double>(glm::dot(wo, x))));
    const Vec3 major = x * std::cos(alpha[2]) + y * std::sin(alpha[2]);
    const Vec3 minor = glm::cross(facet.n, major);
    Json out{{"m", {digits(m[0]), digits(m[1]), 0.0, digits(m[2]), digits(lean[0]), digits(lean[1])}},
             {"alpha_max", digits(alpha[0])},
             {"alpha_min", digits(alpha[1])},
             {"alpha_rotation", glm::degrees(static_cast<double>(alpha[2]))},
             {"theta", theta},
             {"phi", phi}};
    out["ellipse"] = {{"major", pair(eye.seen(point.position, major))},
                      {"minor", pair(eye.seen(point.position, minor) * static_cast<double>(alpha[1] / alpha[0]))}};
    ProbeArguments arguments;
    for (const Json &number : out["m"]) arguments.m.push_back(number.get<double>());
    arguments.theta = theta;
    arguments.phi = phi;
    const GeneralTransform surface = surfaceOf(arguments);
    const LobePicture lobe =
        lobePicture(bsdfOf(arguments, surface.micro), surface.frame, {directionOf(theta, phi, "--theta"), kLobeWidth, 4});
    out["lobe"] = {{"width", lobe.width}, {"height", lobe.height}, {"values", lobe.values}, {"max", digits(lobe.values[lobe.peak])}};
    out["probe"] = fmt::format("taut probe lobe --m {} --theta {} --phi {} --width {} --samples 4", fmt::join(arguments.m, ","), theta, phi,
                               kLobeWidth);
    return out;
}

Json planOf(const RenderScene &scene, const RenderObject &object, Index material) {
    Json out = toJson(object.plan);
    out["subdivision"] = object.plan.subdivisionLevel;
    if (material >= scene.plan().materials.size()) return out;
    const MultiscatterPlan &planned = scene.plan().materials[material];
    out["multiscatter"] = nameOf(multiscatterOf(scene.scene().materialAt(material), planned.model));
    if (planned.question) out["questions"].push_back(toJson(*planned.question));
    const DetailPlan &detail = scene.plan().details[material];
    if (detail.question) out["questions"].push_back(toJson(*detail.question));
    return out;
}

} // namespace

nlohmann::json inspectPixel(const RenderScene &scene, double x, double y) {
    const Eye eye(scene);
    Ray ray = eye.ray(x, y);
    Hit hit;
    scene.embree().intersect({&ray, 1}, false, {&hit, 1});
    if (hit.geometry == kNone) { // a ray along an edge may pass between two triangles
        ray = eye.ray(x + kBeside.x, y + kBeside.y);
        scene.embree().intersect({&ray, 1}, false, {&hit, 1});
    }
    if (hit.geometry == kNone) return nullptr;
    const Index index = scene.objectOfGeometry(hit.geometry);
    const RenderObject &object = scene.objects()[index];
    const Vec3 wo = -ray.direction;
    const SurfacePoint point = surfacePointAt(scene, prepareMaterials(scene.scene(), scene.plan()), hit, wo);
    const Index material = materialOfTriangle(object, hit.primitive);
    const double distance = eye.parallel ? -static_cast<double>(point.position.z) : static_cast<double>(glm::length(point.position));
    Json out{{"object", object.object->name},
             {"material", scene.scene().materialAt(material).name},
             {"type", bsdfInfo(scene.scene().materialAt(material).type).name},
             {"follow", object.object->follow},
             {"triangle", hit.primitive},
             {"depth", -static_cast<double>(point.position.z)},
             {"distance", distance},
             {"position", triple(valuesOf(scene, point, "position"))},
             {"normal", triple(valuesOf(scene, point, "shading_normal"))},
             {"base_color", triple(valuesOf(scene, point, "albedo"))},
             {"plan", planOf(scene, object, material)}};
    const std::vector<float> stretch = valuesOf(scene, point, "stretch");
    const Vec2 along = directionOfStretch(point.stretch);
    out["stretch"] = {{"max", digits(stretch[0])},
                      {"min", digits(stretch[1])},
                      {"direction", pair(eye.seen(point.position, point.frame.s * along.x + point.frame.t * along.y))}};
    if (bsdfInfo(scene.scene().materialAt(material).type).microsurface) out["gloss"] = gloss(scene, point, eye, wo);
    return out;
}

} // namespace taut::app
