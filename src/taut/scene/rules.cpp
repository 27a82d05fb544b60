#include "taut/scene/rules.h"

#include "taut/base/error.h"
#include "taut/deform/estimators.h"

namespace taut {

namespace {

/// Frames at which to look for a camera that can't see: its keys and the frames rendered.
std::vector<double> framesToCheck(const Camera &camera, const std::vector<int> &rendered) {
    std::vector<double> frames(rendered.begin(), rendered.end());
    for (const Keyed<DVec3> *keyed : {&camera.position, &camera.lookAt, &camera.up})
        for (const auto &key : keyed->keys) frames.push_back(key.first);
    return frames;
}

bool isSubdivided(const Object &object) {
    return object.subdivision.level > 0;
}

std::string quotedName(Multiscatter mode) {
    return mode == Multiscatter::Walk ? "'walk'" : "'compensation'";
}

} // namespace

std::optional<Mistake> mistakeInView(const Camera &camera, const std::vector<int> &frames) {
    for (const double frame : framesToCheck(camera, frames)) {
        const DVec3 view = camera.lookAt.at(frame) - camera.position.at(frame);
        if (!(glm::length(view) > 0)) return Mistake{"position equal to look_at at frame " + formatNumber(frame), "two points"};
        if (!(glm::length(camera.up.at(frame)) > 0)) return Mistake{"up of no length at frame " + formatNumber(frame), "a direction"};
    }
    return {};
}

std::optional<Mistake> mistakeInMultiscatter(const Material &material) {
    const Multiscatter mode = material.multiscatter;
    if (mode == Multiscatter::Off || mode == Multiscatter::Auto) return {};
    const BsdfInfo &kind = bsdfInfo(material.type);
    if (!kind.manyFacets) return Mistake{quotedName(mode) + ", which this version does not have yet for this type", "'off' or 'auto'"};
    if (!kind.compensates() && mode == Multiscatter::Compensation)
        return Mistake{"'compensation' for a " + std::string(kind.name), "'off', 'walk' or 'auto'"};
    if (material.masking == Masking::Separable)
        return Mistake{quotedName(mode) + " with separable masking", "'off' or 'auto', or masking = 'correlated'"};
    return {};
}

std::optional<Mistake> mistakeInGradient(const Object &object) {
    const bool limit = object.gradient == GradientEstimator::Limit;
    const bool analytic = object.gradient == GradientEstimator::Analytic;
    if (!limit && !analytic) return {};
    if (limit == isSubdivided(object)) return {};
    return Mistake{quoted(nameOf(*object.gradient)), isSubdivided(object) ? "'limit' or one of the fits for a subdivided mesh"
                                                                          : "'analytic' or one of the fits without subdivision"};
}

std::optional<Mistake> mistakeInScheme(const Object &object) {
    if (!isSubdivided(object) || object.subdivision.scheme != SubdivisionScheme::Loop) return {};
    const Mesh &mesh = *object.mesh;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const Index begin = mesh.faceOffsets[f];
        const Index end = mesh.faceOffsets[f + 1];
        Index corners = 0;
        for (Index c = begin; c < end; ++c)
            corners += mesh.cornerPositions[c] != mesh.cornerPositions[c + 1 == end ? begin : c + 1] ? 1 : 0;
        if (corners > 3)
            return Mistake{"face " + std::to_string(f) + " with " + std::to_string(corners) + " corners",
                           "triangles for the scheme \"loop\""};
    }
    return {};
}

std::optional<Mistake> mistakeInLean(const Object &object) {
    if (!object.lean) return {};
    if (!isSubdivided(object) && object.gradient.value_or(GradientEstimator::Analytic) == GradientEstimator::Analytic) return {};
    return Mistake{"lean = true",
                   "lean = false, or gradient = \"analytic\" without subdivision: the space above a surface is known to deformers alone"};
}

std::optional<Mistake> mistakeInRange(const DeformerKeys &keys) {
    if (keys.lower < keys.upper) return {};
    return Mistake{"[" + formatNumber(keys.lower) + ", " + formatNumber(keys.upper) + "]", "lower below upper"};
}

std::optional<Mistake> mistakeInBend(const DeformerKeys &keys) {
    if (keys.axis != keys.axis2) return {};
    return Mistake{"axis and towards alike", "two different axes"};
}

std::optional<Mistake> mistakeInLatticeBox(const DeformerKeys &keys) {
    if (glm::all(glm::lessThan(keys.latticeLower, keys.latticeUpper))) return {};
    return Mistake{"a lattice box without volume", "lower below upper in x, y and z"};
}

} // namespace taut
