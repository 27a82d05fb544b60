#include "lobe_picture.h"

#include "probe_arguments.h"

#include "taut/base/parallel.h"
#include "taut/base/sobol.h"

#include <algorithm>

namespace taut::app {

Vec3 lobeDirection(double column, double row, int width) {
    return directionOf(180 * row / (width / 2), 360 * column / width, "lobe"); // NOLINT: whole pixels high
}

LobePicture lobePicture(const Bsdf &bsdf, const Frame &frame, const LobeQuestion &question) {
    const bool tilted = frame.n != Vec3(0, 0, 1);
    const auto toLocal = [&](const Vec3 &w) { return tilted ? frame.toLocal(w) : w; };
    const ScatteringPoint point(bsdf, toLocal(question.view));
    LobePicture picture;
    picture.width = question.width;
    picture.height = question.width / 2;
    const auto columns = static_cast<std::size_t>(picture.width);
    picture.values.resize(columns * static_cast<std::size_t>(picture.height));
    parallelFor(static_cast<std::size_t>(picture.height), 1, [&](std::size_t row) {
        for (int column = 0; column < picture.width; ++column) {
            const auto at = row * columns + static_cast<std::size_t>(column);
            const std::uint32_t seed = hash(static_cast<std::uint32_t>(at), question.seed);
            double sum = 0;
            for (std::uint32_t i = 0; i < question.samples; ++i) {
                const DVec2 offset(sobol2(i, seed));
                const Vec3 w = lobeDirection(column + offset.x, static_cast<double>(row) + offset.y, picture.width);
                const BsdfEval e = point.evaluate(toLocal(w), walk::numbersOf(hash(i, seed)));
                sum += static_cast<double>(question.pdf ? e.pdf : e.fCos.x);
            }
            picture.values[at] = static_cast<float>(sum / question.samples);
        }
    });
    picture.peak = static_cast<std::size_t>(std::max_element(picture.values.begin(), picture.values.end()) - picture.values.begin());
    for (std::size_t i = 0; i < picture.values.size(); ++i) {
        const auto row = static_cast<double>(i / columns);
        const double band = std::cos(radians(180 * row / picture.height)) - std::cos(radians(180 * (row + 1) / picture.height));
        picture.integral += static_cast<double>(picture.values[i]) * band * radians(360.0 / picture.width);
    }
    return picture;
}

} // namespace taut::app
