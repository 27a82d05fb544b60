#include "taut/scene/rest_placement.h"

#include "taut/deform/animation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace taut {

namespace {

/// Linear maps that differ by less than this (relative) give one shape.
constexpr double kSameShape = 1e-4;
/// A scale below this share of the greatest one is a collapse: it says nothing about the shape at rest.
constexpr double kFlat = 1e-6;
/// A placement with no entry above this leaves nothing of its mesh.
constexpr double kVanished = 1e-12;
/// Keys of a motion that are compared with its rest shape.
constexpr std::size_t kMostKeys = 4096;
/// At each key, and between it and the next: half a turn under a scale of two directions has the same shape at both ends, and in the
/// middle of a whole turn.
constexpr std::array<double, 3> kTimesOfKey{0.3819660112501051, 0.0, 0.7236067977499789};

double maxAbs(const DMat3 &m) {
    double largest = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) largest = std::max(largest, std::fabs(m[c][r]));
    return largest;
}

/// The placement that a skeleton in its rest pose gives the bind pose: the joints' common linear map where they agree, else the
/// median of their scales.
DMat3 skeletonPlacement(const std::vector<DMat4> &joints) {
    if (joints.empty()) return DMat3(1);
    const DMat3 first(joints.front());
    const double size = maxAbs(first);
    const bool common =
        std::all_of(joints.begin(), joints.end(), [&](const DMat4 &j) { return maxAbs(DMat3(j) - first) <= kSameShape * size; });
    if (common && glm::determinant(first) != 0) return first;
    std::vector<double> scales;
    for (const DMat4 &j : joints) scales.push_back(std::cbrt(std::fabs(glm::determinant(DMat3(j)))));
    std::nth_element(scales.begin(), scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2), scales.end());
    const double median = scales[scales.size() / 2];
    return DMat3(median > 0 ? median : 1.0);
}

/// The symmetric factor S of L = R S: the shape that a placement gives, without its rotation (Higham 1986, Newton's iteration).
DMat3 withoutRotation(const DMat3 &placement) {
    DMat3 r = placement;
    for (int i = 0; i < 32; ++i) r = 0.5 * (r + glm::transpose(glm::inverse(r)));
    DMat3 s = glm::transpose(r) * placement;
    const double size = maxAbs(s);
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
            if (std::fabs(s[c][k]) < 1e-14 * size) s[c][k] = 0;
    return s;
}

/// Eigenvectors in the columns of `vectors`, for a symmetric matrix (Jacobi's rotations); unlike Newton's iteration this minds no zeros.
DVec3 symmetricEigen(DMat3 a, DMat3 &vectors) {
    vectors = DMat3(1);
    for (int sweep = 0; sweep < 16; ++sweep)
        for (const auto [p, q] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
            if (a[p][q] == 0) continue;
            const double angle = 0.5 * std::atan2(2 * a[p][q], a[q][q] - a[p][p]);
            DMat3 turn(1);
            turn[p][p] = turn[q][q] = std::cos(angle);
            turn[q][p] = std::sin(angle);
            turn[p][q] = -std::sin(angle);
            a = glm::transpose(turn) * a * turn;
            a[p][q] = a[q][p] = 0;
            vectors = vectors * turn;
        }
    return {a[0][0], a[1][1], a[2][2]};
}

/// The shape that a placement gives: symmetric, positive, and invertible whatever the placement.
DMat3 shapeOf(const DMat3 &placement) {
    const double size = maxAbs(placement);
    if (!(size > kVanished) || !std::isfinite(size)) return DMat3(1);
    const DMat3 unit = placement / size;
    DMat3 directions;
    DVec3 scales = symmetricEigen(glm::transpose(unit) * unit, directions);
    for (int i = 0; i < 3; ++i) scales[i] = std::sqrt(std::max(scales[i], 0.0));
    const double greatest = std::max({scales.x, scales.y, scales.z});
    if (std::min({scales.x, scales.y, scales.z}) < kFlat * greatest) {
        DMat3 s(0);
        for (int i = 0; i < 3; ++i)
            s += glm::outerProduct(directions[i], directions[i]) * (scales[i] < kFlat * greatest ? greatest : scales[i]);
        return s * size;
    }
    // Newton's iteration halves a large scale and doubles a small one at each step, so extremes are brought near 1, exactly.
    const int exponent = std::fabs(std::log2(size)) > 16 ? std::ilogb(size) : 0;
    const DMat3 near = placement * std::ldexp(1.0, -exponent);
    return withoutRotation(glm::determinant(near) < 0 ? -near : near) * std::ldexp(1.0, exponent);
}

/// Whether a placement is the shape, turned or mirrored: L^T L = S^T S.
bool keepsShape(const DMat3 &placement, const DMat3 &shape) {
    const double size = maxAbs(shape);
    const DMat3 l = placement / size;
    const DMat3 s = shape / size;
    return maxAbs(glm::transpose(l) * l - glm::transpose(s) * s) <= 2 * kSameShape;
}

/// Whether a linear map turns and scales alone, by one factor.
bool isSimilarity(const DMat3 &m) {
    const double size = maxAbs(m);
    if (!(size > 0)) return false;
    const DMat3 l = m / size;
    const DMat3 gram = glm::transpose(l) * l;
    return maxAbs(gram - DMat3(gram[0][0])) <= 2 * kSameShape * gram[0][0];
}

