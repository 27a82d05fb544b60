#pragma once
/// A scene as plain data: what a scene file, a .glb or a bare mesh says, checked, with every default filled in.
///
/// World space: right-handed, z up, metres. Time: frame f is at (f - 1) / fps seconds; frame numbers may be fractional.

#include "taut/deform/deformer.h"
#include "taut/deform/gradient_interpolation.h"
#include "taut/deform/keyed.h"
#include "taut/deform/point_source.h"
#include "taut/deform/rig_poses.h"
#include "taut/deform/surface_motion.h"
#include "taut/images/image_settings.h"
#include "taut/mesh/mesh.h"
#include "taut/mesh/subdivide.h"
#include "taut/scene/environment.h"
#include "taut/scene/lights/light_shapes.h"
#include "taut/scene/material.h"
#include "taut/scene/texture.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace taut {

/// Placement of an object: world = T * R * S applied to the object's space. Keyed over frames. `R` is XYZ Euler angles
/// (x first), radians. A constant placement changes no alpha; a keyed scale counts relative to its first key.
struct Placement {
    Keyed<DVec3> translation{DVec3(0)};
    Keyed<DVec3> rotation{DVec3(0)};
    Keyed<DVec3> scale{DVec3(1)};
    DMat4 worldFromUp{1}; ///< constant: turns a y-up file to z up
};

DMat4 placementAt(const Placement &placement, double frame);
/// Linear part of the placement with its keyed scale at the first key: what carries the rest state.
DMat3 placementRest(const Placement &placement);

/// What moves an object's points before its deformers: a node of a rig, and the skin that it names.
struct RigMotion {
    std::shared_ptr<const Rig> rig;
    Index node = kNone;                                             ///< the node that holds the mesh
    Index clip = kNone;                                             ///< into rig->clips; kNone: nodes as stored
    bool loop = false;                                              ///< repeat the clip; false: hold its ends
    std::shared_ptr<const Clip> together{};                         ///< takes the place of `clip`: several of the rig's, as one
    std::shared_ptr<RigPoses> poses = std::make_shared<RigPoses>(); ///< evaluated so far; shared by copies, so by a file's objects
};
/// The clip that a motion plays; null: none.
const Clip *clipOf(const RigMotion &motion);
/// Time on the motion's clip at a frame, seconds: (frame - 1) / fps, wrapped into the clip where it loops.
double clipTime(const RigMotion &motion, double frame, double fps);
/// The rig's pose at a frame, and its rest pose.
std::shared_ptr<const Pose> poseAtFrame(const RigMotion &motion, double frame, double fps);
std::shared_ptr<const Pose> restPoseOf(const RigMotion &motion);

/// Level of an object whose level a plan would choose, where there is none.
inline constexpr int kUnplannedLevel = 3;

struct RestState {
    bool bind = true; ///< undeformed mesh or bind pose; else the shape at `frame`
    double frame = 0;
};

/// What shines.
struct Emission {
    ColorParam radiance{Vec3(0)}; ///< of the outward side, W / (m^2 sr)
    bool twoSided = false;
    Index group = kNone; ///< of slots: into Scene::lightGroups; none: the object's
};

/// One mesh with its materials and motion.
struct Object {
    std::string name;
    std::shared_ptr<const Mesh> mesh;
    std::vector<Index> materials; ///< [max(1, mesh->materialNames)], into Scene::materials, by face material slot
    std::optional<RigMotion> rig;
    std::shared_ptr<const PointSource> points; ///< positions over time from arrays, a function or files; null: the mesh's own
    std::vector<DeformerKeys> deformers;       ///< in the object's space, before the placement (of a rig: in the rig's space)
    Placement placement;
    SubdivisionOptions subdivision;
    bool planLevel = false;   ///< the plan chooses subdivision.level; what that holds is for those who do not plan
    bool smooth = true;       ///< without file normals: smooth normals; false: faceted
    bool mapTangents = false; ///< a material has a map of normals: tangents are those it was baked for (policy TangentOfMaps)
    bool follow = true;       ///< false: roughness held fixed on the deformed tangent frame
    bool lean = false;        ///< deformers move the space above the surface too: M takes their shear and stretch along the normal
    std::optional<GradientEstimator> gradient;          ///< none: the plan chooses
    std::optional<GradientInterpolation> interpolation; ///< none: the plan chooses
    RestState rest;
    ColorParam emission{Vec3(0)}; ///< radiance of the outward side, W / (m^2 sr); non-zero makes the object a light
    bool emissionTwoSided = false;
    Index emissionGroup = kNone; ///< into Scene::lightGroups; none: "emission"
    std::vector<Emission>
        slotEmission; ///< [materials] where material slots shine each for itself, in the place of `emission`; may be empty
};

