
#include "render/text.h"

#include "betamesh/error.h"

#include <freetype/freetype.h>

#include <cmath>

namespace betamesh {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

struct Font {
    FT_Library library = nullptr;
    FT_Face face = nullptr;

    explicit Font(int size) {
        if (FT_Init_FreeType(&library) != 0 || FT_New_Face(library, kFont, 0, &face) != 0) {
            FT_Done_FreeType(library);
            throw Error(std::string(kFont) + ": the font for captions cannot be read. Install fonts-dejavu-core.");
        }
        FT_Set_Pixel_Sizes(face, 0, static_cast<FT_UInt>(size));
    }
    ~Font() { FT_Done_FreeType(library); }  // frees its faces, too
    Font(const Font&) = delete;
    Font& operator=(const Font&) = delete;
};

/// cover: fraction of the pixel that gets the colour, 0 to 1.
void blend(Colour& pixel, const Colour& colour, float cover) {
    for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(
            std::lround(static_cast<float>(pixel[c]) * (1 - cover) + static_cast<float>(colour[c]) * cover));
}

void drawGlyph(Image& image, int left, int top, const FT_Bitmap& glyph, const Colour& colour) {
    for (int v = 0; v < static_cast<int>(glyph.rows); ++v)
        for (int u = 0; u < static_cast<int>(glyph.width); ++u) {
            const int x = left + u, y = top + v;
            if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
            blend(image.at(x, y), colour, static_cast<float>(glyph.buffer[v * glyph.pitch + u]) / 255);
        }
}

}  // namespace

int writeText(Image& image, int x, int y, int size, const std::string& text, const Colour& colour) {
    const Font font(size);
    int pen = x;
    for (const char c : text) {
        if (FT_Load_Char(font.face, static_cast<unsigned char>(c), FT_LOAD_RENDER) != 0) continue;
        const FT_GlyphSlot glyph = font.face->glyph;
        drawGlyph(image, pen + glyph->bitmap_left, y - glyph->bitmap_top, glyph->bitmap, colour);
        pen += static_cast<int>(glyph->advance.x >> 6);
    }
    return pen - x;
}

}  // namespace betamesh
