#include "taut/pilot/plan_by_pilots.h"

#include "taut/base/sobol.h"
#include "taut/pilot/foreseen_time.h"
#include "taut/pilot/pilot_picture.h"
#include "taut/plan/asked_questions.h"
#include "taut/plan/mesh_questions.h"
#include "taut/render/frame_render.h"
#include "taut/render/pixel_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace taut {

namespace {

constexpr int kWindows = 49;       // of a pilot, if they may be so many
constexpr int kFewestWindows = 16; // that tell anything
constexpr int kSamples = 4;        // a pixel, each of the two pictures
constexpr std::uint32_t kSeed = 0x71107;
/// Share of the time to build the finest levels that pilots may take where they choose coarser ones: each level takes a fourth of the next.
constexpr double kLevelShare = 0.3;
/// The finest level of a pilot; errors of finer ones follow.
constexpr int kFinestPilot = 3;
/// How errors fall from level to level: 4 where lines are straight instead of curved, 2 where an outline is off by more than a pixel.
constexpr float kLeastRatio = 2;
constexpr float kGreatestRatio = 4;
/// How the variance of a sample's mean falls with the number of samples: n^-p. What the bench's scenes have.
constexpr double kTypicalExponent = 1.25;
/// Relative RMS noise of one sample a pixel, as the quieter of the bench's scenes have: pilots shall not be dear there either.
constexpr double kTypicalNoise = 0.25;
/// Shares of an error that models may have, and what they may turn out to have together before less is saved.
constexpr std::array<float, 5> kShares{0.05F, 0.15F, 0.3F, 0.5F, 0.7F};
constexpr double kGreatestBias = 0.75;
/// An error from which on few samples may do.
constexpr float kCoarse = 0.05F;
/// Share of an error that models may have where nothing is measured.
constexpr float kShareByBounds = 0.3F;
constexpr std::array<int, 2> kEventLimits{2, 4};
constexpr std::array<int, 2> kMotionSteps{2, 3};
/// Share of the rays that a limit of events must save: where pilots see hardly any path that is longer, they don't see its light either,
/// which may be rare and bright.
constexpr float kLeastRaysSaved = 0.05F;

class PilotedPlan {
  public:
    PilotedPlan(const Scene &scene, const PlanOptions &options)
        : scene_(scene), options_(options), planner_(scene, options), asked_(planner_.decide({}, toleranceWanted())), time_(scene) {}

    PlannedScene make() {
        const bool wanted = options_.error || options_.tolerance || planner_.choosesLevels();
        const bool measures = wanted && !options_.full && affords();
        if (measures) measureAll();
        ScenePlan plan =
            options_.error && !options_.full ? cheapestWithin(*options_.error) : withLimits(planner_.decide(scales_, options_.tolerance));
        if (options_.error && measures) {
            verify(plan);
            if (static_cast<double>(plan.predictedError) > kGreatestBias * static_cast<double>(*options_.error)) {
                plan = withLimits(planner_.decide(scales_, kShares.front() * *options_.error));
                verify(plan);
            }
        }
        if (options_.error) split(plan);
        plan.pilots = findings_;
        return planner_.finish(std::move(plan));
    }

  private:
    [[nodiscard]] std::optional<float> toleranceWanted() const { return options_.error ? options_.error : options_.tolerance; }
    [[nodiscard]] int baseLevel() const {
        const double spent = time_.build(levels(kFinestPilot));
        return spent < 0.5 * affordable() ? kFinestPilot : kProbeLevel;
    }
    /// Of the whole job in full; where an error is asked for, with the samples that a typical scene needs for it.
    [[nodiscard]] double whole() const {
        const double samples = options_.error ? samplesFor({kTypicalNoise, 0}, static_cast<double>(*options_.error)) : scene_.render.spp;
        return time_.whole(levels(kMaxSubdivisionLevel), samples);
    }
    /// Seconds that pilots may take.
    [[nodiscard]] double affordable() const {
        const double share = kPilotShare * whole();
        return planner_.choosesLevels() ? std::max(share, kLevelShare * time_.build(levels(kMaxSubdivisionLevel))) : share;
    }
    /// Of each mesh: its own, or this where the plan chooses, if it can be so fine.
    [[nodiscard]] std::vector<int> levels(int level) const {
        std::vector<int> all;
        for (const Object &object : scene_.objects)
            all.push_back(object.planLevel ? std::min(level, mostLevel(scene_, object)) : object.subdivision.level);
        return all;
    }

