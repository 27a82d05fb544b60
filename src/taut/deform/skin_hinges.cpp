#include "taut/deform/skin_hinges.h"

#include <algorithm>

namespace taut {

namespace {

/// Drops the elements of a row table but for those of the rows that are wanted.
template <class T> void keepRows(const std::vector<Index> &offsets, const std::vector<unsigned char> &wanted, std::vector<T> &elements) {
    std::size_t end = 0;
    for (std::size_t row = 0; row < wanted.size(); ++row)
        for (Index k = offsets[row]; wanted[row] != 0 && k < offsets[row + 1]; ++k) elements[end++] = elements[k];
    elements.resize(end);
}
void keepRows(const std::vector<unsigned char> &wanted, std::vector<Index> &offsets) {
    Index end = 0;
    for (std::size_t row = 0; row < wanted.size(); ++row) {
        const Index count = wanted[row] != 0 ? offsets[row + 1] - offsets[row] : 0;
        offsets[row] = end; // behind where it is read
        end += count;
    }
    offsets.back() = end;
}

float weightOf(const SkinWeights &skin, Index position, Index joint) {
    float sum = 0;
    for (Index i = skin.offsets[position]; i < skin.offsets[position + 1]; ++i)
        if (skin.joints[i] == joint) sum += skin.weights[i];
    return sum;
}

/// The greatest share of its weights that a surface vertex loses to other joints at a neighbour.
float weightJump(const Surface &surface, const SkinWeights &skin, std::size_t s) {
    const Index here = surface.surfacePosition[s];
    float greatest = 0;
    for (Index k = surface.stencilOffsets[s]; k < surface.stencilOffsets[s + 1]; ++k) {
        const Index there = surface.stencilPositions[k];
        float lost = 0;
        for (Index i = skin.offsets[here]; i < skin.offsets[here + 1]; ++i)
            lost += std::max(0.0F, skin.weights[i] - weightOf(skin, there, skin.joints[i]));
        greatest = std::max(greatest, lost);
    }
    return greatest;
}

} // namespace

void findHinges(const SkinWeights &skin, Surface &surface) {
    if (surface.ringOffsets.empty()) return; // a limit surface: stencils are those of a cage
    surface.hinges.resize(surface.normals.size());
    bool any = false;
    for (std::size_t s = 0; s < surface.hinges.size(); ++s) {
        surface.hinges[s] = weightJump(surface, skin, s) > kHingeJump ? 1 : 0;
        any = any || surface.hinges[s] != 0;
    }
    if (!any) surface.hinges = {};
}

void keepHinges(Surface &surface) {
    const std::vector<unsigned char> &wanted = surface.hinges;
    if (!wanted.empty()) {
        keepRows(surface.stencilOffsets, wanted, surface.stencilPositions);
        keepRows(surface.stencilOffsets, wanted, surface.stencilWeights);
        keepRows(wanted, surface.stencilOffsets);
        keepRows(surface.ringOffsets, wanted, surface.ringFaces);
        keepRows(wanted, surface.ringOffsets);
        return;
    }
    surface.stencilOffsets.clear();
    surface.stencilPositions.clear();
    surface.stencilWeights.clear();
    surface.stencilPoints.clear();
    surface.slope.clear();
    surface.ringOffsets.clear();
    surface.ringFaces.clear();
    surface.ringTilts.clear();
}

} // namespace taut
