#pragma once
/// USD as text (.usda): one prim Mesh for each GlossMesh, every attribute of its vertices a primvar with a time sample a frame.
///
/// A .usda holds an attribute's samples together, frames come one after the other: each attribute is spooled to a file of its
/// own beside the output and joined at the end, so memory does not grow with the number of frames.

#include "taut/base/file_bytes.h"
#include "taut/export/gloss_mesh.h"

#include <cstdint>
#include <memory>

namespace taut {

class UsdaWriter {
  public:
    /// Throws RunError where the files cannot be made.
    UsdaWriter(const std::string &path, std::span<const GlossMesh> meshes);
    UsdaWriter(const UsdaWriter &) = delete;
    UsdaWriter &operator=(const UsdaWriter &) = delete;
    ~UsdaWriter();

    /// Adds the time sample of a frame; frames increase. The meshes are the constructor's, at that frame.
    void write(int frame, std::span<const GlossMesh> meshes);
    /// Joins the samples with what does not change over the frames.
    void finish(std::span<const GlossMesh> meshes, double fps);

  private:
    struct Spool;
    /// A part of the spool, bytes.
    struct Passage {
        std::uint64_t begin, end;
    };

    OutputFile out_;
    std::unique_ptr<Spool> spool_;
    std::vector<std::vector<std::vector<Passage>>> samples_; ///< [meshes][attributes][frames]
    std::vector<int> frames_;
};

} // namespace taut