    /// As many windows as there is time for; false where that is too few.
    bool affords() {
        const bool leveled = planner_.choosesLevels();
        const int base = leveled ? baseLevel() : 0;
        int variants = 1 + (options_.error ? 1 : 0);
        double spent = time_.build(levels(base)) * (options_.error ? 2 : 1);
        for (int level = 1; leveled && level < base; ++level) {
            spent += time_.build(levels(level));
            ++variants;
        }
        for (const ChoiceValue &value : std::vector<ChoiceValue>{Multiscatter::Off, Multiscatter::Auto, TextureDetail::Moments})
            variants += isAsked(asked_, value) ? 1 : 0;
        variants += asksForEvents() ? static_cast<int>(kEventLimits.size()) : 0;
        if (asksForMotion()) {
            spent += static_cast<double>(kMotionSteps.size()) * time_.build(levels(base));
            variants += static_cast<int>(kMotionSteps.size());
        }
        const double left = affordable() - spent;
        const double window = time_.samples(2.0 * kSamples * kPilotWindow * kPilotWindow * variants);
        const int count = static_cast<int>(std::min<double>(kWindows, left / window));
        if (count < kFewestWindows) return false;
        windows_ = pilotWindows(scene_.render.width, scene_.render.height, count, kSeed);
        return true;
    }

    [[nodiscard]] bool asksForEvents() const {
        return (options_.error || options_.tolerance) && scene_.render.maxEvents > kEventLimits.front();
    }

    /// Of one frame alone: which of many moves most, pilots don't know.
    [[nodiscard]] bool asksForMotion() const {
        const RenderSettings &render = scene_.render;
        return (options_.error || options_.tolerance) && render.frames.size() == 1 && render.shutter > 0 &&
               render.motionSteps > kMotionSteps.front() && std::any_of(scene_.objects.begin(), scene_.objects.end(), moves);
    }

    [[nodiscard]] Scene copyOfScene() const {
        Scene copy = scene_;
        copy.budget = nullptr; // what is built here is gone before the scene itself is
        return copy;
    }

    PilotPicture picture(const RenderScene &ready, int events = 0) const {
        const RenderSettings &render = scene_.render;
        return renderPilot(ready, windows_, {kSamples, events > 0 ? events : render.maxEvents, kSeed});
    }

    /// Keeps what a choice was found to do; the error, one standard error up.
    double note(const ChoiceValue &value, const PilotPicture &found) {
        const Estimate square = squaredDifference(found, reference_);
        const double error = std::sqrt(std::max(0.0, square.value));
        const double upper = std::sqrt(std::max(0.0, square.value) + square.spread);
        const double samples = static_cast<double>(found.first.counts.paths + found.second.counts.paths);
        findings_.push_back({value, static_cast<float>(predictedFor(asked_, value)), static_cast<float>(error),
                             static_cast<float>(upper - error), static_cast<float>(noiseOfOne(found)),
                             static_cast<float>(found.rays() / samples)});
        return upper;
    }

    static double noiseOfOne(const PilotPicture &found) {
        return std::sqrt(std::max(0.0, squaredNoise(found).value) * std::pow(kSamples, kTypicalExponent));
    }

    /// Where nothing differs, the windows may miss what a choice changes.
    static float scaleOf(double measured, double predicted) {
        return measured > 0 && predicted > 0 ? static_cast<float>(std::clamp(measured / predicted, 1e-4, 10.0)) : 1.0F;
    }

    [[nodiscard]] const ScenePlan &fullModel() const {
        if (!fullModel_) fullModel_ = fullPlan(scene_);
        return *fullModel_;
    }
    /// With meshes at these levels.
    [[nodiscard]] ScenePlan fullAt(const std::vector<int> &chosen) const {
        ScenePlan plan = fullModel();
        for (std::size_t i = 0; i < plan.meshes.size(); ++i) plan.meshes[i].subdivisionLevel = chosen[i];
        return plan;
    }

