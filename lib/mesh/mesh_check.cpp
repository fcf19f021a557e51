
#include "betamesh/check.h"

#include "base/chosen_rows.h"
#include "base/index.h"
#include "base/parallel.h"
#include "base/union_find.h"
#include "exact/orientation.h"
#include "mesh/mesh_edges.h"
#include "mesh/mesh_measure.h"
#include "mesh/triangle_contact.h"
#include "mesh/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>

namespace betamesh {

namespace {

constexpr std::size_t kLeavesPerTask = 128;

bool hasMissingVertex(const Triangle& t, std::size_t vertices) { return std::max({t[0], t[1], t[2]}) >= vertices; }
bool hasRepeatedVertex(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// Selected triangles of a mesh with their rows.
struct Selection {
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> row;
};

template <typename Predicate>
Selection select(std::span<const Triangle> triangles, const Predicate& isWanted) {
    Selection selected;
    selected.triangles.reserve(triangles.size());
    selected.row.reserve(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (!isWanted(t)) continue;
        selected.triangles.push_back(triangles[t]);
        selected.row.push_back(t);
    }
    return selected;
}

void countDuplicates(const Selection& valid, MeshCheck& check) {
    struct Corners {
        Triangle sorted;
        std::uint32_t row;
    };
    std::vector<Corners> all(valid.row.size());
    parallelFor(all.size(), 4096, [&](std::size_t t) {
        all[t] = {valid.triangles[t], valid.row[t]};
        std::sort(all[t].sorted.begin(), all[t].sorted.end());
    });
    parallelSort(all, [](const Corners& a, const Corners& b) {
        return a.sorted != b.sorted ? a.sorted < b.sorted : a.row < b.row;
    });
    for (std::size_t i = 1; i < all.size(); ++i)
        if (all[i].sorted == all[i - 1].sorted) check.duplicates.add(all[i].row);
}

// Edge adjacency: counts edges, vertices and components with their faults, and finds the triangle across every side.
class Topology {
public:
    Topology(std::size_t vertices, std::span<const Triangle> triangles, MeshCheck& check)
        : components(componentsOf(vertices, triangles)),
          triangles_(triangles),
          fans_(3 * triangles.size()),
          is_manifold_(components.count, true) {
        check.components.resize(components.count);
        for (std::uint32_t v = 0; v < vertices; ++v) {
            if (components.of_vertex[v] == kInvalidIndex) {
                check.unused_vertices.add(v);
            } else {
                ++check.components[components.of_vertex[v]].vertices;
            }
        }
        for (const Triangle& t : triangles) ++check.components[components.of_vertex[t[0]]].triangles;
        const std::vector<TriangleSide> sides = sortedSides(triangles);
        across = trianglesAcross(sides);
        forEveryEdge(sides, [&](std::span<const TriangleSide> edge) { visit(edge, check); });
        countFans(vertices, check);
        for (std::uint32_t c = 0; c < components.count; ++c) summarize(c, check);
    }

    std::vector<std::uint32_t> across;
    Components components;

private:
    void visit(std::span<const TriangleSide> sides, MeshCheck& check) {
        const std::uint32_t low = sides[0].low, c = components.of_vertex[low];
        ComponentCheck& component = check.components[c];
        ++component.edges;
        std::int64_t surplus = 0;
        for (const TriangleSide& side : sides) {
            surplus += side.direction;
            const auto corners = cornersAt(side), first = cornersAt(sides[0]);
            fans_.join(corners[0], first[0]);
            fans_.join(corners[1], first[1]);
        }
        const bool open = sides.size() % 2 != 0, misoriented = std::abs(surplus) > 1, manifold = sides.size() <= 2;
        if (open) check.open_edges.add(low);
        if (misoriented) check.misoriented_edges.add(low);
        if (!manifold) check.nonmanifold_edges.add(low);
        if (open) component.closed = false;
        if (misoriented || !manifold) is_manifold_[c] = false;
    }

    // The corners of the side's triangle at the low and at the high vertex.
    std::array<std::uint32_t, 2> cornersAt(const TriangleSide& side) const {
        const std::uint32_t from = side.side, to = from % 3 == 2 ? from - 2 : from + 1;
        return side.direction > 0 ? std::array{from, to} : std::array{to, from};
    }

    void countFans(std::size_t vertices, MeshCheck& check) {
        std::vector<std::uint32_t> fan_of(vertices, kInvalidIndex);
        std::vector<bool> several(vertices, false);
        for (std::uint32_t corner = 0; corner < across.size(); ++corner) {
            const std::uint32_t v = triangles_[corner / 3][corner % 3], fan = fans_.find(corner);
            if (fan_of[v] == kInvalidIndex) fan_of[v] = fan;
            if (fan_of[v] != fan) several[v] = true;
        }
        for (std::uint32_t v = 0; v < vertices; ++v) {
            if (!several[v]) continue;
            check.nonmanifold_vertices.add(v);
            is_manifold_[components.of_vertex[v]] = false;
        }
    }

    void summarize(std::uint32_t c, MeshCheck& check) const {
        ComponentCheck& component = check.components[c];
        component.euler = static_cast<std::int64_t>(component.vertices) - static_cast<std::int64_t>(component.edges) +
                          static_cast<std::int64_t>(component.triangles);
        if (component.closed && is_manifold_[c]) component.genus = (2 - component.euler) / 2;
        check.edges += component.edges;
        check.euler += component.euler;
    }

    std::span<const Triangle> triangles_;
    UnionFind fans_;  // of corners 3t + m: corners at one vertex are joined across shared edges
    std::vector<bool> is_manifold_;
};

void measure(const Mesh& mesh, const Selection& solid, const Components& components, MeshCheck& check) {
    if (solid.triangles.empty()) return;
    const Vec3 origin = mesh.position[solid.triangles[0][0]];
    for (const Triangle& t : solid.triangles) {
        ComponentCheck& component = check.components[components.of_vertex[t[0]]];
        const Vec3 a = mesh.position[t[0]] - origin, b = mesh.position[t[1]] - origin, c = mesh.position[t[2]] - origin;
        component.volume += signedVolume(a, b, c);
        component.area += areaOf(a, b, c);
    }
    for (const ComponentCheck& component : check.components) {
        check.volume += component.volume;
        check.area += component.area;
    }
}

// Contacts found by one task, or in all.
struct Contacts {
    FaultCount crossings;
    std::size_t touching = 0, shallow = 0;
    double deepest = 0;
    std::vector<SelfCrossing> listed;  // sorted by depth, deepest first

    void list(const SelfCrossing& crossing, std::size_t examples) {
        const auto before = [](const SelfCrossing& a, const SelfCrossing& b) {
            if (a.depth != b.depth) return a.depth > b.depth;
            return a.first != b.first ? a.first < b.first : a.second < b.second;
        };
        if (listed.size() == examples && (examples == 0 || !before(crossing, listed.back()))) return;
        if (listed.size() == examples) listed.pop_back();
        listed.insert(std::upper_bound(listed.begin(), listed.end(), crossing, before), crossing);
    }
};

// solid: rows of `valid`; valid: rows of the mesh.
void findContacts(const TestedSurface& surface, const Selection& solid, const Selection& valid,
                  const CheckParams& params, MeshCheck& check) {
    const TriangleTree tree(surface.position, solid.triangles);
    std::vector<Contacts> found((tree.leaves() + kLeavesPerTask - 1) / kLeavesPerTask);
    parallelFor(found.size(), 1, [&](std::size_t task) {
        Contacts& contacts = found[task];
        const std::size_t end = std::min(tree.leaves(), (task + 1) * kLeavesPerTask);
        for (std::size_t leaf = task * kLeavesPerTask; leaf < end; ++leaf)
            tree.forPairsOfLeaf(leaf, [&](std::uint32_t s, std::uint32_t t) {
                const Contact contact = contactOf(surface, solid.row[s], solid.row[t]);
                if (contact.kind == ContactKind::none) return;
                if (contact.kind == ContactKind::touching) {
                    ++contacts.touching;
                    return;
                }
                contacts.deepest = std::max(contacts.deepest, contact.depth);
                if (contact.depth < params.tolerance) {
                    ++contacts.shallow;
                    return;
                }
                const std::uint32_t first = valid.row[solid.row[s]], second = valid.row[solid.row[t]];
                contacts.crossings.add(first);
                contacts.list({first, second, contact.position, contact.depth, contact.coplanar}, params.examples);
            });
    });
    Contacts all;
    for (const Contacts& contacts : found) {
        if (contacts.crossings && (!all.crossings || contacts.crossings.first < all.crossings.first))
            all.crossings.first = contacts.crossings.first;
        all.crossings.count += contacts.crossings.count;
        all.touching += contacts.touching;
        all.shallow += contacts.shallow;
        all.deepest = std::max(all.deepest, contacts.deepest);
        for (const SelfCrossing& crossing : contacts.listed) all.list(crossing, params.examples);
    }
    check.crossings = all.crossings;
    check.touching = all.touching;
    check.shallow = all.shallow;
    check.deepest = all.deepest;
    check.deepest_crossings = std::move(all.listed);
}

}  // namespace

MeshCheck checkMesh(const Mesh& mesh, const CheckParams& params) {
    MeshCheck check;
    const std::size_t n = mesh.position.size();
    check.vertices = n;
    check.triangles = mesh.triangles.size();
    for (std::size_t v = 0; v < n; ++v)
        if (!isInRange(mesh.position[v])) check.not_finite.add(v);
    for (std::size_t v = 0; v < mesh.velocity.size(); ++v) {
        const Vec3& u = mesh.velocity[v];
        if (!isFinite(u)) check.velocity_not_finite.add(v);
    }

    const Selection valid = select(mesh.triangles, [&](std::uint32_t row) {
        const Triangle& t = mesh.triangles[row];
        const bool missing = hasMissingVertex(t, n), repeated = hasRepeatedVertex(t);
        if (missing) check.missing_vertices.add(row);
        if (repeated) check.repeated_vertices.add(row);
        return !missing && !repeated;
    });
    countDuplicates(valid, check);
    const Topology topology(n, valid.triangles, check);

    const std::vector<std::uint32_t> first_at = firstVerticesAtPositions(mesh.position);
    for (std::size_t v = 0; v < n; ++v)
        if (first_at[v] != v) check.coincident_vertices.add(v);
    enum Shape : std::uint8_t { not_finite, degenerate, solid };
    std::vector<Shape> shape(valid.row.size());
    parallelFor(shape.size(), 1024, [&](std::size_t i) {
        const Triangle& t = valid.triangles[i];
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        const bool finite = isInRange(a) && isInRange(b) && isInRange(c);
        shape[i] = !finite ? not_finite : areCollinear(a, b, c) ? degenerate : solid;
    });
    for (std::size_t i = 0; i < shape.size(); ++i)
        if (shape[i] == degenerate) check.zero_area.add(valid.row[i]);
    const Selection solids = select(valid.triangles, [&](std::uint32_t i) { return shape[i] == solid; });
    measure(mesh, solids, topology.components, check);
    check.inside_out = check.closed() && !check.misoriented_edges && check.volume < 0;
    findContacts({mesh.position, valid.triangles, first_at, topology.across}, solids, valid, params, check);
    return check;
}

std::vector<std::string_view> faultsOf(const MeshCheck& check, bool strict) {
    std::vector<std::string_view> faults;
    const auto add = [&](bool found, std::string_view name) {
        if (found) faults.push_back(name);
    };
    add(check.not_finite.count > 0, "not_finite");
    add(check.velocity_not_finite.count > 0, "velocity_not_finite");
    add(check.missing_vertices.count > 0, "missing_vertices");
    add(check.repeated_vertices.count > 0, "repeated_vertices");
    add(check.duplicates.count > 0, "duplicates");
    add(check.open_edges.count > 0, "open_edges");
    add(check.misoriented_edges.count > 0, "misoriented_edges");
    add(check.inside_out, "inside_out");
    add(check.nonmanifold_edges.count > 0, "nonmanifold_edges");
    add(check.nonmanifold_vertices.count > 0, "nonmanifold_vertices");
    add(check.crossings.count > 0, "crossings");
    if (!strict) return faults;
    add(check.zero_area.count > 0, "zero_area");
    add(check.unused_vertices.count > 0, "unused_vertices");
    add(check.coincident_vertices.count > 0, "coincident_vertices");
    add(check.touching > 0, "touching");
    return faults;
}

Mesh weldVertices(const Mesh& mesh) {
    const std::size_t n = mesh.position.size();
    const std::vector<std::uint32_t> first_at = firstVerticesAtPositions(mesh.position);
    std::vector<std::uint8_t> is_used(n, 0);
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            if (v < n) is_used[first_at[v]] = 1;
    const std::vector<std::uint32_t> used = indicesWhere(n, [&](std::uint32_t v) { return is_used[v] != 0; });
    std::vector<std::uint32_t> row(n, 0);
    for (std::size_t i = 0; i < used.size(); ++i) row[used[i]] = static_cast<std::uint32_t>(i);
    Mesh welded{chosenRows(mesh.position, used), chosenRows(mesh.velocity, used), {}, {}, {}};
    for (const Attribute& attribute : mesh.attributes) welded.attributes.push_back(chosenRows(attribute, used));
    if (mesh.component) welded.component.emplace();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        Triangle t = mesh.triangles[i];
        const bool invalid = hasMissingVertex(t, n) || hasRepeatedVertex(t);
        for (std::uint32_t& v : t) v = v < n ? row[first_at[v]] : kInvalidIndex;
        if (!invalid && hasRepeatedVertex(t)) continue;
        welded.triangles.push_back(t);
        if (mesh.component) welded.component->push_back((*mesh.component)[i]);
    }
    return welded;
}

}  // namespace betamesh
