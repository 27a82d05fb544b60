#pragma once
/// A scene made ready to be traced: surfaces, Embree geometry and lights, built once and brought to each frame in place.
///
/// Render space is camera space (origin at the lens, looking along -z, y up), reached from world space in double precision
/// before anything is rounded to float. So a motion that objects and camera share leaves the same bits behind.

#include "taut/render/embree_scene.h"
#include "taut/render/lights.h"
#include "taut/render/surface_step.h"

#include <array>
#include <compare>
#include <map>

namespace taut {

/// Seconds spent, by stage; shading stages are summed over threads.
struct StageTimes {
    double deformation = 0; ///< positions: poses, skins, deformers, subdivision
    double gradient = 0;    ///< ds, dt, normals, V
    double bvh = 0;
    double cameraRays = 0, scatteredRays = 0, shadowRays = 0; ///< traversal
    double shading = 0;
    double film = 0;
    StageTimes &operator+=(const StageTimes &other);
};

/// What the BVH of an object that only moves as a whole is made of: objects that agree share one.
struct InstanceShape {
    const Mesh *mesh;
    std::array<float, 9> restFromObject;
    int subdivisionLevel;
    SubdivisionScheme scheme;
    SubdivisionBoundary boundary;
    float creaseAngle;
    auto operator<=>(const InstanceShape &) const = default;
};

class RenderScene {
  public:
    /// Takes over the scene (move it in, or it is copied, with its textures and environment) and builds topology. `animated`: more than
    /// one frame will be asked for. Throws InputError where the scene is no scene (check_scene.h).
    RenderScene(Scene scene, bool animated);
    /// Takes over the surfaces as well that were built for the plan (PlannedScene).
    RenderScene(Scene scene, ScenePlan plan, bool animated, std::vector<ObjectSurface> surfaces = {});
    RenderScene(const RenderScene &) = delete;
    RenderScene &operator=(const RenderScene &) = delete;

    /// Brings everything to a frame (which may be fractional). Adds to `times`. What has not changed since the last call is left as it
    /// is: after setLight() or setMaterial() nothing moves, after setPoints() that object alone; objects with a point source are always
    /// asked anew, for their caller may have written into his arrays.
    void setFrame(double frame, StageTimes &times);
    void setFrame(double frame) {
        StageTimes times;
        setFrame(frame, times);
    }

    // --- changes between two frames: taken in by the next setFrame(), topology is not built again. Throw InputError for an index that is
    // none or a value that makes the scene none (check_scene.h), and leave things as they were. A FrameRender made before a change must not
    // go on after it.
    void setCamera(Camera camera);
    /// The plan's choice for the old material is dropped: each hit chooses by its M.
    void setMaterial(Index material, Material value);
    void setLight(Index light, Light value);
    void setEnvironment(std::optional<Environment> value);
    /// What moves an object, where its surface and its rest stay what they are (canMove).
    void setMotion(Index object, std::vector<DeformerKeys> deformers, Placement placement);
    /// Whether setMotion() can: it deforms, or not, as before, and its rest is the same.
    [[nodiscard]] bool canMove(Index object, const std::vector<DeformerKeys> &deformers, const Placement &placement) const;
    /// Pixels of the pictures to come; at least 1 each.
    void setSize(int width, int height);
    /// What a plan says of materials, one entry each; of meshes it stays what it was when this was made.
    void setMaterialPlans(std::vector<MultiscatterPlan> materials, std::vector<DetailPlan> details, float bearableWaste);
    /// For an object that was made with a point source, a deformer or another motion that deforms; as many points as its mesh has.
    void setPoints(Index object, std::shared_ptr<const PointSource> points);

    [[nodiscard]] const Scene &scene() const { return scene_; }
    /// Whether deforming meshes have BVHs that can be refitted; else everything is built anew when something deforms.
    [[nodiscard]] bool refits() const { return refits_; }
    /// Whether any material lets rays pass as if there were no surface: then traversal needs a SurfaceTest.
    [[nodiscard]] bool surfacesMayBeAbsent() const { return surfacesMayBeAbsent_; }
    [[nodiscard]] const EmbreeScene &embree() const { return *embree_; }
    [[nodiscard]] const std::vector<RenderObject> &objects() const { return objects_; }
    [[nodiscard]] const LightTable &lights() const { return lights_; }
    [[nodiscard]] const CameraState &camera() const { return camera_; }
    /// Where the camera stands at equally spaced times in the shutter; render space is its own at the frame itself. One where it
    /// stands still.
    [[nodiscard]] const std::vector<Affine> &cameraSteps() const { return cameraSteps_; }
    [[nodiscard]] const ScenePlan &plan() const { return plan_; }
    [[nodiscard]] const DMat4 &worldFromRender() const { return worldFromRender_; }

    /// The object behind an Embree geometry number.
    [[nodiscard]] Index objectOfGeometry(Index geometry) const { return owners_[geometry]; }
    /// The part of the light table that a triangle of an object is; entry kNone where it is none.
    [[nodiscard]] LightPart lightPartOf(Index object, Index triangle) const { return partOfTriangle(lights_.emitters[object], triangle); }

  private:
    void askForSurfaces();
    void askForStrains();
    void addPyramids(Index material);
    [[nodiscard]] std::size_t motionSteps() const;
    void moveCamera(double frame, const DMat4 &renderFromWorld);

    Index addInstance(const RenderObject &object);
    void prepare(bool animated, std::vector<ObjectSurface> surfaces);

    Scene scene_;
    ScenePlan plan_;
    std::unique_ptr<EmbreeScene> embree_;
    bool refits_ = false;
    std::vector<RenderObject> objects_;
    std::vector<Index> owners_;                // [geometries] -> object
    std::map<InstanceShape, Index> instances_; // the geometry whose BVH is shared
    LightTable lights_;
    CameraState camera_;
    std::vector<Affine> cameraSteps_;
    DMat4 worldFromRender_{1};
    bool committed_ = false;
    bool surfacesMayBeAbsent_ = false;
    // What the objects were last brought to.
    double frame_ = 0;
    std::vector<unsigned char> changed_; // [objects] since then
};

} // namespace taut