    void measureAll() {
        const int base = planner_.choosesLevels() ? baseLevel() : 0;
        full_ = std::make_unique<RenderScene>(copyOfScene(), fullAt(levels(base)), false);
        full_->setFrame(planner_.hardestFrame());
        reference_ = picture(*full_);
        note(base > 0 ? ChoiceValue(SubdivisionLevel{base}) : ChoiceValue(Multiscatter::Walk), reference_);
        measureMaterials(*full_);
        if (asksForEvents()) measureEvents(*full_);
        if (asksForMotion()) measureMotion(base);
        if (base == 0) return; // what is built serves to verify a plan that changes no mesh
        full_.reset();
        measureLevels(base);
    }

    void measureMaterials(RenderScene &ready) {
        const ScenePlan &full = fullModel();
        const auto with = [&](const ChoiceValue &value, const auto &change) {
            if (!isAsked(asked_, value)) return 1.0F;
            std::vector<MultiscatterPlan> materials = full.materials;
            std::vector<DetailPlan> details = full.details;
            for (Index m = 0; m < materials.size(); ++m) change(m, materials[m], details[m]);
            ready.setMaterialPlans(std::move(materials), std::move(details), full.bearableWaste);
            ready.setFrame(planner_.hardestFrame());
            return scaleOf(note(value, picture(ready)), predictedFor(asked_, value));
        };
        scales_.off = with(Multiscatter::Off, [](Index, MultiscatterPlan &m, DetailPlan &) { m.model = Multiscatter::Off; });
        scales_.compensation = with(Multiscatter::Auto, [&](Index i, MultiscatterPlan &m, DetailPlan &) {
            m.model = Multiscatter::Auto;
            m.negligibleLoss = asked_.materials[i].negligibleLoss;
        });
        scales_.detail = with(TextureDetail::Moments, [&](Index i, MultiscatterPlan &, DetailPlan &d) {
            if (asked_.details[i].question) d.detail = TextureDetail::Moments;
        });
        ready.setMaterialPlans(full.materials, full.details, full.bearableWaste);
        ready.setFrame(planner_.hardestFrame());
    }

    void measureEvents(const RenderScene &ready) {
        Question question;
        for (const int limit : kEventLimits) {
            if (limit >= scene_.render.maxEvents) break;
            const double error = note(EventLimit{limit}, picture(ready, limit));
            if (findings_.back().rays < (1 - kLeastRaysSaved) * findings_.front().rays)
                question.choices.push_back({EventLimit{limit}, static_cast<float>(error), findings_.back().rays, 0, {}});
        }
        question.choices.push_back({EventLimit{scene_.render.maxEvents}, 0, findings_.front().rays, 0, {}});
        events_ = std::move(question);
    }

    void measureMotion(int base) {
        Question question;
        for (const int steps : kMotionSteps) {
            if (steps >= scene_.render.motionSteps) break;
            ScenePlan plan = fullAt(levels(base));
            plan.motionSteps = steps;
            RenderScene ready(copyOfScene(), std::move(plan), false);
            ready.setFrame(planner_.hardestFrame());
            const double error = note(MotionSteps{steps}, picture(ready));
            question.choices.push_back({MotionSteps{steps}, static_cast<float>(error), static_cast<float>(steps), 0, {}});
        }
        question.choices.push_back({MotionSteps{scene_.render.motionSteps}, 0, static_cast<float>(scene_.render.motionSteps), 0, {}});
        motion_ = std::move(question);
    }

    /// Errors c r^-level, one way in every pixel: the differences of levels 1 and 2 from 3 are as r + 1 to 1.
    void measureLevels(int base) {
        std::vector<double> errors;
        for (int level = 1; level < base; ++level) {
            RenderScene ready(copyOfScene(), fullAt(levels(level)), false);
            ready.setFrame(planner_.hardestFrame());
            errors.push_back(note(SubdivisionLevel{level}, picture(ready)));
        }
        float ratio = std::sqrt(kLeastRatio * kGreatestRatio);
        // What seems to fall faster was missed: a highlight may lie between the windows.
        if (errors.size() > 1) errors[1] = std::max(errors[1], errors[0] / (1 + static_cast<double>(kGreatestRatio)));
        if (errors.size() > 1 && errors[1] > 0)
            ratio = std::clamp(static_cast<float>(errors[0] / errors[1]) - 1, kLeastRatio, kGreatestRatio);
        const double beyond = 1 / (1 - std::pow(static_cast<double>(ratio), static_cast<double>(errors.size()) - base));
        scales_.subdivision = scaleOf(errors.back() * beyond, predictedFor(asked_, SubdivisionLevel{base - 1}));
        scales_.subdivisionRatio = ratio;
        if (base - 1 < kProbeLevel) scales_.subdivision *= 4 / ratio; // what is known is the error at level 1
    }

