#pragma once
/// What a plan asks: a question's choices, what each loses and costs, and the one taken. Choices are values; names are for printing.

#include "taut/bsdf/multiscatter_choice.h"
#include "taut/deform/estimators.h"
#include "taut/scene/material.h"

#include <string>
#include <variant>
#include <vector>

namespace taut {

/// What M follows, cheapest first.
enum class StretchModel {
    Constant,  ///< the rest material: rigid motion, or roughness held fixed
    Uniform,   ///< one V for the whole mesh, anew each frame
    PerVertex, ///< V at every vertex: three numbers in the tangent plane
    Leaning,   ///< V and the lean at every vertex: five numbers
};

/// How many times a mesh is refined.
struct SubdivisionLevel {
    int level = 0;
    bool operator==(const SubdivisionLevel &) const = default;
};

/// How many scattering events a path has at most.
struct EventLimit {
    int events = 0;
    bool operator==(const EventLimit &) const = default;
};

/// At how many times within the shutter what moves is evaluated.
struct MotionSteps {
    int steps = 0;
    bool operator==(const MotionSteps &) const = default;
};

/// What a frame does to the BVHs of the meshes that deform.
enum class BvhKind {
    Refit,   ///< BVHs that can be refitted; built anew in the frames where that costs less (bvh_policy.h)
    Rebuild, ///< quicker to trace, built anew at every frame
};

/// The kind of value says which question it answers.
using ChoiceValue = std::variant<SubdivisionLevel, StretchModel, GradientInterpolation, GradientEstimator, Multiscatter, BvhKind,
                                 TextureDetail, EventLimit, MotionSteps>;

/// One way to do something, with what it is predicted to lose and to cost.
struct Choice {
    ChoiceValue value;
    float error = 0;  ///< relative RMS of the image
    float cost = 0;   ///< in the question's unit
    float noise = 0;  ///< that it adds at the scene's samples a pixel, relative RMS, where the plan weighs that
    std::string note; ///< printed after its name
};

/// Choices of one kind, from the cheapest to the dearest, and the one taken.
struct Question {
    std::vector<Choice> choices;
    std::size_t taken = 0;

    template <class Value> [[nodiscard]] Value answer() const { return std::get<Value>(choices[taken].value); }
};

/// Multiplies predicted errors: what they are on a scene where that is known, over what they were taken for.
void scaleErrors(Question &question, float factor);

/// Takes the cheapest choice whose error fits into what is left, and spends it. The last choice is the model itself, without error.
void take(Question &question, float &left);

/// "subdivision", "stretch", "interpolation", "gradient", "multiscatter", "bvh", "texture detail", "events" or "motion steps".
std::string_view nameOf(const Question &question);
/// The unit of its costs: "ns a hit", "ns a vertex" (and frame), ...
std::string_view unitOf(const Question &question);
/// A choice among those of its question: "per vertex, 3 numbers".
std::string nameOf(const Choice &choice);
/// A value by itself: "per vertex".
std::string nameOf(const ChoiceValue &value);

} // namespace taut
