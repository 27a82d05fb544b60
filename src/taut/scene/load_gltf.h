#pragma once
/// Between the parts that turn a glTF file into a scene. Internal to `scene/`.

#include "taut/scene/load_context.h"

namespace taut {

/// The scene material of a material of the file, made on first use. kNone is glTF's default material.
Index gltfMaterial(LoadContext &context, const GltfFile &file, Index index);

/// What a material of the file emits; nothing where its emissive texture can't be shown.
Emission gltfEmission(LoadContext &context, const GltfFile &file, Index index);

/// All clips of the file that move different channels, as one: where two move the same, the first is taken and the other is left out,
/// which is said. Null where no more than one plays.
std::shared_ptr<const Clip> clipsTogether(const GltfFile &file, Warnings &warnings);

/// What `taut info` tells of a file.
SceneFile summaryOf(const GltfFile &file);

} // namespace taut
