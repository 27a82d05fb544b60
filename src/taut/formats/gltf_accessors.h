#pragma once
/// Typed data of a glTF file: accessors through buffer views into buffers, every range checked before it is read.

#include "taut/formats/gltf_source.h"

#include <span>
#include <string>
#include <vector>

namespace taut {

/// The bytes of a buffer view. `where` names the member that refers to it.
std::span<const unsigned char> gltfBufferView(const GltfSource &source, int view, const std::string &where);

/// An accessor's elements as floats, `components` each (1, 2, 3, 4 or 16): normalised integers become [0, 1] or [-1, 1],
/// other integers their value; sparse values are filled in. Throws InputError where the accessor is of another type, lies
/// outside its buffer or holds a number that is not finite.
std::vector<float> accessorFloats(const GltfSource &source, int accessor, int components, const std::string &where);

/// A scalar or vector accessor of unsigned integers (vertex indices, joints).
std::vector<Index> accessorIndices(const GltfSource &source, int accessor, int components, const std::string &where);

} // namespace taut