    /// With no more events and times within the shutter than its tolerance leaves room for.
    [[nodiscard]] ScenePlan withLimits(ScenePlan plan) const {
        const auto answer = [&](const std::optional<Question> &asked, std::optional<Question> &answered) {
            answered = asked;
            if (!asked) return;
            float left = std::max(0.0F, plan.tolerance - plan.predictedError);
            take(*answered, left);
            plan.predictedError += answered->choices[answered->taken].error;
        };
        answer(events_, plan.events);
        if (plan.events) plan.maxEvents = fewer(plan.events->answer<EventLimit>().events, scene_.render.maxEvents);
        answer(motion_, plan.motion);
        if (plan.motion) plan.motionSteps = fewer(plan.motion->answer<MotionSteps>().steps, scene_.render.motionSteps);
        return plan;
    }
    static int fewer(int limit, int most) { return limit < most ? limit : 0; }

    [[nodiscard]] const PilotFinding *findingOf(const ChoiceValue &value) const {
        const auto found = std::find_if(findings_.begin(), findings_.end(), [&](const PilotFinding &f) { return f.value == value; });
        return found == findings_.end() ? nullptr : &*found;
    }

    /// What is known of a plan's pictures: by the pilots of its material models and its number of events.
    struct Sampling {
        double noise = 0; ///< of one sample
        double rays = 0;
    };
    [[nodiscard]] Sampling samplingOf(const ScenePlan &plan) const {
        if (findings_.empty()) return {};
        const PilotFinding *model = &findings_.front();
        const auto isOff = [](const MultiscatterPlan &m) { return m.model == Multiscatter::Off || !m.question; };
        const auto isWalk = [](const MultiscatterPlan &m) { return m.model == Multiscatter::Walk || !m.question; };
        if (!std::all_of(plan.materials.begin(), plan.materials.end(), isWalk)) {
            const bool allOff = std::all_of(plan.materials.begin(), plan.materials.end(), isOff);
            if (const PilotFinding *other = findingOf(allOff ? Multiscatter::Off : Multiscatter::Auto)) model = other;
        }
        Sampling sampling{static_cast<double>(model->noise), static_cast<double>(model->rays)};
        if (const PilotFinding *events = plan.maxEvents > 0 ? findingOf(EventLimit{plan.maxEvents}) : nullptr) {
            sampling.rays *= static_cast<double>(events->rays / findings_.front().rays);
            if (findings_.front().noise > 0) sampling.noise *= static_cast<double>(events->noise / findings_.front().noise);
        }
        return sampling;
    }

    /// Samples a pixel until the noise is this, shared by pixels where they may be.
    [[nodiscard]] double samplesFor(const Sampling &sampling, double noise) const {
        const double shared = options_.shares && mayShare({}, scene_.render) ? std::sqrt(kSharedVariance) : 1;
        return std::max(1.0, std::pow(shared * sampling.noise / noise, 2 / kTypicalExponent));
    }

    [[nodiscard]] double secondsOf(const ScenePlan &plan, double error) const {
        const double noise = std::sqrt(std::max(sqr(error) - sqr(static_cast<double>(plan.predictedError)), sqr(0.1 * error)));
        const Sampling sampling = samplingOf(plan);
        std::vector<int> chosen;
        for (const MeshPlan &mesh : plan.meshes) chosen.push_back(mesh.subdivisionLevel);
        const double frames = static_cast<double>(scene_.render.frames.size());
        const double pixels = static_cast<double>(scene_.render.width) * scene_.render.height;
        const bool blurs = scene_.render.shutter > 0;
        const double times = !blurs ? 1 : plan.motionSteps > 0 ? plan.motionSteps : scene_.render.motionSteps;
        return time_.build(chosen) +
               frames * (times * time_.update(chosen) + time_.rays(pixels * samplesFor(sampling, noise) * sampling.rays));
    }

