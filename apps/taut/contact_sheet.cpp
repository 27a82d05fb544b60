#include "contact_sheet.h"

#include "dot_letters.h"

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/base/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace taut::app {

namespace {

constexpr float kBackground = 0.02F; // linear: dark, so that pictures stand out
constexpr float kLetters = 0.55F;
constexpr double kAspect = 16.0 / 9;
constexpr int kWideCell = 240; // from here on letters have two pixels a dot

/// Channels of red, green and blue; those of a grey image are one.
std::array<std::size_t, 3> colourChannels(const Image &image, const std::string &path) {
    const auto find = [&](const std::string &name) {
        return std::find(image.channels.begin(), image.channels.end(), name) - image.channels.begin();
    };
    const auto count = static_cast<std::ptrdiff_t>(image.channels.size());
    const std::ptrdiff_t grey = find("Y");
    std::array<std::size_t, 3> at{};
    for (std::size_t c = 0; c < 3; ++c) {
        const std::ptrdiff_t found = find(std::string(1, "RGB"[c]));
        if (found == count && grey == count) failInput({path}, "no channel " + std::string(1, "RGB"[c]), "R, G and B, or Y");
        at[c] = static_cast<std::size_t>(found != count ? found : grey);
    }
    return at;
}

/// What a picture's size is in a cell.
std::pair<int, int> fitted(const SheetPicture &picture, int width, int height) {
    const double scale = std::min({1.0, static_cast<double>(width) / picture.width, static_cast<double>(height) / picture.height});
    const auto scaled = [&](int size) { return std::max(1, static_cast<int>(std::lround(scale * size))); };
    return {scaled(picture.width), scaled(picture.height)};
}

int bestColumns(int count, int cellWidth, int cellHeight) {
    int best = 1;
    double least = std::numeric_limits<double>::infinity();
    for (int columns = 1; columns <= count; ++columns) {
        const int rows = (count + columns - 1) / columns;
        const double aspect = static_cast<double>(columns * cellWidth) / (static_cast<double>(rows) * cellHeight);
        const double off = std::fabs(std::log(aspect / kAspect));
        if (off < least) std::tie(least, best) = std::pair(off, columns);
    }
    return best;
}

float *pixelOf(Image &sheet, int x, int y) {
    return &sheet.values[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(sheet.width) + static_cast<std::size_t>(x))];
}

void draw(const SheetPicture &picture, int x, int y, Image &sheet) {
    const std::size_t row = 3 * static_cast<std::size_t>(picture.width);
    for (int line = 0; line < picture.height; ++line)
        std::copy_n(&picture.rgb[static_cast<std::size_t>(line) * row], row, pixelOf(sheet, x, y + line));
}

/// Centred below a cell; what is too long loses its middle.
void drawLabel(std::string text, int x, int y, const SheetGrid &grid, Image &sheet) {
    const auto most = static_cast<std::size_t>(std::max(1, grid.cellWidth / (kLetterWidth * grid.dot)));
    if (text.size() > most && most > 4) {
        const std::size_t end = (most - 2) / 2;
        text = text.substr(0, most - 2 - end) + ".." + text.substr(text.size() - end);
    }
    text.resize(std::min(text.size(), most));
    const int width = static_cast<int>(text.size()) * kLetterWidth * grid.dot;
    const int left = x + (grid.cellWidth - width) / 2;
    for (int v = 0; v < kLetterHeight * grid.dot; ++v)
        for (int u = 0; u < width; ++u) {
            const int dot = u / grid.dot;
            if (left + u >= sheet.width || !isDot(text[static_cast<std::size_t>(dot / kLetterWidth)], dot % kLetterWidth, v / grid.dot))
                continue;
            std::fill_n(pixelOf(sheet, left + u, y + v), 3, kLetters);
        }
}

} // namespace

