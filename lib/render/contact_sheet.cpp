
#include "render/contact_sheet.h"

#include "render/text.h"

#include <algorithm>

namespace betamesh {
namespace {

constexpr Colour kPaper{255, 255, 255}, kInk{58, 64, 72};
constexpr int kMinTextSize = 11;  // pixels

}  // namespace

Image contactSheet(std::span<const CaptionedImage> images, int columns) {
    if (images.empty()) return {};
    const int width = images[0].image.width, height = images[0].image.height;
    const int side = std::min(width, height);
    const int text = std::max(kMinTextSize, side / 22), gap = std::max(4, side / 36);
    columns = std::min(columns, static_cast<int>(images.size()));
    const int rows = (static_cast<int>(images.size()) + columns - 1) / columns;
    const int cell = height + 2 * text + gap;
    Image sheet(columns * (width + gap) + gap, rows * cell + gap, kPaper);
    for (std::size_t i = 0; i < images.size(); ++i) {
        const int x = gap + static_cast<int>(i) % columns * (width + gap),
                  y = gap + static_cast<int>(i) / columns * cell;
        paste(images[i].image, x, y, sheet);
        writeText(sheet, x + text / 4, y + height + text * 3 / 2, text, images[i].caption, kInk);
    }
    return sheet;
}

}  // namespace betamesh
