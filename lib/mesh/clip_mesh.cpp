#include "mesh/clip_mesh.h"

#include "base/parallel.h"
#include "mesh/mesh_edges.h"
#include "mesh/polygon_triangles.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace betamesh {

namespace {

// A face of the box: what is inside has a coordinate of at most `at` if it is the higher face, of at least `at`
// otherwise.
struct Face {
    int axis;
    bool is_high;
    double at;

    bool isInside(const Vec3& p) const { return is_high ? p[axis] <= at : p[axis] >= at; }
};

double roundedToFloat(double x) {
    const volatile float nearest = static_cast<float>(x);
    return static_cast<double>(nearest);
}

// An edge from a vertex inside to one outside.
struct CutEdge {
    std::uint32_t inside, outside;
    auto operator<=>(const CutEdge&) const = default;
};

// Appends the points in which edges meet a face.
void appendCutVertices(const Face& face, const std::vector<CutEdge>& edges, Mesh& mesh) {
    std::vector<double> share;
    for (const auto& [inside, outside] : edges) {
        const Vec3 a = mesh.position[inside], b = mesh.position[outside];
        share.push_back((face.at - a[face.axis]) / (b[face.axis] - a[face.axis]));
        Vec3 p = a + (b - a) * share.back();
        for (int k = 0; k < 3; ++k) p[k] = a[k] == b[k] ? a[k] : roundedToFloat(p[k]);
        p[face.axis] = face.at;
        mesh.position.push_back(p);
        if (mesh.velocity.empty()) continue;
        const Vec3 from = mesh.velocity[inside], to = mesh.velocity[outside];
        mesh.velocity.push_back(from + (to - from) * share.back());
    }
    for (Attribute& attribute : mesh.attributes)
        for (std::size_t i = 0; i < edges.size(); ++i)
            for (std::size_t k = 0; k < attribute.components; ++k) {
                const std::size_t inside = std::size_t{edges[i].inside} * attribute.components + k,
                                  outside = std::size_t{edges[i].outside} * attribute.components + k;
                if (!attribute.integer.empty())
                    attribute.integer.push_back(attribute.integer[inside]);
                else
                    attribute.real.push_back(attribute.real[inside] +
                                             (attribute.real[outside] - attribute.real[inside]) *
                                                 static_cast<float>(share[i]));
            }
    for (Attribute& attribute : mesh.attributes) {
        if (attribute.name != "N" || attribute.components != 3 || attribute.real.empty()) continue;
        for (std::size_t at = attribute.real.size() - 3 * edges.size(); at < attribute.real.size(); at += 3) {
            Vec3f normal(attribute.real[at], attribute.real[at + 1], attribute.real[at + 2]);
            normal.normalize();
            for (int k = 0; k < 3; ++k) attribute.real[at + static_cast<std::size_t>(k)] = normal[k];
        }
    }
}

// The loops of a permutation of vertices from `first` on.
std::vector<std::vector<std::uint32_t>> loopsOf(const std::vector<std::uint32_t>& next, std::uint32_t first) {
    std::vector<std::vector<std::uint32_t>> loops;
    std::vector<std::uint8_t> is_done(next.size(), 0);
    for (std::uint32_t start = 0; start < next.size(); ++start) {
        if (is_done[start]) continue;
        std::vector<std::uint32_t>& loop = loops.emplace_back();
        for (std::uint32_t i = start; !is_done[i]; i = next[i] - first) {
            is_done[i] = 1;
            loop.push_back(first + i);
        }
    }
    return loops;
}

constexpr std::uint8_t kSurface = 0;  // of triangles that are not on a face of the box

// Coordinates in a face for which counter-clockwise is seen from outside the box, of the vertices from `first` on.
std::vector<PlanePoint> pointsIn(const Face& face, const std::vector<Vec3>& position, std::size_t first) {
    const int u = (face.axis + (face.is_high ? 1 : 2)) % 3, v = (face.axis + (face.is_high ? 2 : 1)) % 3;
    std::vector<PlanePoint> point(position.size());
    for (std::size_t i = first; i < point.size(); ++i) point[i] = {position[i][u], position[i][v]};
    return point;
}

// Removes what is outside of a face and closes the mesh there with triangles that are marked with the number of the
// face in `face_of`, which has a row for each triangle.
void clip(const Face& face, std::uint8_t number, Mesh& mesh, std::vector<std::uint8_t>& face_of) {
    std::vector<std::uint8_t> is_inside(mesh.position.size());
    parallelFor(mesh.position.size(), 8192, [&](std::size_t v) { is_inside[v] = face.isInside(mesh.position[v]); });
    if (std::all_of(is_inside.begin(), is_inside.end(), [](std::uint8_t inside) { return inside != 0; })) return;

    std::vector<CutEdge> edges;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t m = 0; m < 3; ++m)
            if (const std::uint32_t a = t[m], b = t[(m + 1) % 3]; is_inside[a] && !is_inside[b])
                edges.push_back({a, b});
    std::sort(edges.begin(), edges.end());
    const auto first = static_cast<std::uint32_t>(mesh.position.size());
    const auto cutVertex = [&](std::uint32_t inside, std::uint32_t outside) {
        const auto found = std::lower_bound(edges.begin(), edges.end(), CutEdge{inside, outside});
        return first + static_cast<std::uint32_t>(found - edges.begin());
    };
    appendCutVertices(face, edges, mesh);