SheetGrid gridOf(const std::vector<SheetPicture> &pictures, const SheetLayout &layout) {
    SheetGrid grid;
    grid.gap = layout.gap;
    for (const SheetPicture &picture : pictures) grid.cellWidth = std::max(grid.cellWidth, std::min(picture.width, layout.cellWidth));
    for (const SheetPicture &picture : pictures)
        grid.cellHeight = std::max(grid.cellHeight, fitted(picture, grid.cellWidth, picture.height).second);
    grid.dot = grid.cellWidth >= kWideCell ? 2 : 1;
    if (std::any_of(pictures.begin(), pictures.end(), [](const SheetPicture &picture) { return !picture.label.empty(); }))
        grid.labelHeight = (kLetterHeight + 4) * grid.dot;
    const auto count = static_cast<int>(pictures.size());
    grid.columns =
        layout.columns > 0 ? std::min(layout.columns, count) : bestColumns(count, grid.cellWidth, grid.cellHeight + grid.labelHeight);
    grid.rows = (count + grid.columns - 1) / grid.columns;
    return grid;
}

SheetPicture readSheetPicture(const std::string &path, const ViewTransform &view) {
    const Image image = readImage(path);
    const std::array<std::size_t, 3> at = colourChannels(image, path);
    const bool png = lowerExtension(path) == "png";
    const auto alpha = std::find(image.channels.begin(), image.channels.end(), "A") - image.channels.begin();
    SheetPicture picture;
    picture.width = image.width;
    picture.height = image.height;
    picture.rgb.assign(3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height), 0);
    const std::size_t channels = image.channels.size();
    std::vector<float> row(3 * static_cast<std::size_t>(image.window.width()));
    for (int y = std::max(0, image.window.y0); y < std::min(image.height, image.window.y1); ++y) {
        const std::size_t first = static_cast<std::size_t>(y - image.window.y0) * static_cast<std::size_t>(image.window.width()) * channels;
        for (std::size_t x = 0; x < row.size() / 3; ++x)
            for (std::size_t c = 0; c < 3; ++c) row[3 * x + c] = image.values[first + x * channels + at[c]];
        if (!png) view.apply(row.data(), row.size() / 3);
        for (std::size_t x = 0; x < row.size() / 3; ++x) {
            const int column = image.window.x0 + static_cast<int>(x);
            if (column < 0 || column >= image.width) continue;
            const bool covers = !png || alpha == static_cast<std::ptrdiff_t>(channels);
            const float share = covers ? 1 : image.values[first + x * channels + static_cast<std::size_t>(alpha)];
            for (std::size_t c = 0; c < 3; ++c)
                picture.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(column)) +
                            c] = share * linearFromSrgb(row[3 * x + c]) + (1 - share) * kBackground;
        }
    }
    return picture;
}

SheetPicture reduced(const SheetPicture &picture, int width, int height) {
    if (width == picture.width && height == picture.height) return picture;
    SheetPicture out{width, height, std::vector<float>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
                     picture.label};
    const double sx = static_cast<double>(picture.width) / width, sy = static_cast<double>(picture.height) / height;
    const auto overlap = [](double from, double to, int pixel) {
        return std::min(to, pixel + 1.0) - std::max(from, static_cast<double>(pixel));
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::array<double, 3> sum{};
            for (int v = static_cast<int>(y * sy); v < picture.height && v < (y + 1) * sy; ++v)
                for (int u = static_cast<int>(x * sx); u < picture.width && u < (x + 1) * sx; ++u) {
                    const double share = overlap(x * sx, (x + 1) * sx, u) * overlap(y * sy, (y + 1) * sy, v);
                    const float *from = &picture.rgb[3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(picture.width) +
                                                          static_cast<std::size_t>(u))];
                    for (std::size_t c = 0; c < 3; ++c) sum[c] += share * static_cast<double>(from[c]);
                }
            float *to = &out.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
            for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(sum[c] / (sx * sy));
        }
    return out;
}

Image contactSheet(const std::vector<SheetPicture> &pictures, const SheetGrid &grid) {
    Image sheet;
    sheet.width = grid.width();
    sheet.height = grid.height();
    sheet.window = {0, 0, sheet.width, sheet.height};
    sheet.channels = {"R", "G", "B"};
    sheet.values.assign(3 * static_cast<std::size_t>(sheet.width) * static_cast<std::size_t>(sheet.height), kBackground);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const auto [width, height] = fitted(pictures[i], grid.cellWidth, grid.cellHeight);
        draw(reduced(pictures[i], width, height), grid.x(i) + (grid.cellWidth - width) / 2, grid.y(i) + (grid.cellHeight - height) / 2,
             sheet);
        drawLabel(pictures[i].label, grid.x(i), grid.y(i) + grid.cellHeight + 2 * grid.dot, grid, sheet);
    }
    return sheet;
}

} // namespace taut::app
