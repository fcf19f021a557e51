// Comparisons for the tests of file formats.

#pragma once

#include "betamesh/error.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "io/gzip.h"
#include "io/particle_file.h"
#include "support/file_samples.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace betamesh {

inline Bytes gzip(std::span<const std::byte> plain) {
    Bytes packed;
    GzipWriter writer(
        [&](std::span<const std::byte> piece) { packed.insert(packed.end(), piece.begin(), piece.end()); });
    writer.write(plain);
    writer.finish();
    return packed;
}

inline Bytes gunzip(std::span<const std::byte> packed, const std::string& file) {
    Cursor in = gunzipped({packed, file});
    Bytes plain;
    while (!in.peek(1).empty()) {
        const auto piece = std::as_bytes(std::span(in.peek(1)));
        plain.insert(plain.end(), piece.begin(), piece.end());
        in.take(piece.size(), "gzip");
    }
    return plain;
}

inline void expectSame(const std::vector<Attribute>& a, const std::vector<Attribute>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        SCOPED_TRACE(a[i].name);
        EXPECT_EQ(a[i].name, b[i].name);
        EXPECT_EQ(a[i].components, b[i].components);
        EXPECT_EQ(a[i].real, b[i].real);
        EXPECT_EQ(a[i].integer, b[i].integer);
    }
}

inline void expectSame(const Particles& a, const Particles& b) {
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.velocity, b.velocity);
    EXPECT_EQ(a.id, b.id);
    expectSame(a.attributes, b.attributes);
}

inline void expectSame(const Mesh& a, const Mesh& b) {
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.velocity, b.velocity);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.component, b.component);
    expectSame(a.attributes, b.attributes);
}

/// Whether a file name belongs to a format that keeps the order of particles.
inline void expectParticlesComeBack(const std::string& name) {
    const TemporaryFolder folder;
    for (const std::size_t n : {1U, 2U, 1000U})
        for (int mask = 0; mask < 8; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " particles, mask " + std::to_string(mask));
            const Particles particles = sampleParticles(n, mask & 1, mask & 2, mask & 4);
            writeParticles(folder / name, particles);
            expectSame(readParticles(folder / name), particles);
        }
}

/// The message of the Error that an action throws; the test fails if it throws none.
inline std::string errorOf(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    ADD_FAILURE() << "expected an Error";
    return {};
}

inline void expectError(const std::function<void()>& action, const std::vector<std::string>& parts) {
    const std::string text = errorOf(action);
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << text << "\nlacks " << part;
}

/// The particles in these rows.
inline Particles rowsOf(const Particles& particles, const std::vector<std::uint32_t>& rows) {
    Particles some;
    for (const Attribute& a : particles.attributes) some.attributes.push_back({a.name, a.components, {}, {}});
    for (const std::uint32_t row : rows) {
        some.position.push_back(particles.position[row]);
        if (!particles.velocity.empty()) some.velocity.push_back(particles.velocity[row]);
        if (!particles.id.empty()) some.id.push_back(particles.id[row]);
        for (std::size_t a = 0; a < some.attributes.size(); ++a) {
            const Attribute& from = particles.attributes[a];
            for (std::size_t i = row * from.components; i < (row + 1) * from.components; ++i) {
                if (!from.real.empty()) some.attributes[a].real.push_back(from.real[i]);
                if (!from.integer.empty()) some.attributes[a].integer.push_back(from.integer[i]);
            }
        }
    }
    return some;
}

}  // namespace betamesh
