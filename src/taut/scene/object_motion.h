#pragma once
/// Where an object of a scene is at one frame: glTF pose, morphs, sequence, deformers and placement, brought together as the
/// MotionState that deform/ evaluates.

#include "taut/deform/surface_motion.h"
#include "taut/mesh/point_cache.h"
#include "taut/scene/scene.h"

#include <array>
#include <memory>
#include <unordered_map>

namespace taut {

/// Linear part of the rest placement (docs/design.md, "The rest state"): constant scale and shear of the object's placement, of
/// its node and of its skeleton. Symmetric and positive: rotation and mirroring change no shape and are left out.
Mat3 restFromObject(const Object &object);

/// Buffers of one object that live as long as a render: morphed or sequenced control points, sequence files read so far.
struct ObjectMotion {
    std::vector<Vec3> control;
    std::unordered_map<int, std::vector<Vec3>> sequenceFrames;
    std::shared_ptr<PointCacheReader> cache;
    std::array<std::vector<Vec3>, 2> cacheSamples;    ///< the samples read last,
    std::array<std::int64_t, 2> cacheNumbers{-1, -1}; ///< and which they are
    Deformer deformer;                                ///< scratch
    MotionState state;
};

/// Fills motion.state for `frame`. renderFromWorld is applied last, in double, so that a rigid motion shared by objects and
/// camera leaves no trace in the rounded matrices. Throws InputError where a sequence file can't be read.
void motionAtFrame(const Object &object, double frame, double fps, const DMat4 &renderFromWorld, ObjectMotion &motion);

/// True where the object's surface is never deformed relative to its rest state: rigid or constant placements only.
bool isRigid(const Object &object);

} // namespace taut
