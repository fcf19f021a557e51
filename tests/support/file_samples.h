// Small particles, meshes and byte strings for the tests of file formats.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/bytes.h"
#include "mesh/vertex_normals.h"

#include <functional>
#include <string>
#include <utility>

namespace betamesh {

/// n particles on a bent line, with velocities, ids that use all 32 bits, and attributes of several types and sizes.
inline Particles sampleParticles(std::size_t n, bool velocity, bool id, bool attributes) {
    Particles p;
    Attribute density{"density", 1, {}, {}};
    Attribute colour{"Cd", 3, {}, {}};
    Attribute matrix{"frame", 6, {}, {}};
    Attribute state{"state", 1, {}, {}};
    Attribute cell{"cell", 3, {}, {}};
    for (std::size_t i = 0; i < n; ++i) {
        const auto t = static_cast<float>(i);
        p.position.emplace_back(0.1F * t - 7.7F, 1.0F / (t + 3.0F), -0.013F * t * (i % 2 == 0 ? 1.0F : -1.0F));
        if (velocity) p.velocity.emplace_back(-t, 0.3F * t, 1e-3F * t);
        if (id) p.id.push_back(i == 0 ? 0xfffffff0U : 7 * i + 1);
        density.real.push_back(1000.0F + 0.5F * t);
        for (int k = 0; k < 3; ++k) colour.real.push_back(static_cast<float>(k) / (t + 1.0F));
        for (int k = 0; k < 6; ++k) matrix.real.push_back(t * static_cast<float>(k));
        state.integer.push_back(static_cast<std::int32_t>(i % 5) - 2);
        for (int k = 0; k < 3; ++k) cell.integer.push_back(static_cast<std::int32_t>(i) * 3 - k);
    }
    if (attributes) p.attributes = {density, colour, matrix, state, cell};
    return p;
}

/// A strip of triangles over n vertices.
inline Mesh sampleMesh(std::size_t n, bool velocity, bool attributes) {
    const Particles p = sampleParticles(n, true, false, attributes);
    Mesh mesh;
    for (const Vec3f& x : p.position) mesh.position.emplace_back(x);
    if (velocity)
        for (const Vec3f& v : p.velocity) mesh.velocity.emplace_back(v);
    mesh.attributes = p.attributes;
    for (std::uint32_t i = 0; i + 2 < n; ++i) mesh.triangles.push_back({i, i + 2, i + 1});
    return mesh;
}

/// Component numbers for its triangles, unsorted.
inline Mesh withComponents(Mesh mesh) {
    mesh.component.emplace();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        mesh.component->push_back(static_cast<std::int32_t>((7 * i) % 5));
    return mesh;
}

/// The mesh with the normals that writers compute for it, as its first attribute.
inline Mesh withNormals(Mesh mesh) {
    Attribute normals{"N", 3, {}, {}};
    for (const Vec3& normal :
         vertexNormals(mesh.position.size(), mesh.triangles, [&](std::uint32_t v) { return mesh.position[v]; }))
        for (int k = 0; k < 3; ++k) normals.real.push_back(static_cast<float>(normal[k]));
    mesh.attributes.insert(mesh.attributes.begin(), std::move(normals));
    return mesh;
}

/// The bytes that an encoder writes.
inline Bytes bytesOf(const std::function<void(ByteWriter&)>& encode) {
    Bytes bytes;
    ByteWriter out([&](std::span<const std::byte> piece) { bytes.insert(bytes.end(), piece.begin(), piece.end()); });
    encode(out);
    out.flush();
    return bytes;
}

inline Bytes bytesOf(std::string_view text) {
    const auto raw = std::as_bytes(std::span(text.data(), text.size()));
    return {raw.begin(), raw.end()};
}

/// A string that may contain zero bytes.
template <std::size_t n>
std::string raw(const char (&literal)[n]) {
    return std::string(literal, n - 1);
}

}  // namespace betamesh
