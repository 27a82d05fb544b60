#pragma once
/// A frame on disk: a checkpoint, to be gone on with, or a shard, to be merged. It says what its picture follows from, so that what
/// is of another scene, version or setting is known and named.
///
/// The file: "taut saved frame 1\n", one line of JSON, what FrameRender::save() writes, the hash of all that (checked_stream.h).

#include "taut/images/image_settings.h"
#include "taut/render/frame_render.h"

#include <string>
#include <utility>
#include <vector>

namespace taut {

/// What the bits of a picture follow from: names and values. Equal facts, equal picture.
using FrameFacts = std::vector<std::pair<std::string, std::string>>;

/// Which part of a frame: number `index` of `count`, by samples or by rows.
enum class SplitBy { Samples, Rows };
struct FramePart {
    SplitBy by = SplitBy::Samples;
    int index = 1; ///< from 1
    int count = 1; ///< 1: the whole frame
    bool operator==(const FramePart &) const = default;
};
std::string textOf(const FramePart &part); // "3 of 8 by samples"

/// The options of a part of the frame that `whole` asks for. Throws InputError where there are fewer samples or rows than parts, or
/// the frame can't be split: a noise level or a time decides about all of its samples together.
FrameOptions optionsOfPart(const FrameOptions &whole, const FramePart &part, const RenderSettings &render);

struct SavedHead {
    FrameFacts facts;
    FramePart part;
    int frame = 1;
    int width = 0, height = 0; ///< of the image, pixels
    Window window;             ///< pixels that are rendered, of all parts together
    Metadata metadata;         ///< of its image, as far as it does not follow from the film
    ImageSettings image;       ///< how that is to be seen and stored; the sums do not depend on it
    bool done = false;
    // So far, over all processes that worked on it.
    double seconds = 0;
    StageTimes times;
    RayCounts counts;
};

/// Facts that files make: the contents of each of Scene::inputs, by its path relative to the scene's folder. Reads them all. Throws
/// InputError where one can't be read.
FrameFacts inputFacts(const Scene &scene);
/// Facts of one frame but for the files: versions, frames, pixels, samples, seed, AOVs.
FrameFacts settingFacts(const Scene &scene, const FrameOptions &whole, int frame);

/// How `found` differs from `expected`, as an error says it: "found version 1, expected 2; ..."; empty where it does not.
std::string differenceOf(const FrameFacts &found, const FrameFacts &expected);

/// Writes beside `path` and renames when it is whole and on the disk. Throws RunError; what was there is then as it was.
void writeSavedFrame(const std::string &path, const SavedHead &head, const FrameRender &frame);

/// Lets `frame` go on where the file stopped; returns its head. Throws InputError where it is damaged or not of the frame of `expected`.
SavedHead resumeSavedFrame(const std::string &path, const SavedHead &expected, FrameRender &frame);

/// The head alone.
SavedHead readSavedHead(const std::string &path);

/// Throws InputError where files are not all shards of one frame, each once: names those that are foreign, doubled, missing or not done.
void checkShards(const std::vector<std::string> &paths);

/// The shards of one frame, merged one after the other: two films in memory. Throws as checkShards() does, and where one is damaged.
struct MergedFrame {
    SavedHead head; ///< with the sums of seconds, times and counts
    Film film;
};
MergedFrame mergeShards(const std::vector<std::string> &paths);

} // namespace taut