/// What a material slot of an object emits.
inline Emission emissionOf(const Object &object, Index slot) {
    if (object.slotEmission.empty()) return {object.emission, object.emissionTwoSided, object.emissionGroup};
    return object.slotEmission[std::min<std::size_t>(slot, object.slotEmission.size() - 1)];
}
/// Whether any part of an object shines.
inline bool emits(const Object &object) {
    const auto shines = [](const Emission &e) { return e.radiance.value != Vec3(0); };
    return object.slotEmission.empty() ? object.emission.value != Vec3(0)
                                       : std::any_of(object.slotEmission.begin(), object.slotEmission.end(), shines);
}

/// Thin lens camera; aperture radius 0 is a pinhole. Or an orthographic one, which has no lens. Looks along its local -z, y up.
struct Camera {
    Keyed<DVec3> position{DVec3(0, -3, 0)};
    Keyed<DVec3> lookAt{DVec3(0)};
    Keyed<DVec3> up{DVec3(0, 0, 1)};
    Keyed<double> fovY{0.69813};       ///< vertical, radians
    Keyed<double> orthoHeight{0.0};    ///< metres; above 0: parallel rays, which see so much from the lower edge to the upper
    Keyed<double> apertureRadius{0.0}; ///< metres
    Keyed<double> focusDistance{0.0};  ///< metres; 0: the distance to look_at
    std::optional<RigMotion> rig;      ///< a node to look along -z from, placed by `placement`; replaces position/lookAt/up
    Placement placement;
};

struct CameraState {
    DMat4 worldFromCamera{1}; ///< orthonormal columns and a translation
    double fovY = 0.7;
    double orthoHeight = 0;
    double apertureRadius = 0;
    double focusDistance = 1;
};
CameraState cameraAtFrame(const Camera &camera, double frame, double fps);

struct RenderSettings {
    int width = 960;
    int height = 540;
    int spp = 64;
    int maxEvents = 8; ///< scattering events on a path
    std::vector<int> frames{1};
    double fps = 24;
    std::uint32_t seed = 0;
    bool fixedSeed = false;
    double shutter = 0;     ///< how long it is open, in frames; it is centred on the frame. 0: no motion blur
    int motionSteps = 3;    ///< times within the shutter at which everything that moves is evaluated, 2 to 128; linear between them
    bool boxFilter = false; ///< false: Blackman-Harris of radius 1.5 pixels, importance sampled
    bool ground = false;    ///< pictures of it stand on a ground (ground.h): true of a mesh or glTF file alone, unless it says otherwise
};

/// What a glTF file of a scene holds, for those who ask.
struct SceneFile {
    std::string path;
    std::vector<std::pair<std::string, double>> clips; ///< names, seconds
    std::vector<std::string> cameras, lights;          ///< names of their nodes
    std::vector<std::string> variants;                 ///< names
    std::string leftOut;                               ///< what is used and the picture does not show, with counts
};

/// What a loader filled in because nobody said it: what a ground under a bare file may replace (ground.h).
struct Unsaid {
    bool up = false;     ///< no file says which way is up, nor anyone else
    bool camera = false; ///< it is framed
    bool light = false;  ///< it is the built-in studio's
};

struct Scene {
    std::string path;
    Unsaid unsaid;
    std::shared_ptr<Budget> budget; ///< what it may ask for; null: as much as it likes
    std::vector<SceneFile> files;   ///< in the order of their reading
    std::set<std::string> inputs;   ///< paths of all files that decide the picture: read already, or to be read at some frame
    RenderSettings render;
    ImageSettings image;
    Camera camera;
    std::optional<Environment> environment;
    std::vector<Light> lights;
    std::vector<std::string> lightGroups; ///< names that lights and emission are grouped by for their AOVs (render/light_groups.h)
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Object> objects;

    /// A plain white one where there is no such material.
    [[nodiscard]] const Material &materialAt(Index index) const { return index < materials.size() ? materials[index] : kPlainMaterial; }
    static inline const Material kPlainMaterial{};
};

/// Lets all objects that hang from one rig share its poses, wherever their motions come from.
void sharePoses(Scene &scene);

} // namespace taut
