#include "taut/plan/asked_questions.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Calls f(question) for each of a plan's meshes, materials and details.
template <class F> void forEachQuestion(const ScenePlan &plan, const F &f) {
    for (const MeshPlan &mesh : plan.meshes)
        for (const Question &question : mesh.questions) f(question);
    for (const MultiscatterPlan &material : plan.materials)
        if (material.question) f(*material.question);
    for (const DetailPlan &detail : plan.details)
        if (detail.question) f(*detail.question);
}

} // namespace

double predictedFor(const ScenePlan &plan, const ChoiceValue &value) {
    double squares = 0;
    forEachQuestion(plan, [&](const Question &question) {
        for (const Choice &choice : question.choices)
            if (choice.value == value) squares += sqr(static_cast<double>(choice.error));
    });
    return std::sqrt(squares);
}

bool isAsked(const ScenePlan &plan, const ChoiceValue &value) {
    bool found = false;
    forEachQuestion(plan, [&](const Question &question) {
        found |= std::any_of(question.choices.begin(), question.choices.end(), [&](const Choice &choice) { return choice.value == value; });
    });
    return found;
}

} // namespace taut
