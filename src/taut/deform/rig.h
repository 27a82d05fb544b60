#pragma once
/// What animates a mesh, as plain data: a hierarchy of nodes, clips of keyed channels, skins. No file format: a reader fills it
/// (formats/gltf.h), or a program does; deform/animation.h evaluates it.
///
/// Space: the rig's own ("scene space" of a glTF file: right-handed, y up, metres). What the data mean is glTF 2.0's.

#include "taut/base/vec.h"

#include <optional>
#include <string>
#include <vector>

namespace taut {

enum class Interpolation { Step, Linear, CubicSpline };
enum class ChannelPath { Translation, Rotation, Scale, Weights };

/// One animated property of one node. `values` holds `width` floats a key (3, 4 or the number of morphs); for
/// CubicSpline three times that: in-tangent, value, out-tangent. Rotations are quaternions x, y, z, w.
struct Channel {
    Index node = kNone;
    ChannelPath path = ChannelPath::Translation;
    Interpolation interpolation = Interpolation::Linear;
    Index width = 3;
    std::vector<float> times; ///< seconds, strictly increasing
    std::vector<float> values;
};

struct Clip {
    std::string name;
    std::vector<Channel> channels;
    float duration = 0; ///< the last key's time, seconds
};

/// A node of the hierarchy: parentFromNode = matrix if given, else T * R * S.
struct Node {
    std::string name;
    Index parent = kNone;
    DVec3 translation{0};
    DQuat rotation{1, 0, 0, 0}; ///< w, x, y, z
    DVec3 scale{1};
    std::optional<DMat4> matrix;
    Index skin = kNone;              ///< into Rig::skins: what moves the meshes of this node instead of the node itself
    std::vector<float> morphWeights; ///< at rest; may be empty
};

struct Skin {
    std::string name;
    std::vector<Index> joints;            ///< nodes
    std::vector<DMat4> inverseBindMatrix; ///< [joints]: jointFromMesh of the bind pose
};

struct Rig {
    std::vector<Node> nodes; ///< parents come before their children
    std::vector<Skin> skins;
    std::vector<Clip> clips;
};

} // namespace taut
