// Curve files and SVG drawings.

#include "io/curve_file.h"
#include "io/file_info.h"
#include "io/svg.h"
#include "support/file_checks.h"

namespace betamesh {
namespace {

/// A square that contains a triangle, and an open curve of two edges. All numbers are exact in single precision.
Curves someCurves() {
    Curves curves;
    curves.position = {{0, 0, 0.5}, {4, 0, 0.5}, {4, 4, 0.5}, {0, 4, 0.5},    {1, 1, 0.5},
                       {1, 3, 0.5}, {3, 1, 0.5}, {5, 0, 0.5}, {6, 0.25, 0.5}, {7, 0, 0.5}};
    for (std::size_t i = 0; i < curves.position.size(); ++i)
        curves.velocity.emplace_back(0.25 * static_cast<double>(i), -1, 0);
    curves.edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 4}, {7, 8}, {8, 9}};
    return curves;
}

Curves manyCurves() {
    Curves curves;
    for (std::uint32_t i = 0; i < 70000; ++i) {
        curves.position.emplace_back(i % 300, i / 300, 0);
        curves.velocity.emplace_back(0, 0, 0);
        curves.edges.push_back({i, i % 5 == 4 ? i - 4 : i + 1});
    }
    return curves;
}

TEST(CurveFile, CurvesSurviveARoundTrip) {
    const TemporaryFolder folder;
    for (const Curves& curves : {Curves{}, someCurves(), manyCurves()})
        for (const char* name : {"c.ply", "c.bgeo", "c.bgeo.gz", "c.bgeo.sc", "c.bhclassic", "c.obj"}) {
            SCOPED_TRACE(name);
            writeCurves(folder / name, curves);
            const Curves back = readCurves(folder / name);
            EXPECT_EQ(back.position, curves.position);
            EXPECT_EQ(back.edges, curves.edges);
            if (std::string(name) != "c.obj") {
                EXPECT_EQ(back.velocity, curves.velocity);
            }
        }
}

TEST(CurveFile, FileInfoDistinguishesCurvesFromMeshesAndParticles) {
    const TemporaryFolder folder;
    for (const char* name : {"c.ply", "c.bgeo", "c.obj"}) {
        writeCurves(folder / name, someCurves());
        const FileInfo info = inspectFile(folder / name);
        EXPECT_EQ(info.kind, FileKind::curves) << name;
        EXPECT_EQ(info.edges, 9U) << name;
    }
}

TEST(CurveFile, RejectsInvalidCurvesAndDamagedFiles) {
    const TemporaryFolder folder;
    Curves curves = someCurves();
    curves.edges[2][1] = 10;
    expectError([&] { writeCurves(folder / "c.ply", curves); }, {"c.ply", "edge 2", "vertex 10", "only 10 vertices"});
    expectError([&] { writeCurves(folder / "c.svg", someCurves()); }, {"c.svg", ".ply"});
    write(folder / "d.ply",
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n0 1\n");
    expectError([&] { readCurves(folder / "d.ply"); }, {"d.ply", "edge 0", "vertex 1"});
    write(folder / "d.obj", "v 0 0 0\nl 1 2\n");
    expectError([&] { readCurves(folder / "d.obj"); }, {"d.obj", "vertex 2"});
}

std::size_t count(const std::string& text, const std::string& what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
    return found;
}

TEST(Drawing, DrawsTheRequestedLayersOnly) {
    const TemporaryFolder folder;
    PlaneDrawing drawing;
    drawing.particles = {{0, 0, 0}, {1, 0, 0}, {2, 1, 0}};
    drawing.radius = 1.5;
    drawing.alpha.position = drawing.particles;
    drawing.alpha.edges = {{0, 1}, {1, 0}};
    drawing.before = drawing.beta = someCurves();
    drawing.pure = {1, 0, 1, 0, 1, 1, 1, 1, 1, 1};
    drawing.apart = {{9, 9, 0}};
    const auto drawn = [&](const std::vector<Layer>& layers) {
        writeSvg(folder / "p.svg", drawing, layers);
        const std::string text = contentsOf(folder / "p.svg");
        EXPECT_TRUE(text.starts_with("<svg ") && text.ends_with("</svg>\n"));
        return std::pair(count(text, "<circle"), count(text, "<path"));
    };
    using Counts = std::pair<std::size_t, std::size_t>;
    EXPECT_EQ(drawn({}), Counts(0, 0));
    EXPECT_EQ(drawn({Layer::discs}), Counts(4, 0));
    EXPECT_EQ(drawn({Layer::particles}), Counts(3, 0));
    EXPECT_EQ(drawn({Layer::alpha}), Counts(0, 1));
    EXPECT_EQ(drawn({Layer::before}), Counts(10, 1));
    EXPECT_EQ(drawn({Layer::beta}), Counts(0, 1));
    EXPECT_EQ(drawn({Layer::beta, Layer::vertices}), Counts(10, 1));
    drawing = {};
    EXPECT_EQ(drawn({Layer::discs, Layer::particles, Layer::alpha, Layer::beta}), Counts(0, 2));
}

TEST(Drawing, DrawsTheRequestedBounds) {
    const TemporaryFolder folder;
    PlaneDrawing drawing;
    drawing.particles = {{3, 4, 0}};
    drawing.radius = 1;
    writeSvg(folder / "p.svg", drawing, {Layer::discs}, {{1, 2, 0}, {5, 4, 0}});
    const std::string text = contentsOf(folder / "p.svg");
    EXPECT_NE(text.find("width='1000.00' height='500.00'"), std::string::npos) << text;
    EXPECT_NE(text.find("cx='500.00' cy='0.00' r='250.00'"), std::string::npos) << text;  // y points up
}

}  // namespace
}  // namespace betamesh