    /// The share of the error that models may have for which all takes least time.
    [[nodiscard]] ScenePlan cheapestWithin(float error) const {
        if (findings_.empty()) return planner_.decide(scales_, kShareByBounds * error);
        std::optional<ScenePlan> best;
        for (const float share : kShares) {
            ScenePlan plan = withLimits(planner_.decide(scales_, share * error));
            if (!best || secondsOf(plan, error) < 0.98 * secondsOf(*best, error)) best = std::move(plan);
        }
        return std::move(*best);
    }

    [[nodiscard]] PilotPicture pictureOf(const ScenePlan &plan) const {
        const ScenePlan &full = fullModel();
        const auto isFull = [](const MeshPlan &a, const MeshPlan &b) {
            return a.stretch == b.stretch && a.estimator == b.estimator && a.interpolation == b.interpolation &&
                   a.subdivisionLevel == b.subdivisionLevel;
        };
        if (full_ && plan.motionSteps == 0 && std::equal(plan.meshes.begin(), plan.meshes.end(), full.meshes.begin(), isFull)) {
            full_->setMaterialPlans(plan.materials, plan.details, plan.bearableWaste);
            full_->setFrame(planner_.hardestFrame());
            return picture(*full_, plan.maxEvents);
        }
        RenderScene ready(copyOfScene(), plan, false);
        ready.setFrame(planner_.hardestFrame());
        return picture(ready, plan.maxEvents);
    }

    /// Measures what the chosen models do together. Levels finer than the reference's are held against it at its own, and what the finer
    /// ones leave is predicted.
    void verify(ScenePlan &plan) const {
        const int base = planner_.choosesLevels() ? baseLevel() : 0;
        ScenePlan tried = plan;
        double left = 0;
        for (std::size_t i = 0; i < plan.meshes.size(); ++i) {
            if (!scene_.objects[i].planLevel) continue;
            const int finer = std::max(base, plan.meshes[i].subdivisionLevel);
            tried.meshes[i].subdivisionLevel = std::min(base, plan.meshes[i].subdivisionLevel);
            for (const Question &question : plan.meshes[i].questions)
                for (const Choice &choice : question.choices)
                    if (choice.value == ChoiceValue(SubdivisionLevel{finer})) left += sqr(static_cast<double>(choice.error));
        }
        const Estimate square = squaredDifference(pictureOf(tried), reference_);
        plan.predictedError = static_cast<float>(std::sqrt(std::max(0.0, square.value) + square.spread + left));
    }

    void split(ScenePlan &plan) const {
        ErrorBudget budget;
        budget.error = *options_.error;
        budget.bias = options_.full ? 0 : plan.predictedError;
        const double error = static_cast<double>(budget.error);
        budget.noise = static_cast<float>(std::sqrt(std::max(sqr(error) - sqr(static_cast<double>(budget.bias)), sqr(0.25 * error))));
        if (budget.error >= kCoarse) budget.firstSamples = 2; // it may be all that is needed
        if (!findings_.empty()) {
            budget.samples = static_cast<float>(samplesFor(samplingOf(plan), static_cast<double>(budget.noise)));
            budget.firstSamples = 2;
            while (budget.firstSamples < 16 && static_cast<float>(4 * budget.firstSamples) <= budget.samples) budget.firstSamples *= 2;
        }
        plan.budget = budget;
    }

    const Scene &scene_;
    const PlanOptions &options_;
    ScenePlanner planner_;
    ScenePlan asked_; // by the analysis alone: its questions
    ForeseenTime time_;
    std::vector<Window> windows_;
    mutable std::optional<ScenePlan> fullModel_;
    std::unique_ptr<RenderScene> full_; // where no levels are to be measured
    PilotPicture reference_;
    PlanScales scales_;
    std::optional<Question> events_, motion_;
    std::vector<PilotFinding> findings_; // the reference first
};

} // namespace

PlannedScene planByPilots(const Scene &scene, const PlanOptions &options) {
    return PilotedPlan(scene, options).make();
}

} // namespace taut
