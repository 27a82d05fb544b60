#pragma once
/// Where an object of a scene is at one frame: the rig's pose, morphs, a point source, deformers and placement, brought together as the
/// MotionState that deform/ evaluates.

#include "taut/deform/surface_motion.h"
#include "taut/scene/rest_placement.h"

#include <memory>

namespace taut {

/// What one object holds as long as it is rendered.
struct ObjectMotion {
    std::vector<Vec3> control;                 ///< morphed control points
    std::vector<Vec3> normals;                 ///< morphed normals, where the file has them
    std::shared_ptr<const PointSource> source; ///< the object's, with the way through it
    std::unique_ptr<PointReader> points;
    Deformer deformer; ///< scratch
    MotionState state;
};

/// Fills motion.state for `frame`. renderFromWorld is applied last, in double, so that a rigid motion shared by objects and
/// camera leaves no trace in the rounded matrices. Throws InputError where the object's points
/// can't be read, are not as many as its mesh has, or are not finite.
void motionAtFrame(const Object &object, double frame, double fps, const DMat4 &renderFromWorld, ObjectMotion &motion);

/// Whether its vertices or their M change between frames, as those of every mesh that stores its M may.
bool deforms(const Object &object);
/// Whether it may be somewhere else at another time.
bool moves(const Object &object);

} // namespace taut
