#include "taut/mesh/topology.h"
#include "taut/scene/load_context.h"
#include "taut/scene/object_motion.h"

namespace taut {

namespace {

struct Sphere {
    DVec3 centre{0};
    double radius = 1;
};

/// A sphere around everything that is seen at one frame, world space; the unit sphere where there is nothing.
Sphere boundingSphere(const Scene &scene, double frame) {
    std::vector<Vec3> all;
    for (const Object &object : scene.objects) {
        ObjectMotion motion;
        motionAtFrame(object, frame, scene.render.fps, DMat4(1), motion);
        std::vector<Vec3> positions;
        evaluatePositions(motion.state, object.mesh->skin, positions);
        const std::vector<Vec3> seen = pointsOfFaces(*object.mesh, positions);
        all.insert(all.end(), seen.begin(), seen.end());
    }
    const Bounds bounds = boundsOf(all);
    if (bounds.empty()) return {};
    Sphere sphere{DVec3(bounds.centre()), 0};
    for (const Vec3 &p : all)
        if (isFinite(p)) sphere.radius = std::max(sphere.radius, glm::distance(DVec3(p), sphere.centre));
    if (!(sphere.radius > 0)) sphere.radius = 1;
    return sphere;
}

} // namespace

void frameCamera(const Scene &scene, Camera &camera) {
    constexpr double kMargin = 1.05;
    const DVec3 towardsCamera = glm::normalize(DVec3(0.5, -1.0, 0.42)); // three-quarter view from the front
    const double frame = firstFrame(scene);
    const Sphere sphere = boundingSphere(scene, frame);
    const double halfVertical = 0.5 * camera.fovY.at(frame);
    const double halfHorizontal = std::atan(std::tan(halfVertical) * scene.render.width / scene.render.height);
    const double distance = kMargin * sphere.radius / std::sin(std::min(halfVertical, halfHorizontal));
    camera.lookAt = Keyed<DVec3>(sphere.centre);
    camera.position = Keyed<DVec3>(sphere.centre + distance * towardsCamera);
}

} // namespace taut
