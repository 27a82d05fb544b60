#pragma once
/// Typed data of a glTF file: accessors through buffer views into buffers, every range checked before it is read.

#include "taut/formats/gltf_source.h"

#include <span>
#include <vector>

namespace taut {

/// The bytes of the buffer view that `reference` names.
std::span<const unsigned char> gltfBufferView(const GltfSource &source, const GltfValue &reference);

/// The number of elements of the accessor that `reference` names.
std::size_t accessorCount(const GltfSource &source, const GltfValue &reference);

/// The elements of the accessor that `reference` names, as floats, `components` each (1, 2, 3, 4 or 16): normalised integers
/// become [0, 1] or [-1, 1], other integers their value; sparse values are filled in. With `wanted`, increasing numbers below the count,
/// those elements alone. Throws InputError where the accessor is of another type, lies outside its buffer or holds a number that is not
/// finite.
std::vector<float> accessorFloats(const GltfSource &source, const GltfValue &reference, int components,
                                  const std::vector<Index> *wanted = nullptr);

/// A scalar or vector accessor of unsigned integers (vertex indices, joints).
std::vector<Index> accessorIndices(const GltfSource &source, const GltfValue &reference, int components,
                                   const std::vector<Index> *wanted = nullptr);

} // namespace taut
