
#include "mesh/components.h"

#include "base/index.h"
#include "base/union_find.h"

namespace betamesh {

Components componentsOf(std::size_t vertices, std::span<const Triangle> triangles) {
    UnionFind groups(vertices);
    std::vector<std::uint8_t> used(vertices, 0);
    for (const Triangle& t : triangles) {
        for (const std::uint32_t v : t) used[v] = 1;
        groups.join(t[0], t[1]);
        groups.join(t[1], t[2]);
    }
    Components components{std::vector<std::uint32_t>(vertices, kInvalidIndex), 0};
    for (std::uint32_t v = 0; v < vertices; ++v) {
        if (!used[v]) continue;
        const std::uint32_t first = groups.find(v);  // the smallest of its group
        components.of_vertex[v] = first == v ? components.count++ : components.of_vertex[first];
    }
    return components;
}

}  // namespace betamesh
