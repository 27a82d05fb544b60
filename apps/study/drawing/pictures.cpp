#include "study/drawing/pictures.h"

#include "taut/render/image_file.h"

#include <algorithm>
#include <cmath>

namespace taut::chart {

float exposureOf(const Pixels &image) {
    std::vector<float> greatest;
    for (std::size_t i = 0; i + 2 < image.size(); i += 3) greatest.push_back(std::max({image[i], image[i + 1], image[i + 2]}));
    const auto at = greatest.begin() + static_cast<std::ptrdiff_t>(greatest.size() * 99 / 100);
    std::nth_element(greatest.begin(), at, greatest.end());
    return *at > 0 ? 1 / *at : 1.0F;
}

Pixels difference(const Pixels &a, const Pixels &b, float gain) {
    Pixels out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = gain * std::fabs(a[i] - b[i]);
    return out;
}

Pixels blockMeans(const Pixels &image, int width, int size) {
    const auto w = static_cast<std::size_t>(width);
    const auto s = static_cast<std::size_t>(size);
    const std::size_t columns = w / s;
    const std::size_t rows = image.size() / 3 / w / s;
    Pixels out(3 * columns * rows);
    for (std::size_t y = 0; y < rows * s; ++y)
        for (std::size_t x = 0; x < columns * s; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                out[3 * (y / s * columns + x / s) + c] += image[3 * (y * w + x) + c] / static_cast<float>(s * s);
    return out;
}

Picture writeStrip(const std::filesystem::path &directory, const std::string &name, const std::string &caption,
                   const std::vector<Pixels> &images, int width, float exposure, int zoom) {
    constexpr int kGap = 6;
    const int height = static_cast<int>(images[0].size()) / 3 / width;
    const int count = static_cast<int>(images.size());
    Image image;
    image.width = count * width * zoom + (count - 1) * kGap;
    image.height = height * zoom;
    image.window = {0, 0, image.width, image.height};
    image.channels = {"R", "G", "B"};
    image.values.assign(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 1.0F);
    for (int tile = 0; tile < count; ++tile)
        for (int y = 0; y < height * zoom; ++y)
            for (int x = 0; x < width * zoom; ++x) {
                const auto from = static_cast<std::size_t>(3 * (y / zoom * width + x / zoom));
                const auto to = static_cast<std::size_t>(3 * (y * image.width + tile * (width * zoom + kGap) + x));
                for (std::size_t c = 0; c < 3; ++c) image.values[to + c] = exposure * images[static_cast<std::size_t>(tile)][from + c];
            }
    const std::filesystem::path file = directory / (name + ".png");
    writeImage(file.string(), image, {{"taut:scale", std::to_string(exposure)}});
    return {caption, file};
}

} // namespace taut::chart
