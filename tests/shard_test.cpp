// Frames and animations in parts, merged: the same files as in one piece; and what the farm's scripts hold.

#include "cli_fixtures.h"

#include <nlohmann/json.hpp>

#include <regex>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

const Arguments kFrames{"--frames", "1-3", "-D", "render.spp=10", "--aov", "all", "-D", "render.shutter=0.7", "-q"};

/// Renders with these options into the place.
CommandResult renderTo(const Workplace &place, const std::string &output, const Arguments &more) {
    Arguments words{"render", place.scene, "-o", place.path(output)};
    words.insert(words.end(), kFrames.begin(), kFrames.end());
    words.insert(words.end(), more.begin(), more.end());
    return runTaut(words);
}

void renderShards(const Workplace &place, const std::string &output, int count, const Arguments &more = {}) {
    for (int i = 1; i <= count; ++i) {
        Arguments options{"--shard", std::to_string(i) + "/" + std::to_string(count)};
        options.insert(options.end(), more.begin(), more.end());
        requireSuccess(renderTo(place, output, options));
    }
}

void requireSameFrames(const Workplace &place, const std::string &a, const std::string &b) {
    for (const char frame : {'1', '2', '3'}) {
        CAPTURE(frame);
        REQUIRE(readBytes(place.path(a + frame + ".exr")) == readBytes(place.path(b + frame + ".exr")));
    }
}

} // namespace

TEST_CASE("shards by samples, rows and frames merge into the very files of the whole", "[shard]") {
    const Workplace place("shards");
    requireSuccess(renderTo(place, "whole#.exr", {}));
    for (const std::string by : {"samples", "rows"}) {
        const std::string name = by + "#.exr";
        renderShards(place, name, 4, {"--shard-by", by});
        requireSuccess(runTaut({"merge", "-o", place.path(name), "--frames", "1-3", "-q"}));
        requireSameFrames(place, by, "whole");
    }
    // As many shards as rows, or as samples; the merge takes them in any order.
    renderShards(place, "many#.exr", 16, {"--shard-by", "rows", "--only", "2"});
    Arguments merge{"merge", "-o", place.path("many#.exr"), "-o", place.path("many#.png"), "-q", "--remove-shards"};
    for (const int i : {3, 16, 1, 2, 9, 8, 7, 4, 5, 6, 10, 15, 14, 11, 13, 12})
        merge.push_back(place.path("many2.exr." + std::to_string(i) + "-of-16.shard"));
    requireSuccess(runTaut(merge));
    CHECK(readBytes(place.path("many2.exr")) == readBytes(place.path("whole2.exr")));
    CHECK(readImage(place.path("many2.png")).width == 24);
    CHECK(!fs::exists(place.path("many2.exr.1-of-16.shard")));
    // By frames there is nothing to merge.
    renderShards(place, "frames#.exr", 2, {"--shard-by", "frames"});
    requireSameFrames(place, "frames", "whole");
    // Automatic: frames where there are enough, else samples, else rows.
    renderShards(place, "auto#.exr", 3);
    requireSameFrames(place, "auto", "whole");
    renderShards(place, "auto4#.exr", 4);
    CHECK(fs::exists(place.path("auto42.exr.4-of-4.shard")));
    renderShards(place, "auto12#.exr", 12, {"--only", "1"});
    requireSuccess(runTaut({"merge", "-o", place.path("auto12#.exr"), "--frames", "1", "-q"}));
    CHECK(readBytes(place.path("auto121.exr")) == readBytes(place.path("whole1.exr")));
}

