#include "taut/scene/ground.h"

#include "taut/mesh/topology.h"
#include "taut/scene/object_surface.h"
#include "taut/scene/upright.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

constexpr const char *kName = "ground";
constexpr float kAlbedo = 0.4F;
constexpr double kRoom = 0.74;         ///< share of the picture's height or width that is filled
constexpr double kSolidRadii = 3;      ///< the ground is all there up to so many radii of what stands on it
constexpr double kWholeRadii = 16;     ///< and has faded away at so many,
constexpr double kCameraDistances = 2; ///< or, where the camera is far off, so many times its distance
constexpr double kGap = 2e-4;          ///< radii between the lowest point and the ground: what is flat does not lie in it
constexpr int kSectors = 96, kRings = 24;
const DVec3 kTowardsCamera = glm::normalize(DVec3(0.5, -1.0, 0.36)); ///< a three-quarter view from the front

/// What a camera that looks along one direction must see: for each edge of the picture the greatest of a sum over points, from which
/// where it has to stand follows without a search.
class Framing {
  public:
    Framing(double tanHorizontal, double tanVertical) : kx_(kRoom * tanHorizontal), ky_(kRoom * tanVertical) {}

    void add(const DVec3 &p) {
        const double x = glm::dot(p, right_), y = glm::dot(p, up_), z = glm::dot(p, kTowardsCamera);
        right = std::max(right, x + kx_ * z);
        left = std::max(left, kx_ * z - x);
        above = std::max(above, y + ky_ * z);
        below = std::max(below, ky_ * z - y);
        nearest = std::max(nearest, z);
        bounds.lower = glm::min(bounds.lower, p);
        bounds.upper = glm::max(bounds.upper, p);
    }
    struct Box {
        DVec3 lower{std::numeric_limits<double>::infinity()}, upper{-std::numeric_limits<double>::infinity()};
        [[nodiscard]] bool empty() const { return !(lower.x <= upper.x); }
        [[nodiscard]] DVec3 centre() const { return 0.5 * (lower + upper); }
        /// Of the sphere about it; 1 where all is one point.
        [[nodiscard]] double radius() const {
            const double r = 0.5 * glm::length(upper - lower);
            return r > 0 ? r : 1;
        }
    };

    /// The nearest place from which all points lie within that share of the picture, in its middle.
    [[nodiscard]] DVec3 position() const {
        const double enough = std::max((right + left) / (2 * kx_), (above + below) / (2 * ky_));
        const double depth = std::max(enough, nearest + 0.2 * bounds.radius());
        return 0.5 * (right - left) * right_ + 0.5 * (above - below) * up_ + depth * kTowardsCamera;
    }

    Box bounds;

  private:
    double kx_, ky_;
    DVec3 right_ = glm::normalize(glm::cross(DVec3(0, 0, 1), kTowardsCamera));
    DVec3 up_ = glm::cross(kTowardsCamera, right_);
    double right = -std::numeric_limits<double>::infinity(), left = right, above = right, below = right, nearest = right;
};

std::vector<int> framesToLookAt(const std::vector<int> &frames) {
    if (frames.size() <= kMostFramesLookedAt) return frames;
    std::vector<int> some;
    for (std::size_t i = 0; i < kMostFramesLookedAt; ++i) some.push_back(frames[i * (frames.size() - 1) / (kMostFramesLookedAt - 1)]);
    return some;
}

/// Calls add(point) for the points of faces at a frame, world space; under subdivision for those of the limit surface.
template <class Add>
void forEachPoint(const Object &object, ObjectMotion &motion, ObjectSurface *refined, double frame, double fps, const Add &add) {
    std::vector<Vec3> seen;
    if (refined != nullptr) {
        double ignored = 0;
        surfaceAtFrame(*refined, frame, fps, DMat4(1), ignored, ignored);
        seen.assign(refined->vertices.positions.begin(), refined->vertices.positions.end() - 1); // the last is Embree's
    } else {
        motionAtFrame(object, frame, fps, DMat4(1), motion);
        std::vector<Vec3> positions;
        evaluatePositions(motion.state, object.mesh->skin, positions);
        seen = pointsOfFaces(*object.mesh, positions);
    }
    for (const Vec3 &p : seen)
        if (isFinite(p)) add(DVec3(p));
}

void lookAt(const Scene &scene, const std::vector<Object> &objects, Framing &framing) {
    for (const Object &object : objects) {
        ObjectMotion motion;
        std::optional<ObjectSurface> refined;
        if (object.subdivision.level > 0) prepareObjectSurface(object, scene.render.fps, refined.emplace());
        for (const int frame : framesToLookAt(scene.render.frames)) {
            forEachPoint(object, motion, refined ? &*refined : nullptr, frame, scene.render.fps, [&](const DVec3 &p) { framing.add(p); });
            if (!moves(object) && !deforms(object)) break;
        }
    }
}

