#include "farm_job.h"

#include "json_text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace taut::app {

namespace {

using nlohmann::ordered_json;

/// More than what was measured: other machines are slower, and a task that ends early frees what it does not need.
constexpr double kTimeMargin = 3;
constexpr double kMemoryMargin = 1.5;
constexpr double kLeastMinutes = 10;
constexpr double kLeastMegabytes = 256;
/// Tasks of one array: what Slurm's MaxArraySize allows where nobody changed it. More are done by turns.
constexpr std::size_t kLargestArray = 1000;
/// Before it is killed, seconds: to write a checkpoint.
constexpr int kNotice = 60;
/// How often a task that fails is tried again.
constexpr int kRetries = 3;

int minutesOf(const FarmJob &job) {
    return static_cast<int>(std::ceil(std::max(job.taskSeconds * kTimeMargin / 60, kLeastMinutes)));
}

int megabytesOf(const FarmJob &job) {
    return static_cast<int>(std::ceil(std::max(job.megabytes * kMemoryMargin, kLeastMegabytes)));
}

/// For a shell.
std::string quotedWord(const std::string &word) {
    constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=.,:/@%";
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
    std::string text = "'";
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
}

std::string commandLine(const std::string &program, const std::vector<std::string> &words) {
    std::string line = quotedWord(program);
    for (const std::string &word : words) line += " " + quotedWord(word);
    return line;
}

/// Ranges as they are written for people: 1-5,9.
std::string textOf(const std::vector<int> &frames) {
    std::string text;
    for (std::size_t first = 0, next = 0; first < frames.size(); first = next) {
        for (next = first + 1; next < frames.size() && frames[next] == frames[next - 1] + 1;) ++next;
        text += (text.empty() ? "" : ",") + std::to_string(frames[first]);
        if (next - first > 1) text += "-" + std::to_string(frames[next - 1]);
    }
    return text;
}

/// All that a task is told but for its number. What is finished already is left out, what was begun is gone on with.
std::string taskLine(const FarmJob &job, const std::string &style) {
    std::vector<std::string> words = job.render;
    words.insert(words.end(), {"--threads", std::to_string(job.threads), "--resume", "--skip-existing", "--checkpoint", job.checkpoint,
                               "--progress", style});
    return commandLine(job.program, words);
}

/// The shards of `frames`, put together; of whole frames: whether each is there, else it is rendered.
std::string mergeLine(const FarmJob &job, const std::string &frames) {
    if (job.shards == 1) return taskLine(job, "plain") + " --only " + frames;
    std::vector<std::string> words{"merge", "--skip-existing"};
    for (const std::string &output : job.outputs) words.insert(words.end(), {"-o", output});
    return commandLine(job.program, words) + " --frames " + frames;
}

std::string shardWords(const FarmJob &job, const std::string &number) {
    return job.shards == 1 ? "" : fmt::format(" --shard {}/{} --shard-by {}", number, job.shards, job.shardBy);
}

std::string head(const FarmJob &job, const std::string &step) {
    return fmt::format("#!/bin/bash\n#SBATCH --job-name={}\n#SBATCH --requeue\n#SBATCH --open-mode=append\n"
                       "#SBATCH --cpus-per-task={}\n#SBATCH --mem={}M\n#SBATCH --time={}\n#SBATCH --signal=B:TERM@{}\n"
                       "#SBATCH --kill-on-invalid-dep=yes\n",
                       quotedWord(job.name + "-" + step), job.threads, megabytesOf(job), minutesOf(job), kNotice);
}

std::string framesScript(const FarmJob &job) {
    const std::size_t tasks = job.frames.size() * static_cast<std::size_t>(job.shards);
    const std::size_t size = std::min(tasks, kLargestArray);
    std::string frames;
    for (const int frame : job.frames) frames += (frames.empty() ? "" : " ") + std::to_string(frame);
    return head(job, "frames") + fmt::format("#SBATCH --array=0-{}\n#SBATCH --output=log/%A_%a.log\n", size - 1) +
           fmt::format(R"(
# Task t is frame t / {shards} and shard t % {shards} of it. Exit code 75: stopped, with a checkpoint to go on from.
frames=({frames})
again() {{
    [ "${{SLURM_RESTART_COUNT:-0}}" -lt "$1" ] && scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}"
}}
for ((t = SLURM_ARRAY_TASK_ID; t < {tasks}; t += {size})); do
    {task} --only "${{frames[$((t / {shards}))]}}"{shard} &
    child=$!
    trap 'kill -TERM $child' TERM
    wait $child
    code=$?
    while kill -0 $child 2>/dev/null; do # the signal has ended the wait
        wait $child
        code=$?
    done
    if [ $code -eq 75 ]; then again 1000; exit 75; fi
    if [ $code -eq 2 ]; then exit 2; fi # bad input: no machine will do better
    if [ $code -ne 0 ]; then again {retries}; exit $code; fi
done
)",
                       fmt::arg("shards", job.shards), fmt::arg("frames", frames), fmt::arg("tasks", tasks), fmt::arg("size", size),
                       fmt::arg("task", taskLine(job, "json")),
                       fmt::arg("shard", shardWords(job, "\"$((t % " + std::to_string(job.shards) + " + 1))\"")),
                       fmt::arg("retries", kRetries));
}

} // namespace

