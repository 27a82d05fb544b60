#pragma once
/// An animation as a job of a scheduler: its frames, split further into shards, and the merging of these.

#include <string>
#include <vector>

namespace taut::app {

struct FarmJob {
    std::string name;
    std::string folder;               ///< of the whole job: paths in it start here
    std::string program;              ///< taut, absolute
    std::vector<std::string> render;  ///< arguments of every task: render SCENE ..., without frame and shard
    std::vector<std::string> outputs; ///< patterns of images
    std::string shardBy;              ///< samples or rows
    std::vector<int> frames;
    int shards = 1; ///< of each frame
    int threads = 1;
    double megabytes = 0;
    double taskSeconds = 0; ///< of one task: one shard of one frame
    std::string checkpoint; ///< how often
};

struct FarmFile {
    std::string name;
    std::string text;
    bool isProgram = false;
};

/// Slurm (22.05 and later): an array over frames and shards, requeued where it is stopped or fails, a merge that waits for it, and
/// submit.sh, which gives both to sbatch.
std::vector<FarmFile> slurmFiles(const FarmJob &job);

/// Open Job Description, 2023-09 (github.com/OpenJobDescription/openjd-specifications): a job template of the same two steps.
std::vector<FarmFile> openJobDescriptionFiles(const FarmJob &job);

} // namespace taut::app
