#include "taut/plan/question.h"

#include <algorithm>
#include <array>

namespace taut {

namespace {

struct ValueNames {
    ChoiceValue value;
    std::string_view name;
    std::string_view asChoice = name; ///< with what tells it from the other choices
};

/// Estimators and interpolations have names of their own, those of scene files (estimators.h).
constexpr ValueNames kValues[] = {
    {StretchModel::Constant, "constant"},
    {StretchModel::Uniform, "uniform"},
    {StretchModel::PerVertex, "per vertex", "per vertex, 3 numbers"},
    {StretchModel::Leaning, "leaning", "leaning, 5 numbers"},
    {Multiscatter::Off, "off"},
    {Multiscatter::Compensation, "compensation"},
    {Multiscatter::Walk, "walk"},
    {Multiscatter::Auto, "by each hit's M", "compensation where M asks for it"},
    {BvhKind::Refit, "refit"},
    {BvhKind::Rebuild, "rebuild"},
    {TextureDetail::Moments, "moments", "moments over each pixel's footprint"},
    {TextureDetail::Map, "map", "the map itself"},
};

struct QuestionNames {
    std::string_view name, unit;
};
/// [the kind of value]
constexpr std::array<QuestionNames, std::variant_size_v<ChoiceValue>> kQuestions{{
    {"subdivision", "us a frame"},
    {"stretch", "ns a hit"},
    {"interpolation", "ns a hit"},
    {"gradient", "ns a vertex"},
    {"multiscatter", "ns a hit at equal noise"},
    {"bvh", "ms a frame, slower rays included"},
    {"texture detail", "samples for equal noise"},
    {"events", "rays a sample"},
    {"motion steps", "evaluations a frame"},
}};

const QuestionNames &namesOf(const Question &question) {
    return kQuestions[question.choices.front().value.index()];
}

std::string printed(const ChoiceValue &value, std::string_view ValueNames::*name) {
    if (const auto *level = std::get_if<SubdivisionLevel>(&value)) return "level " + std::to_string(level->level);
    if (const auto *limit = std::get_if<EventLimit>(&value)) return "at most " + std::to_string(limit->events);
    if (const auto *motion = std::get_if<MotionSteps>(&value)) return std::to_string(motion->steps) + " times";
    if (const auto *estimator = std::get_if<GradientEstimator>(&value)) return nameOf(*estimator);
    if (const auto *interpolation = std::get_if<GradientInterpolation>(&value)) return nameOf(*interpolation);
    const auto *found = std::find_if(std::begin(kValues), std::end(kValues), [&](const ValueNames &v) { return v.value == value; });
    return std::string(found->*name);
}

} // namespace

void scaleErrors(Question &question, float factor) {
    for (Choice &choice : question.choices) choice.error *= factor;
}

void take(Question &question, float &left) {
    const auto fits = [&](const Choice &choice) { return choice.error <= left; };
    const auto found = std::find_if(question.choices.begin(), question.choices.end() - 1, fits);
    question.taken = static_cast<std::size_t>(found - question.choices.begin());
    left -= found->error;
}

std::string_view nameOf(const Question &question) {
    return namesOf(question).name;
}
std::string_view unitOf(const Question &question) {
    return namesOf(question).unit;
}
std::string nameOf(const Choice &choice) {
    return printed(choice.value, &ValueNames::asChoice) + choice.note;
}
std::string nameOf(const ChoiceValue &value) {
    return printed(value, &ValueNames::name);
}

} // namespace taut
