
#include "betamesh/particles.h"

#include "base/parallel.h"
#include "betamesh/error.h"

namespace betamesh {

namespace {

void requireRows(std::size_t rows, std::size_t expected, const std::string& name) {
    if (rows != expected)
        throw Error("attribute '" + name + "' has " + std::to_string(rows) + " rows; expected one for each of the " +
                    std::to_string(expected) + " particles");
}

}  // namespace

void requireFinite(std::span<const Vec3f> rows, const char* what, std::size_t first_row) {
    const std::size_t i = firstRowWhere(rows.size(), [&](std::size_t row) { return !isFinite(rows[row]); });
    if (i == rows.size()) return;
    throw Error("particle " + std::to_string(first_row + i) + ": " + what + " is (" + std::to_string(rows[i].x) + ", " +
                std::to_string(rows[i].y) + ", " + std::to_string(rows[i].z) + "); expected finite numbers");
}

void validate(const Particles& particles) {
    const std::size_t n = particles.size();
    if (!particles.velocity.empty()) requireRows(particles.velocity.size(), n, "velocity");
    if (!particles.id.empty()) requireRows(particles.id.size(), n, "id");
    for (const Attribute& a : particles.attributes) {
        const std::size_t entries = a.real.size() + a.integer.size();
        requireRows(a.components == 0 ? entries : entries / a.components, n, a.name);
    }
    requireFinite(particles.position, "position", 0);
    requireFinite(particles.velocity, "velocity", 0);
}

}  // namespace betamesh
