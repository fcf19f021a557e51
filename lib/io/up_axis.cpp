
#include "io/up_axis.h"

#include "base/attribute_names.h"
#include "base/lower_case.h"
#include "base/parallel.h"

#include <algorithm>

namespace betamesh {

namespace {

bool isVector(const Attribute& a) { return a.components == 3 && !a.real.empty(); }

/// Rotates `rows` vectors of an up axis y to `up`, or back from z.
template <typename Number>
void turn(Number* vectors, std::size_t rows, UpAxis up) {
    parallelFor(rows, 4096, [&](std::size_t i) {
        Number* v = vectors + 3 * i;
        const Number y = v[1], z = v[2];
        v[1] = up == UpAxis::z ? -z : z;
        v[2] = up == UpAxis::z ? y : -y;
    });
}

template <typename Geometry>
Geometry turned(Geometry geometry, UpAxis up) {
    for (auto* rows : {&geometry.position, &geometry.velocity})
        if (!rows->empty()) turn(&rows->front().x, rows->size(), up);
    for (Attribute& a : geometry.attributes)
        if (isAcceleration(a) || isNormal(a)) turn(a.real.data(), a.real.size() / 3, up);
    return geometry;
}

}  // namespace

bool isAcceleration(const Attribute& attribute) {
    return isVector(attribute) && isAccelerationName(lowerCase(attribute.name));
}

bool isNormal(const Attribute& attribute) { return isVector(attribute) && isNormalName(lowerCase(attribute.name)); }

Particles withZUp(Particles particles) { return turned(std::move(particles), UpAxis::z); }
Mesh withZUp(Mesh mesh) { return turned(std::move(mesh), UpAxis::z); }
Curves withZUp(Curves curves) { return turned(std::move(curves), UpAxis::z); }
Spheres withZUp(Spheres spheres) { return turned(std::move(spheres), UpAxis::z); }

Particles withYUp(Particles particles) { return turned(std::move(particles), UpAxis::y); }
Mesh withYUp(Mesh mesh) { return turned(std::move(mesh), UpAxis::y); }
Curves withYUp(Curves curves) { return turned(std::move(curves), UpAxis::y); }

}  // namespace betamesh
