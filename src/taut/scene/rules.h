#pragma once
/// What must hold between several values of a scene: for the readers, who know the line, and for check(). Internal to `scene/`.

#include "taut/scene/scene.h"

#include <optional>
#include <string>

namespace taut {

/// What is wrong, as an error says it.
struct Mistake {
    std::string found, expected;
};

/// A camera without a rig must look somewhere, at its keys and at the frames rendered.
std::optional<Mistake> mistakeInView(const Camera &camera, const std::vector<int> &frames);
/// Multiple scattering must be there for the material's type and masking.
std::optional<Mistake> mistakeInMultiscatter(const Material &material);
/// An estimator must suit the surface, subdivided or not.
std::optional<Mistake> mistakeInGradient(const Object &object);
/// The scheme "loop" wants triangles, but for corners that repeat their neighbour.
std::optional<Mistake> mistakeInScheme(const Object &object);
/// Lean is known to deformers alone.
std::optional<Mistake> mistakeInLean(const Object &object);
/// The part of an axis on which bend, twist and taper act.
std::optional<Mistake> mistakeInRange(const DeformerKeys &keys);
/// The two axes of bend.
std::optional<Mistake> mistakeInBend(const DeformerKeys &keys);
std::optional<Mistake> mistakeInLatticeBox(const DeformerKeys &keys);

} // namespace taut