TEST_CASE("shards: missing, doubled, foreign, unfinished and damaged ones are named", "[shard]") {
    const Workplace place("named");
    renderShards(place, "a#.exr", 3, {"--shard-by", "samples", "--only", "2"});
    const auto shard = [&](int i) { return place.path("a2.exr." + std::to_string(i) + "-of-3.shard"); };
    const auto refused = [&](const Arguments &shards, const std::string &part) {
        Arguments words{"merge", "-o", place.path("m.exr")};
        words.insert(words.end(), shards.begin(), shards.end());
        checkUsageError(runTaut(words), part);
        CHECK(!fs::exists(place.path("m.exr")));
    };
    refused({shard(1), shard(3)}, "frame 2: found no shard 2 of 3");
    refused({shard(1)}, "found no shard 2,3 of 3");
    fs::copy_file(shard(2), place.path("copy.shard"));
    refused({shard(1), shard(2), shard(3), place.path("copy.shard")},
            "copy.shard: found shard 2 of 3 by samples a second time, as " + shard(2));
    requireSuccess(renderTo(place, "b#.exr", {"--shard", "3/3", "--shard-by", "samples", "--only", "2", "--seed", "7"}));
    refused({shard(1), shard(2), place.path("b2.exr.3-of-3.shard")},
            "b2.exr.3-of-3.shard: found a shard of something else than " + shard(1) + ": found seed");
    requireSuccess(renderTo(place, "c#.exr", {"--shard", "3/3", "--shard-by", "rows", "--only", "2"}));
    refused({shard(1), shard(2), place.path("c2.exr.3-of-3.shard")}, "found shard 3 of 3 by rows beside " + shard(1));
    std::string bytes = readBytes(shard(3));
    bytes[bytes.size() - 100] ^= 1;
    writeBytes(place.path("bad.shard"), bytes);
    refused({shard(1), shard(2), place.path("bad.shard")}, "bad.shard: ");
    refused({place.path("none.shard")}, "none.shard: found a file that can't be read");
    refused({place.scene}, "plate.toml: found a file that is no saved frame");
    REQUIRE(renderTo(place, "d#.exr", {"--shard", "3/3", "--shard-by", "samples", "--only", "2", "--spp", "100000", "--time-limit", "0.1"})
                .exitCode == 75);
    refused({place.path("d2.exr.3-of-3.shard.checkpoint")}, "not done");
    refused({}, "found neither shards nor --frames");
    checkUsageError(runTaut({"merge", "-o", place.path("a#.exr"), "--frames", "2-3"}), "a3.exr: found no shard of frame 3");
}

TEST_CASE("shards: what can't be split says so", "[shard]") {
    const Workplace place("unsplit");
    const auto refused = [&](const Arguments &more, const std::string &part) { checkUsageError(renderTo(place, "a#.exr", more), part); };
    refused({"--shard", "0/3"}, "--shard: found '0/3', expected i/n");
    refused({"--shard", "4/3"}, "found '4/3'");
    refused({"--shard", "1/3x"}, "found '1/3x'");
    refused({"--shard", "third"}, "found 'third'");
    refused({"--shard", "1/11", "--shard-by", "samples"}, "found 10 samples a pixel, expected one a shard");
    refused({"--shard", "1/17", "--shard-by", "rows"}, "found 16 rows of pixels");
    refused({"--shard", "1/2", "--shard-by", "sample"}, "did you mean 'samples'?");
    refused({"--shard", "1/2", "--shard-by", "rows", "--noise", "0.1"}, "--noise");
    refused({"--shard-by", "rows"}, "--shard-by: found no --shard");
    refused({"--only", "4"}, "--only: found frame 4, expected some of the 3 frames from 1 to 3");
    requireSuccess(renderTo(place, "n#.exr", {"--shard", "2/4", "--noise", "0.1", "--spp", "64"})); // whole frames
    CHECK(fs::exists(place.path("n2.exr")));
}

TEST_CASE("shards: frames that are there are left out", "[shard]") {
    const Workplace place("skip");
    requireSuccess(renderTo(place, "a#.exr", {}));
    writeBytes(place.path("a2.exr"), "as it was");
    fs::remove(place.path("a3.exr"));
    const CommandResult result = renderTo(place, "a#.exr", {"--skip-existing"});
    requireSuccess(result);
    CHECK(readBytes(place.path("a2.exr")) == "as it was");
    CHECK(readImage(place.path("a3.exr")).width == 24);
}