std::vector<FarmFile> slurmFiles(const FarmJob &job) {
    const std::string merge = head(job, "merge") + "#SBATCH --output=log/%j.log\n\n" + mergeLine(job, textOf(job.frames)) + "\n";
    const std::string submit = "#!/bin/sh\n# Gives the frames to Slurm, and the merge that waits for them; options go to sbatch.\nset -e\n"
                               "here=$(cd \"$(dirname \"$0\")\" && pwd)\ncd " +
                               quotedWord(job.folder) +
                               "\nmkdir -p log\nframes=$(sbatch --parsable \"$@\" \"$here/frames.sbatch\")\n"
                               "merge=$(sbatch --parsable \"$@\" --dependency=afterok:\"${frames%%;*}\" \"$here/merge.sbatch\")\n"
                               "echo \"frames: job $frames, merge: job $merge\"\n";
    return {{"frames.sbatch", framesScript(job)}, {"merge.sbatch", merge}, {"submit.sh", submit, true}};
}

std::vector<FarmFile> openJobDescriptionFiles(const FarmJob &job) {
    const ordered_json amounts = ordered_json::array(
        {{{"name", "amount.worker.vcpu"}, {"min", job.threads}}, {{"name", "amount.worker.memory"}, {"min", megabytesOf(job)}}});
    const ordered_json frame{{"name", "Frame"}, {"type", "INT"}, {"range", textOf(job.frames)}};
    const auto step = [&](const std::string &name, const std::string &line, ordered_json parameters) {
        const ordered_json script{
            {"embeddedFiles",
             ordered_json::array(
                 {{{"name", "Run"}, {"type", "TEXT"}, {"data", "set -e\ncd " + quotedWord(job.folder) + "\nexec " + line + "\n"}}})},
            {"actions",
             {{"onRun",
               {{"command", "sh"},
                {"args", ordered_json::array({"{{Task.File.Run}}"})},
                {"timeout", minutesOf(job) * 60},
                {"cancelation", {{"mode", "NOTIFY_THEN_TERMINATE"}, {"notifyPeriodInSeconds", kNotice}}}}}}}};
        return ordered_json{{"name", name},
                            {"hostRequirements", {{"amounts", amounts}}},
                            {"parameterSpace", {{"taskParameterDefinitions", std::move(parameters)}}},
                            {"script", script}};
    };
    ordered_json parameters = ordered_json::array({frame});
    if (job.shards > 1) parameters.push_back({{"name", "Shard"}, {"type", "INT"}, {"range", "1-" + std::to_string(job.shards)}});
    const std::string task = taskLine(job, "openjd") + " --only {{Task.Param.Frame}}" + shardWords(job, "{{Task.Param.Shard}}");
    ordered_json steps = ordered_json::array({step("Frames", task, std::move(parameters))});
    if (job.shards > 1) {
        steps.push_back(step("Merge", mergeLine(job, "{{Task.Param.Frame}}"), ordered_json::array({frame})));
        steps.back()["dependencies"] = ordered_json::array({{{"dependsOn", "Frames"}}});
    }
    const ordered_json job_template{{"specificationVersion", "jobtemplate-2023-09"}, {"name", job.name}, {"steps", steps}};
    return {{"template.json", job_template.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n"}};
}

} // namespace taut::app