/// The nodes from the root to an object's own as a rig of their own, however large the whole one is, and what turns or scales them.
struct Chain {
    Rig rig;
    std::vector<std::pair<Index, const Channel *>> channels; ///< with their node in `rig`
    std::vector<DMat3> rest;                                 ///< [nodes] linear part in the rest pose, from the root on

    /// The channels as a clip of `rig`; of constant scales alone, which is all that the rest pose asks for.
    [[nodiscard]] Clip clip(bool constantScales) const {
        Clip clip;
        for (const auto &[node, channel] : channels) {
            if (constantScales && (channel->path != ChannelPath::Scale || !hasEqualKeys(*channel))) continue;
            clip.channels.push_back(*channel);
            clip.channels.back().node = node;
        }
        return clip;
    }
};

Chain chainOf(const RigMotion &motion) {
    const Rig &rig = *motion.rig;
    std::vector<Index> path;
    for (Index node = motion.node; node != kNone; node = rig.nodes[node].parent) path.push_back(node);
    std::reverse(path.begin(), path.end());
    Chain chain;
    for (Index i = 0; i < path.size(); ++i) {
        for (const Channel *channel : motion.poses->channelsOf(motion.rig, clipOf(motion), path[i])) {
            const bool turns = channel->path == ChannelPath::Rotation || channel->path == ChannelPath::Scale;
            if (turns && !channel->times.empty()) chain.channels.emplace_back(i, channel);
        }
        Node node = rig.nodes[path[i]];
        node.parent = i == 0 ? kNone : i - 1;
        chain.rig.nodes.push_back(std::move(node));
    }
    const Clip constant = chain.clip(true);
    for (const DMat4 &m : restPose(chain.rig, &constant).worldFromNode) chain.rest.emplace_back(m);
    return chain;
}

/// False where no time can change the shape, from what the matrices are: rotations change none but below a non-uniform scale.
bool mayDeform(const Chain &chain, const DMat3 &above) {
    if (chain.channels.empty()) return false;
    std::vector<unsigned char> turns(chain.rig.nodes.size(), 0);
    for (const auto &[node, channel] : chain.channels) {
        if (chain.rig.nodes[node].matrix) continue;
        if (channel->path == ChannelPath::Scale && !hasEqualKeys(*channel)) return true;
        turns[node] |= channel->path == ChannelPath::Rotation ? 1 : 0;
    }
    bool similar = isSimilarity(above);
    for (Index i = 0; i < chain.rig.nodes.size(); ++i) {
        if (turns[i] != 0 && !similar) return true;
        similar = similar && isSimilarity(above * chain.rest[i]);
    }
    return false;
}

/// Whether the placement keeps the rest's shape, and its orientation, which instances have for good, at every key of the chain and between
/// them.
bool keepsShapeOverTime(const Chain &chain, const DMat3 &above, const DMat3 &shape) {
    const double side = glm::determinant(chain.rest.back());
    const Clip clip = chain.clip(false);
    std::vector<double> keys;
    for (const Channel &channel : clip.channels) keys.insert(keys.end(), channel.times.begin(), channel.times.end());
    if (keys.size() > kMostKeys) return false;
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const double next = keys[std::min(i + 1, keys.size() - 1)];
        for (const double u : kTimesOfKey) {
            const Pose pose = evaluatePose(chain.rig, &clip, keys[i] + u * (next - keys[i]));
            const DMat3 linear(pose.worldFromNode.back());
            if (!keepsShape(above * linear, shape) || (glm::determinant(linear) < 0) != (side < 0)) return false;
        }
    }
    return true;
}

} // namespace

const Skin *skinOf(const Object &object) {
    if (!object.rig || object.mesh->skin.empty()) return nullptr;
    const Index skin = object.rig->rig->nodes[object.rig->node].skin;
    return skin == kNone ? nullptr : &object.rig->rig->skins[skin];
}

Mat3 restFromObject(const Object &object) {
    DMat3 rest(1);
    if (const Skin *skin = skinOf(object))
        rest = skeletonPlacement(jointMatrices(*skin, *restPoseOf(*object.rig)));
    else if (object.rig)
        rest = chainOf(*object.rig).rest.back();
    return Mat3(shapeOf(placementRest(object.placement) * rest));
}

namespace {

/// False where the kinds of its motions tell already.
bool maybeRigid(const Object &object) {
    if (object.points || !object.deformers.empty() || !object.rest.bind || !object.placement.scale.isConstant()) return false;
    return skinOf(object) == nullptr && (!object.rig || object.mesh->morphs.empty());
}

} // namespace

bool isRigid(const Object &object) {
    if (!maybeRigid(object)) return false;
    const DMat3 above = placementRest(object.placement);
    if (!object.rig) return keepsShape(above, shapeOf(above)); // else flat
    const RigMotion &motion = *object.rig;
    return motion.poses->once(motion.rig, clipOf(motion), motion.node, above, [&] {
        const Chain chain = chainOf(motion);
        const DMat3 placement = above * chain.rest.back();
        const DMat3 shape = shapeOf(placement);
        return keepsShape(placement, shape) && (!mayDeform(chain, above) || keepsShapeOverTime(chain, above, shape));
    });
}

double placementsToCompare(const Object &object) {
    if (!maybeRigid(object) || !object.rig) return 0;
    const Chain chain = chainOf(*object.rig);
    if (!mayDeform(chain, placementRest(object.placement))) return 0;
    std::size_t keys = 0;
    for (const auto &[node, channel] : chain.channels) keys += channel->times.size();
    return keys > kMostKeys ? 0 : static_cast<double>(keys * kTimesOfKey.size() * chain.rig.nodes.size());
}

} // namespace taut
