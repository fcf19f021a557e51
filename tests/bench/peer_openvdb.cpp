#include "peers.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/points/PointRasterizeSDF.h>
#include <openvdb/tools/VolumeToMesh.h>

namespace betamesh {

namespace {

openvdb::points::PointDataGrid::Ptr pointsOf(const Particles& particles, double voxel) {
    openvdb::initialize();
    std::vector<openvdb::Vec3s> copies;
    for (const Vec3f& p : particles.position) copies.emplace_back(p.x, p.y, p.z);
    const openvdb::points::PointAttributeVector<openvdb::Vec3s> positions(copies);
    const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
    const auto index = openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(positions, *transform);
    return openvdb::points::createPointDataGrid<openvdb::points::NullCodec, openvdb::points::PointDataGrid>(
        *index, positions, *transform);
}

Mesh meshOf(const openvdb::FloatGrid& surface) {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(surface, points, triangles, quads);
    Mesh mesh;
    for (const openvdb::Vec3s& p : points) mesh.position.emplace_back(p.x(), p.y(), p.z());
    for (const openvdb::Vec3I& t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
    for (const openvdb::Vec4I& q : quads) {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    return mesh;
}

}  // namespace

Mesh openvdbSpheres(const Particles& particles, double radius, double voxel) {
    const auto points = pointsOf(particles, voxel);
    return meshOf(
        *openvdb::points::rasterizeSpheres(*points, radius, openvdb::LEVEL_SET_HALF_WIDTH, points->transform().copy()));
}

Mesh openvdbZhuBridson(const Particles& particles, double radius, double search_radius, double voxel) {
    const auto points = pointsOf(particles, voxel);
    return meshOf(*openvdb::points::rasterizeSmoothSpheres(*points, radius, search_radius,
                                                           openvdb::LEVEL_SET_HALF_WIDTH, points->transform().copy()));
}

}  // namespace betamesh
