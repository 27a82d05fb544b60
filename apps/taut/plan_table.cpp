#include "plan_table.h"

#include "taut/pilot/foreseen_time.h"

#include <fmt/format.h>

#include <optional>

namespace taut::app {

namespace {

/// What costs are multiplied by to be seconds of the whole job.
class JobCounts {
  public:
    JobCounts(const Scene &scene, const ScenePlan &plan) : scene_(scene) {
        const double samples = plan.budget && plan.budget->samples > 0 ? static_cast<double>(plan.budget->samples) : scene.render.spp;
        frames_ = static_cast<double>(scene.render.frames.size());
        samples_ = samples * scene.render.width * scene.render.height * frames_;
    }

    /// None where the cost is no time.
    [[nodiscard]] std::optional<double> seconds(const Question &question, const Choice &choice) const {
        const auto cost = static_cast<double>(choice.cost);
        const std::string_view unit = unitOf(question);
        if (unit.starts_with("ns a hit")) return 1e-9 * cost * samples_;
        if (unit.starts_with("us a frame")) return 1e-6 * cost * frames_;
        if (unit.starts_with("ms a frame")) return 1e-3 * cost * frames_;
        if (unit.starts_with("rays a sample")) return ForeseenTime(scene_).rays(cost * samples_);
        return std::nullopt;
    }

  private:
    const Scene &scene_;
    double frames_ = 1;
    double samples_ = 0; ///< of all pixels and frames
};

std::string row(const std::string &whose, const Question &q, const JobCounts &counts) {
    const Choice &taken = q.choices[q.taken];
    const std::optional<double> time = counts.seconds(q, taken);
    const auto text = [](const std::optional<double> &seconds) { return seconds ? fmt::format("{:.3g} s", *seconds) : std::string("-"); };
    const auto less = [&](const Choice &choice) -> std::optional<double> {
        const std::optional<double> other = counts.seconds(q, choice);
        if (!time || !other) return std::nullopt;
        return *other - *time;
    };
    std::string next = "-";
    if (q.taken + 1 < q.choices.size() && q.choices[q.taken + 1].error < taken.error) {
        const Choice &dearer = q.choices[q.taken + 1];
        next = fmt::format("{}: error {:.2g}, {} more", nameOf(dearer.value), dearer.error, text(less(dearer)));
    }
    return fmt::format("  {:<16.16} {:<14} {:<16.16} {:>8.2g} {:>9} {:>9}  {}\n", whose, nameOf(q), nameOf(taken.value), taken.error,
                       text(time), q.taken + 1 < q.choices.size() ? text(less(q.choices.back())) : "-", next);
}

} // namespace

std::string planTable(const Scene &scene, const ScenePlan &plan) {
    const JobCounts counts(scene, plan);
    std::string text =
        fmt::format("  {:<16} {:<14} {:<16} {:>8} {:>9} {:>9}  {}\n", "of", "question", "taken", "error", "time", "saves", "next step");
    const std::size_t head = text.size();
    for (std::size_t i = 0; i < plan.meshes.size(); ++i)
        for (const Question &q : plan.meshes[i].questions)
            if (q.choices.size() > 1) text += row(scene.objects[i].name, q, counts);
    for (std::size_t i = 0; i < plan.materials.size(); ++i) {
        if (plan.materials[i].question) text += row(scene.materials[i].name, *plan.materials[i].question, counts);
        if (plan.details[i].question) text += row(scene.materials[i].name, *plan.details[i].question, counts);
    }
    if (plan.events) text += row("paths", *plan.events, counts);
    if (plan.motion) text += row("the shutter", *plan.motion, counts);
    if (text.size() == head) return "";
    return text;
}

std::string pilotLines(const ScenePlan &plan) {
    std::string text;
    for (const PilotFinding &f : plan.pilots)
        text += fmt::format("  pilot: {}: error {:.2g} +- {:.1g}{}, noise of a sample {:.2g}, {:.3g} rays a sample\n", nameOf(f.value),
                            f.error, f.spread, f.predicted > 0 ? fmt::format(" (analysis: {:.2g})", f.predicted) : "", f.noise, f.rays);
    if (!plan.budget) return text;
    const ErrorBudget &b = *plan.budget;
    const auto share = [&](float part) { return 100 * part * part / (b.error * b.error); };
    return text + fmt::format("budget: error {:.3g}; of its square {:.0f} % for bias ({:.2g}{}), {:.0f} % for noise ({:.3g}{})\n", b.error,
                              share(b.bias), b.bias, plan.pilots.empty() ? ", a bound" : ", by pilots", share(b.noise), b.noise,
                              b.samples > 0 ? fmt::format(", about {:.3g} samples a pixel", b.samples) : "");
}

} // namespace taut::app
