
#include "io/svg.h"

#include "base/lower_case.h"
#include "io/encoded_file.h"
#include "io/extension.h"

#include <algorithm>
#include <cstdio>

namespace betamesh {

namespace {

constexpr double kWidth = 1000;        // pixels
constexpr double kMaxHeight = 4000;    // pixels
constexpr double kMargin = 0.25;       // around all discs, radii
constexpr double kMinLineWidth = 1.2;  // pixels

class SvgWriter {
public:
    SvgWriter(ByteWriter& out, const PlaneDrawing& drawing, const PlaneBounds& bounds) : out_(out) {
        low_ = bounds.low, high_ = bounds.high;
        if (bounds == PlaneBounds{}) fitDiscs(drawing);
        const Vec3 size = high_ - low_;
        scale_ = std::min(kWidth / size.x, kMaxHeight / size.y);
        radius_ = drawing.radius * scale_;
        line_ = std::clamp(0.05 * radius_, kMinLineWidth, 3.0);
        const std::string width = pixels(size.x * scale_), height = pixels(size.y * scale_);
        out_.text("<svg xmlns='http://www.w3.org/2000/svg' width='" + width + "' height='" + height +
                  "' viewBox='0 0 " + width + " " + height + "'>\n<rect width='100%' height='100%' fill='white'/>\n");
    }

    void draw(const PlaneDrawing& drawing, Layer layer) {
        switch (layer) {
            case Layer::discs:
                drawDiscs(drawing.particles, radius_, "fill='#dbe9f6'");
                drawDiscs(drawing.apart, radius_,
                          "fill='#dbe9f6' stroke='#7d9bb8' stroke-width='" + pixels(line_) + "'");
                break;
            case Layer::particles:
                drawDiscs(drawing.particles, std::max(0.6, 0.07 * radius_), "fill='#5b6470'");
                break;
            case Layer::alpha:
                drawLines(drawing.alpha, "stroke='#16191d' stroke-width='" + pixels(0.8 * line_) + "'");
                break;
            case Layer::before:
                drawLines(drawing.before, "stroke='#d3222a' stroke-width='" + pixels(0.8 * line_) +
                                              "' stroke-linecap='round' stroke-dasharray='0 " + pixels(3 * line_) +
                                              "'");
                drawVertices(drawing.before, drawing.pure, true);
                break;
            case Layer::beta:
                drawLines(drawing.beta, "stroke='#d3222a' stroke-width='" + pixels(1.3 * line_) + "'");
                break;
            case Layer::vertices:
                drawVertices(drawing.beta, drawing.pure, false);
                break;
        }
    }

    void end() {
        out_.text("</svg>\n");
        out_.flush();
    }

private:
    void fitDiscs(const PlaneDrawing& drawing) {
        if (drawing.particles.empty()) high_ = {1, 1, 0};
        for (std::size_t i = 0; i < drawing.particles.size(); ++i)
            for (int axis = 0; axis < 2; ++axis) {
                const double reach = drawing.radius * (1 + kMargin), at = drawing.particles[i][axis];
                low_[axis] = i == 0 ? at - reach : std::min(low_[axis], at - reach);
                high_[axis] = i == 0 ? at + reach : std::max(high_[axis], at + reach);
            }
    }

    static std::string pixels(double x) {
        char text[32];
        std::snprintf(text, sizeof text, "%.2f", x);
        return text;
    }
    std::string coordinates(const Vec3& p, const char* separator) const {
        return pixels((p.x - low_.x) * scale_) + separator + pixels((high_.y - p.y) * scale_);
    }

    void drawDiscs(const std::vector<Vec3>& centres, double radius, const std::string& style) {
        out_.text("<g " + style + ">\n");
        for (const Vec3& p : centres)
            out_.text("<circle cx='" + coordinates(p, "' cy='") + "' r='" + pixels(radius) + "'/>\n");
        out_.text("</g>\n");
    }

    void drawLines(const Curves& curves, const std::string& style) {
        out_.text("<path fill='none' stroke-linejoin='round' " + style + " d='");
        for (const std::span<const Edge> line : linesOf(curves)) {
            const bool closed = line.front()[0] == line.back()[1];
            out_.text("M" + coordinates(curves.position[line.front()[0]], " "));
            for (const Edge& edge : line.first(line.size() - (closed ? 1 : 0)))
                out_.text("L" + coordinates(curves.position[edge[1]], " "));
            out_.text(closed ? "Z\n" : "\n");
        }
        out_.text("'/>\n");
    }

    void drawVertices(const Curves& curves, const std::vector<std::uint8_t>& pure, bool hollow) {
        for (const int kind : {0, 1}) {
            std::vector<Vec3> chosen;
            for (std::size_t v = 0; v < pure.size(); ++v)
                if (pure[v] == kind) chosen.push_back(curves.position[v]);
            const std::string colour = kind == 1 ? "#d3222a" : "#2456c8";
            const std::string outline = "stroke='" + colour + "' stroke-width='" + pixels(0.7 * line_) + "' fill='";
            drawDiscs(chosen, std::max(1.0, 0.08 * radius_), outline + (hollow ? "white" : colour) + "'");
        }
    }

    ByteWriter& out_;
    Vec3 low_{0, 0, 0}, high_{0, 0, 0};
    double scale_ = 1;   // pixels per world unit
    double radius_ = 0;  // of the discs, pixels
    double line_ = 1;    // pixels
};

}  // namespace

void writeSvg(const std::filesystem::path& path, const PlaneDrawing& drawing, const std::vector<Layer>& layers,
              const PlaneBounds& bounds) {
    writeEncoded(path, [&](ByteWriter& out) {
        SvgWriter svg(out, drawing, bounds);
        for (const Layer layer : layers) svg.draw(drawing, layer);
        svg.end();
    });
}

bool isSvg(const std::filesystem::path& path) { return lowerCase(path.extension().string()) == ".svg"; }

}  // namespace betamesh