    std::vector<Triangle> kept;
    std::vector<std::uint8_t> kept_face_of;
    std::vector<std::uint32_t> next(edges.size());  // along the polygons that close the mesh
    for (std::size_t row = 0; row < mesh.triangles.size(); ++row) {
        const Triangle& t = mesh.triangles[row];
        const int inside = is_inside[t[0]] + is_inside[t[1]] + is_inside[t[2]];
        const auto keep = [&](const Triangle& triangle) {
            kept.push_back(triangle);
            kept_face_of.push_back(face_of[row]);
        };
        if (inside == 3) keep(t);
        if (inside == 0 || inside == 3) continue;
        std::size_t m = 0;  // the corner that is alone on its side
        while (is_inside[t[m]] != (inside == 1)) ++m;
        const std::uint32_t a = t[m], b = t[(m + 1) % 3], c = t[(m + 2) % 3];
        if (inside == 1) {
            const std::uint32_t ab = cutVertex(a, b), ac = cutVertex(a, c);
            keep({a, ab, ac});
            next[ac - first] = ab;
        } else {
            const std::uint32_t ba = cutVertex(b, a), ca = cutVertex(c, a);
            keep({ba, b, c});
            keep({ba, c, ca});
            next[ba - first] = ca;
        }
    }
    mesh.triangles = std::move(kept);
    const auto polygons = polygonTriangles(pointsIn(face, mesh.position, first), loopsOf(next, first));
    mesh.triangles.insert(mesh.triangles.end(), polygons.begin(), polygons.end());
    face_of = std::move(kept_face_of);
    face_of.resize(mesh.triangles.size(), number);
}

// Divides the faces of the box anew. What closes the mesh at one face was cut by the faces after it, into slivers that
// rounding can turn over, and with more vertices along the edges of the box than the surface and its corners need.
void retriangulate(const std::vector<Face>& faces, Mesh& mesh, const std::vector<std::uint8_t>& face_of) {
    std::vector<std::uint8_t> at_surface(mesh.position.size(), 0);
    std::vector<std::vector<std::uint8_t>> faces_at(faces.size());  // [face]: does it have the vertex?
    for (auto& has : faces_at) has.resize(mesh.position.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t])
            (face_of[t] == kSurface ? at_surface : faces_at[face_of[t] - 1U])[v] = 1;
    const auto isNeeded = [&](std::uint32_t v) {
        int touched = 0;
        for (const auto& has : faces_at) touched += has[v];
        return at_surface[v] != 0 || touched > 2;
    };
    std::vector<Triangle> triangles;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (face_of[t] == kSurface) triangles.push_back(mesh.triangles[t]);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        std::set<std::pair<std::uint32_t, std::uint32_t>> sides;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t m = 0; face_of[t] == f + 1 && m < 3; ++m) {
                const std::uint32_t a = mesh.triangles[t][m], b = mesh.triangles[t][(m + 1) % 3];
                if (sides.erase({b, a}) == 0) sides.insert({a, b});
            }
        std::map<std::uint32_t, std::uint32_t> next(sides.begin(), sides.end());
        std::vector<std::vector<std::uint32_t>> loops;
        while (!next.empty()) {
            std::vector<std::uint32_t> loop;
            for (auto at = next.begin(); at != next.end();) {
                const std::uint32_t v = at->second;
                if (isNeeded(v)) loop.push_back(v);
                next.erase(at);
                at = next.find(v);
            }
            if (loop.size() > 2) loops.push_back(std::move(loop));
        }
        const auto polygons = polygonTriangles(pointsIn(faces[f], mesh.position, 0), loops);
        triangles.insert(triangles.end(), polygons.begin(), polygons.end());
    }
    mesh.triangles = std::move(triangles);
}

template <typename Value>
void keepRows(const std::vector<std::uint32_t>& rows, std::size_t components, std::vector<Value>& values) {
    if (values.empty()) return;
    std::vector<Value> kept;
    kept.reserve(rows.size() * components);
    for (const std::size_t row : rows)
        for (std::size_t k = 0; k < components; ++k) kept.push_back(values[row * components + k]);
    values = std::move(kept);
}

}  // namespace

Mesh clippedToBox(const Mesh& mesh, const Vec3& low, const Vec3& high) {
    Mesh clipped = mesh;
    std::vector<std::uint8_t> face_of(mesh.triangles.size(), kSurface);
    std::vector<Face> faces;
    for (int axis = 0; axis < 3; ++axis)
        for (const bool is_high : {false, true}) {
            faces.push_back({axis, is_high, is_high ? high[axis] : low[axis]});
            clip(faces.back(), static_cast<std::uint8_t>(faces.size()), clipped, face_of);
        }
    retriangulate(faces, clipped, face_of);
    const std::vector<std::uint32_t> used = verticesOf(clipped.triangles, clipped.position.size());
    std::vector<std::uint32_t> new_row(clipped.position.size());
    for (std::size_t i = 0; i < used.size(); ++i) new_row[used[i]] = static_cast<std::uint32_t>(i);
    for (Triangle& t : clipped.triangles)
        for (std::uint32_t& vertex : t) vertex = new_row[vertex];
    keepRows(used, 1, clipped.position);
    keepRows(used, 1, clipped.velocity);
    for (Attribute& attribute : clipped.attributes) {
        keepRows(used, attribute.components, attribute.real);
        keepRows(used, attribute.components, attribute.integer);
    }
    return clipped;
}

void keepInside(const Vec3& low, const Vec3& high, Spheres& spheres) {
    const auto rows = static_cast<std::uint32_t>(spheres.size());
    const std::vector<std::uint32_t> inside = indicesWhere(rows, [&](std::uint32_t row) {
        const Vec3& p = spheres.position[row];
        return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
    });
    keepRows(inside, 1, spheres.position);
    keepRows(inside, 1, spheres.velocity);
    keepRows(inside, 1, spheres.radius);
    keepRows(inside, 1, spheres.id);
    keepRows(inside, 1, spheres.particle);
}

}  // namespace betamesh
