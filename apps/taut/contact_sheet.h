#pragma once
/// A contact sheet: pictures side by side in rows, each with its name below it.

#include "taut/images/view_transform.h"
#include "taut/render/image_file.h"

#include <string>
#include <vector>

namespace taut::app {

/// A picture on its way to the sheet: light that the display sends, linear, [0, 1], row by row.
struct SheetPicture {
    int width = 0, height = 0;
    std::vector<float> rgb; ///< [3 x width x height]
    std::string label;      ///< ASCII; empty: none
};

struct SheetLayout {
    int columns = 0;     ///< 0: those that bring the sheet nearest to 16:9
    int cellWidth = 480; ///< pixels; smaller pictures keep their size
    int gap = 12;        ///< pixels between cells, and around them
};

/// Where things are: cells of one size in the order of the pictures, row by row.
struct SheetGrid {
    int columns = 0, rows = 0;
    int cellWidth = 0, cellHeight = 0; ///< without the label
    int gap = 0;
    int dot = 1;         ///< pixels a dot of a letter
    int labelHeight = 0; ///< 0: no picture has a label
    [[nodiscard]] int width() const { return gap + columns * (cellWidth + gap); }
    [[nodiscard]] int height() const { return gap + rows * (cellHeight + labelHeight + gap); }
    [[nodiscard]] int x(std::size_t cell) const {
        return gap + static_cast<int>(cell % static_cast<std::size_t>(columns)) * (cellWidth + gap);
    }
    [[nodiscard]] int y(std::size_t cell) const {
        return gap + static_cast<int>(cell / static_cast<std::size_t>(columns)) * (cellHeight + labelHeight + gap);
    }
};
SheetGrid gridOf(const std::vector<SheetPicture> &pictures, const SheetLayout &layout);

/// A PNG as it is shown, over the sheet's background where it has an alpha; an EXR through the view. Throws InputError.
SheetPicture readSheetPicture(const std::string &path, const ViewTransform &view);

/// The picture made smaller, by the mean light of what each pixel covers.
SheetPicture reduced(const SheetPicture &picture, int width, int height);

/// The sheet, linear. Pictures larger than a cell are reduced into it, smaller ones keep their size; all are centred.
Image contactSheet(const std::vector<SheetPicture> &pictures, const SheetGrid &grid);

} // namespace taut::app
