#pragma once
/// Evaluation of a rig at any time: STEP, LINEAR (rotations by slerp) and CUBICSPLINE (glTF 2.0, appendix C).

#include "taut/deform/rig.h"

#include <vector>

namespace taut {

/// State of a node hierarchy at one time.
struct Pose {
    std::vector<DMat4> worldFromNode;             ///< [nodes]; the rig's space
    std::vector<std::vector<float>> morphWeights; ///< [nodes]; empty where the node has none
};

/// Pose of `clip` at `seconds` (held before the first and after the last key). `clip` may be null: the nodes as stored.
Pose evaluatePose(const Rig &rig, const Clip *clip, double seconds);

/// The pose against which deformation is measured (docs/pipeline.md, "The rest state"): nodes as stored, but a scale channel whose
/// keys are all equal counts as the node's own scale, so that a constant scale is a placement, not a deformation.
Pose restPose(const Rig &rig, const Clip *clip);

/// Whether a channel holds one value: its keys are equal and nothing swings out between them.
bool hasEqualKeys(const Channel &channel);

/// One channel at a time, normalised for rotations. Returns `channel.width` floats.
std::vector<float> evaluateChannel(const Channel &channel, double seconds);

/// Joint matrices worldFromJoint * inverseBind of a skin, in the rig's space.
std::vector<DMat4> jointMatrices(const Skin &skin, const Pose &pose);

} // namespace taut
