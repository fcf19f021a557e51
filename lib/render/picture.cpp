
#include "render/picture.h"

#include "base/parallel.h"

#include <algorithm>
#include <cmath>

namespace betamesh {
namespace {

constexpr float kBackground = 0.84f;

std::uint8_t byteOf(float value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255)); }

/// Converts linear light to sRGB bytes by a table, accurate to one step of 8 bits.
class SrgbTable {
public:
    SrgbTable() {
        for (std::size_t i = 0; i < table_.size(); ++i)
            table_[i] = byteOf(srgbOf(static_cast<float>(i) / static_cast<float>(table_.size() - 1)));
    }
    std::uint8_t operator()(float linear) const {
        const float at = std::clamp(linear, 0.0f, 1.0f) * static_cast<float>(table_.size() - 1);
        return table_[static_cast<std::size_t>(at + 0.5f)];
    }

private:
    std::array<std::uint8_t, 16384> table_{};
};

const SrgbTable& srgbTable() {
    static const SrgbTable table;
    return table;
}

}  // namespace

float linearOf(float srgb) { return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f); }

float srgbOf(float linear) {
    return linear <= 0.0031308f ? linear * 12.92f : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

Image toneMapped(const Picture& picture) {
    Image image(picture.width, picture.height, {});
    const SrgbTable& bytes = srgbTable();
    parallelFor(picture.size(), 16384, [&](std::size_t i) {
        const float back = kBackground * (1 - picture.shadow[i]) * (1 - picture.alpha[i]);
        image.pixel[i] = {bytes(picture.red[i] + back), bytes(picture.green[i] + back), bytes(picture.blue[i] + back)};
    });
    return image;
}

Image shrunk(const Image& image, int width, int height) {
    std::array<float, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = linearOf(static_cast<float>(i) / 255);
    Image small(width, height, {});
    const double across = static_cast<double>(image.width) / width, down = static_cast<double>(image.height) / height;
    for (int y = 0; y < height; ++y) {
        const int top = static_cast<int>(y * down), bottom = std::max(top + 1, static_cast<int>((y + 1) * down));
        for (int x = 0; x < width; ++x) {
            const int left = static_cast<int>(x * across),
                      right = std::max(left + 1, static_cast<int>((x + 1) * across));
            std::array<float, 3> sum{};
            for (int v = top; v < bottom; ++v)
                for (int u = left; u < right; ++u)
                    for (std::size_t c = 0; c < 3; ++c) sum[c] += linear[image.at(u, v)[c]];
            const auto count = static_cast<float>((bottom - top) * (right - left));
            for (std::size_t c = 0; c < 3; ++c) small.at(x, y)[c] = srgbTable()(sum[c] / count);
        }
    }
    return small;
}

void paste(const Image& from, int x, int y, Image& to) {
    for (int v = std::max(0, -y); v < std::min(from.height, to.height - y); ++v)
        for (int u = std::max(0, -x); u < std::min(from.width, to.width - x); ++u) to.at(x + u, y + v) = from.at(u, v);
}

}  // namespace betamesh