/// A disc of radius 1 about the origin that faces +z. Rings from kSolidRadii / kWholeRadii outwards fade; they are slot 1.
std::shared_ptr<const Mesh> makeDisc(double solid) {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = kName;
    mesh->materialNames = {"solid", "fading"};
    mesh->positions.push_back(Vec3(0));
    mesh->colors.push_back(Vec4(1));
    for (int ring = 0; ring <= kRings; ++ring) {
        const double share = static_cast<double>(ring) / kRings;
        const double radius = std::pow(solid, 1 - share);
        const auto left = static_cast<float>(1 - share * share * (3 - 2 * share));
        for (int sector = 0; sector < kSectors; ++sector) {
            const double angle = kTwoPi * sector / kSectors;
            mesh->positions.push_back(Vec3(DVec3(radius * std::cos(angle), radius * std::sin(angle), 0)));
            mesh->colors.push_back(Vec4(1, 1, 1, left));
        }
    }
    const auto at = [](int ring, int sector) { return static_cast<Index>(1 + ring * kSectors + sector % kSectors); };
    const auto addFace = [&](std::initializer_list<Index> corners, Index slot) {
        mesh->cornerPositions.insert(mesh->cornerPositions.end(), corners);
        mesh->faceOffsets.push_back(static_cast<Index>(mesh->cornerPositions.size()));
        mesh->faceMaterials.push_back(slot);
    };
    for (int sector = 0; sector < kSectors; ++sector) {
        addFace({0, at(0, sector), at(0, sector + 1)}, 0);
        for (int ring = 0; ring < kRings; ++ring)
            addFace({at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1), at(ring, sector + 1)}, 1);
    }
    mesh->cornerColors = mesh->cornerPositions;
    return mesh;
}

/// Scenes of one file share the mesh.
const std::shared_ptr<const Mesh> &discMesh() {
    static const std::shared_ptr<const Mesh> disc = makeDisc(kSolidRadii / kWholeRadii);
    return disc;
}

Index addMaterial(Scene &scene, bool fading) {
    Material material;
    material.name = fading ? "ground, fading" : kName;
    material.color.value = Vec3(kAlbedo);
    material.doubleSided = false;
    material.vertexColors = fading;
    material.alphaMode = fading ? AlphaMode::Blend : AlphaMode::Opaque;
    scene.materials.push_back(std::move(material));
    return static_cast<Index>(scene.materials.size() - 1);
}

std::string freeName(const Scene &scene) {
    std::string name = kName;
    const auto taken = [&] {
        return std::any_of(scene.objects.begin(), scene.objects.end(), [&](const Object &o) { return o.name == name; });
    };
    for (int number = 2; taken(); ++number) name = std::string(kName) + "_" + std::to_string(number);
    return name;
}

} // namespace

std::optional<Ground> groundOf(const Scene &scene) {
    if (!scene.render.ground) return std::nullopt;
    const double first = scene.render.frames.front();
    const double tanVertical = std::tan(0.5 * scene.camera.fovY.at(first));
    Framing framing(tanVertical * scene.render.width / scene.render.height, tanVertical);
    Ground ground;
    std::vector<Object> objects = scene.objects;
    ground.yUp = scene.unsaid.up && scene.unsaid.camera && objects.size() == 1 && standsWithYUp(objects.front(), first, scene.render.fps);
    if (ground.yUp) objects.front().placement.worldFromUp = kWorldFromYUp;
    lookAt(scene, objects, framing);
    if (framing.bounds.empty()) return std::nullopt;
    const DVec3 centre = framing.bounds.centre();
    const double radius = framing.bounds.radius();
    ground.position = framing.position();
    ground.lookAt = ground.position - glm::dot(ground.position - centre, kTowardsCamera) * kTowardsCamera;
    ground.centre = DVec2(centre);
    ground.seenRadius = radius;
    widen(scene, ground);
    // Far from the origin the gap is no less than what floats tell apart there.
    const double coarse = 4 * static_cast<double>(std::numeric_limits<float>::epsilon()) *
                          glm::length(glm::max(glm::abs(framing.bounds.lower), glm::abs(framing.bounds.upper)));
    ground.height = framing.bounds.lower.z - std::max(kGap * radius, coarse);
    return ground;
}

void widen(const Scene &scene, Ground &ground) {
    const double first = scene.render.frames.front();
    const DVec3 eye =
        scene.unsaid.camera ? ground.position : DVec3(cameraAtFrame(scene.camera, first, scene.render.fps).worldFromCamera[3]);
    ground.radius = std::max(kWholeRadii * ground.seenRadius, kCameraDistances * glm::length(DVec2(eye) - ground.centre));
}

std::optional<Ground> standOnGround(Scene &scene, Warnings &warnings) {
    const std::optional<Ground> ground = groundOf(scene);
    if (!ground) return ground;
    standOn(*ground, scene);
    if (ground->yUp) warnings.add(scene.path + ": y is taken for up, so that it stands (-D mesh.0.up=z: as it lies)");
    return ground;
}

void standOn(const Ground &ground, Scene &scene) {
    if (ground.yUp) scene.objects.front().placement.worldFromUp = kWorldFromYUp;
    Object object;
    object.name = freeName(scene);
    object.mesh = discMesh();
    object.materials = {addMaterial(scene, false), addMaterial(scene, true)};
    object.placement.translation = Keyed<DVec3>(DVec3(ground.centre, ground.height));
    object.placement.scale = Keyed<DVec3>(DVec3(ground.radius));
    scene.objects.push_back(std::move(object));
    if (scene.unsaid.light) scene.environment = neutralStudioEnvironment();
    if (!scene.unsaid.camera) return;
    scene.camera.position = Keyed<DVec3>(ground.position);
    scene.camera.lookAt = Keyed<DVec3>(ground.lookAt);
}

} // namespace taut
