/// taut farm: scene -> the plan of its rendering by many machines, ready to submit to a scheduler.

#include "commands.h"
#include "farm_job.h"
#include "image_output.h"
#include "render_arguments.h"
#include "resources.h"
#include "this_program.h"

#include "taut/base/file_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>

namespace taut::app {

namespace {

namespace fs = std::filesystem;

struct FarmArguments {
    RenderArguments render;
    bool slurm = false, openjd = false;
    std::string folder;
    int shards = 1;
};

/// Samples that time is asked for where an error decides about them: twice what the pilots foresee; without pilots.
constexpr double kForeseenTwice = 2;
constexpr int kSamplesOfNoForesight = 1024;

/// What every task is told: what the command line was, but for where it is run from.
std::vector<std::string> renderWords(const RenderArguments &a) {
    std::vector<std::string> words{"render", a.scene.scene};
    const auto add = [&](const char *option, const std::string &value) {
        if (!value.empty()) words.insert(words.end(), {option, value});
    };
    for (const std::string &define : a.scene.overrides) add("-D", define);
    add("--frames", a.scene.frames);
    for (const std::string &output : a.outputs) add("-o", output);
    if (a.spp > 0) add("--spp", std::to_string(a.spp));
    add("--time", a.time);
    add("--noise", a.noise.value_or(""));
    if (a.seed) add("--seed", std::to_string(*a.seed));
    if (a.fixedSeed) words.emplace_back("--fixed-seed");
    if (a.noGround) words.emplace_back("--no-ground");
    if (a.independent) words.emplace_back("--independent");
    add("--crop", a.crop);
    for (const std::string &aov : a.aovs) add("--aov", aov);
    if (a.cryptoRanks > 0) add("--crypto-ranks", std::to_string(a.cryptoRanks));
    if (a.model.tolerance) add("--tolerance", fmt::format("{}", *a.model.tolerance));
    if (a.model.error) add("--error", fmt::format("{}", *a.model.error));
    add("--model", a.model.model);
    const std::vector<std::string> image = imageWords(a.image);
    words.insert(words.end(), image.begin(), image.end());
    return words;
}

int farm(FarmArguments &arguments) {
    const auto began = std::chrono::steady_clock::now();
    RenderArguments &render = arguments.render;
    if (arguments.slurm == arguments.openjd) throw InputError("farm: found neither or both of --slurm and --openjd, expected one");
    if (render.outputs.empty()) render.outputs = {"out/####.exr"};
    Scene loaded = sceneOf(render);
    const RenderSettings settings = loaded.render;
    checkOutputs(render.outputs, settings.frames.size());
    imageSettingsOf(render.image, loaded.image, render.outputs); // or says why not
    FrameOptions options = optionsOf(render, settings);
    const FilmContents contents = filmContentsNamed(render.aovs, "--aov");
    options.aovs = contents.aovs;
    options.layers = contents.layers;
    render.shard = fmt::format("1/{}", arguments.shards);
    const std::optional<Shard> shard = shardOf(render, options, 1);
    const bool byRows = shard->by == ShardBy::Rows;
    optionsOfPart(options, {byRows ? SplitBy::Rows : SplitBy::Samples, 1, arguments.shards}, settings); // or says why not

    fixTolerance(render, options);
    PlannedScene planned = planFor(loaded, render.model);
    if (const std::optional<ErrorBudget> &budget = planned.plan.budget) // how many samples a frame will take is foreseen at best
        options.spp =
            std::min(options.spp, budget->samples > 0 ? static_cast<int>(std::ceil(kForeseenTwice * static_cast<double>(budget->samples)))
                                                      : kSamplesOfNoForesight);
    RenderScene ready(std::move(loaded), std::move(planned.plan), settings.frames.size() > 1, std::move(planned.surfaces));
    const Resources resources = measureResources(ready, options, began);

    FarmJob job;
    job.name = fs::path(render.scene.scene).stem().string();
    job.folder = fs::current_path().string();
    job.program = thisProgram().string();
    job.render = renderWords(render);
    job.outputs = render.outputs;
    job.shardBy = byRows ? "rows" : "samples";
    job.frames = settings.frames;
    job.shards = arguments.shards;
    job.threads = render.scene.threads > 0 ? render.scene.threads : 1;
    job.megabytes = resources.megabytes;
    job.taskSeconds = resources.serialSeconds + resources.updateSeconds + resources.frameSeconds / arguments.shards / job.threads;
    job.checkpoint = render.checkpoint.empty() ? "5m" : render.checkpoint;
    for (const FarmFile &file : arguments.slurm ? slurmFiles(job) : openJobDescriptionFiles(job)) {
        const std::string path = (fs::path(arguments.folder) / file.name).string();
        makeFolderOf(path);
        writeFileWhole(path, file.text);
        if (file.isProgram)
            fs::permissions(path, fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec, fs::perm_options::add);
        fmt::print("{}\n", path);
    }
    if (!render.quiet)
        fmt::print(stderr, "{} tasks of about {:.3g} s and {:.0f} MB with {} threads each\n",
                   job.frames.size() * static_cast<std::size_t>(job.shards), job.taskSeconds, job.megabytes, job.threads);
    return 0;
}

} // namespace

void addFarm(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<FarmArguments>();
    CLI::App *command = parent.add_subcommand("farm", "Write a job for a scheduler: frames, shards and their merge");
    RenderArguments &render = arguments->render;
    addSceneArguments(*command, render.scene);
    addModelArguments(*command, render.model);
    addSampleArguments(*command, render);
    addImageArguments(*command, render.image);
    command->add_flag("--slurm", arguments->slurm, "Scripts for Slurm: DIR/submit.sh submits them");
    command->add_flag("--openjd", arguments->openjd, "A job template of Open Job Description 2023-09: DIR/template.json");
    command->add_option("-o,--output", arguments->folder, "Folder for the scripts")->required();
    command->add_option("--image", render.outputs, "Images: out/####.exr or .png; may be given more than once")->allow_extra_args(false);
    command->add_option("--shards", arguments->shards, "Shards of each frame (default: 1)")->check(CLI::Range(1, 1000000));
    command->add_option("--shard-by", render.shardBy, "samples, rows or auto (default: auto)");
    command->add_option("--checkpoint", render.checkpoint, "How often each task keeps what it has (default: 5m)");
    command->add_flag("-q,--quiet", render.quiet, "Print the names of the files only");
    command->callback([&run, arguments] { run = [arguments] { return farm(*arguments); }; });
}

} // namespace taut::app