namespace {

/// The shape that Open Job Description 2023-09 gives a job template (its sections 1 to 5): names, types, what must be there.
void checkTemplate(const nlohmann::json &job) {
    CHECK(job.at("specificationVersion") == "jobtemplate-2023-09");
    CHECK(job.at("name").get<std::string>().size() <= 128);
    std::set<std::string> steps;
    for (const nlohmann::json &step : job.at("steps")) {
        CHECK(step.at("name").get<std::string>().size() <= 64);
        for (const auto &[key, value] : step.items())
            CHECK(std::set<std::string>{"name", "description", "dependencies", "stepEnvironments", "hostRequirements", "parameterSpace",
                                        "script"}
                      .count(key) == 1);
        for (const nlohmann::json &dependency : step.value("dependencies", nlohmann::json::array()))
            CHECK(steps.count(dependency.at("dependsOn")) == 1);
        CHECK(steps.insert(step["name"]).second);
        for (const nlohmann::json &amount : step.at("hostRequirements").at("amounts")) {
            CHECK(amount.at("name").get<std::string>().rfind("amount.worker.", 0) == 0);
            CHECK(amount.at("min").is_number());
        }
        std::set<std::string> parameters;
        for (const nlohmann::json &parameter : step.at("parameterSpace").at("taskParameterDefinitions")) {
            CHECK(parameter.at("type") == "INT");
            CHECK(std::regex_match(parameter.at("range").get<std::string>(),
                                   std::regex("-?[0-9]+(--?[0-9]+(:[0-9]+)?)?(,-?[0-9]+(--?[0-9]+(:[0-9]+)?)?)*")));
            parameters.insert(parameter.at("name"));
        }
        const nlohmann::json &file = step.at("script").at("embeddedFiles").at(0);
        CHECK(file.at("type") == "TEXT");
        const nlohmann::json &run = step["script"].at("actions").at("onRun");
        CHECK(run.at("args").at(0) == "{{Task.File." + file.at("name").get<std::string>() + "}}");
        CHECK(run.at("cancelation").at("mode") == "NOTIFY_THEN_TERMINATE");
        CHECK(run.at("cancelation").at("notifyPeriodInSeconds").get<int>() <= 600);
        const std::string data = file.at("data");
        const std::regex reference(R"(\{\{Task\.Param\.(\w+)\}\})");
        for (std::sregex_iterator it(data.begin(), data.end(), reference), end; it != end; ++it) CHECK(parameters.count((*it)[1]) == 1);
    }
}

/// Runs every task of a template as a worker would: steps in order, parameters put in.
void runTemplate(const nlohmann::json &job) {
    for (const nlohmann::json &step : job.at("steps")) {
        std::vector<std::string> scripts{step["script"]["embeddedFiles"][0]["data"]};
        for (const nlohmann::json &parameter : step["parameterSpace"]["taskParameterDefinitions"]) {
            std::vector<std::string> next;
            int first = 0;
            int last = 0;
            REQUIRE(std::sscanf(parameter["range"].get<std::string>().c_str(), "%d-%d", &first, &last) == 2);
            const std::string name = "{{Task.Param." + parameter["name"].get<std::string>() + "}}";
            for (const std::string &script : scripts)
                for (int value = first; value <= last; ++value) {
                    std::string text = script;
                    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name))
                        text.replace(at, name.size(), std::to_string(value));
                    next.push_back(text);
                }
            scripts = next;
        }
        for (const std::string &script : scripts) requireSuccess(runProgram({"sh", "-c", script}, 300));
    }
}

} // namespace

TEST_CASE("farm: an Open Job Description template renders the animation, whole frames and shards", "[farm]") {
    const Workplace place("openjd it's");
    requireSuccess(
        runTaut({"render", place.scene, "-o", place.path("whole#.exr"), "--frames", "1-3", "--spp", "8", "--aov", "m,depth", "-q"}));
    for (const std::string shards : {"1", "3"}) {
        const CommandResult written = runTaut({"farm", "plate.toml", "--openjd", "-o", "farm" + shards, "--shards", shards, "--image",
                                               "s" + shards + "_#.exr", "--frames", "1-3", "--spp", "8", "--aov", "m,depth"},
                                              place.folder);
        requireSuccess(written);
        CHECK(written.out == "farm" + shards + "/template.json\n");
        const nlohmann::json job = nlohmann::json::parse(readBytes(place.path("farm" + shards + "/template.json")));
        checkTemplate(job);
        runTemplate(job);
        requireSameFrames(place, "s" + shards + "_", "whole");
    }
}

TEST_CASE("farm: bad usage is one line", "[farm]") {
    const Workplace place("farm");
    const auto refused = [&](const Arguments &more, const std::string &part) {
        Arguments words{"farm", place.scene, "-o", place.path("farm")};
        words.insert(words.end(), more.begin(), more.end());
        checkUsageError(runTaut(words), part);
        CHECK(!fs::exists(place.path("farm")));
    };
    refused({}, "--slurm and --openjd, expected one");
    refused({"--slurm", "--openjd"}, "--slurm and --openjd, expected one");
    refused({"--slurm", "--shards", "5", "--shard-by", "samples"}, "found 4 samples a pixel");
    refused({"--slurm", "--frames", "1-3", "--image", "a.exr"}, "a frame number");
    refused({"--slurm", "--shards", "2", "--noise", "0.1"}, "--noise");
}
