#pragma once
/// How different two pictures look when one is shown after the other in the same place: FLIP for low dynamic range.
///
/// Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem, Fairchild: FLIP: A Difference Evaluator for Alternating Images (Proc. ACM
/// Comput. Graph. Interact. Tech. 3(2), 2020).

#include <span>
#include <vector>

namespace taut::chart {

/// A monitor 0.7 m wide with 3840 pixels, seen from 0.7 m: the paper's.
inline constexpr double kPixelsADegree = 67.0206;

/// [width x height] in [0, 1], row by row: 0 where nobody sees a difference. `image` and `reference`: [width x height x 3], linear
/// Rec. 709, held at [0, 1].
std::vector<float> flip(std::span<const float> image, std::span<const float> reference, int width, int height,
                        double pixelsADegree = kPixelsADegree);

} // namespace taut::chart
