// The programs we measure ourselves against: each takes the same particles and makes a mesh.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/particles.h"

namespace betamesh {

/// The alpha mesh, oriented, double-sided where it is thin: alpha shape of CGAL with alpha fixed from the start.
Mesh cgalFixedAlphaShape(const Particles& particles, double radius);
/// The same from a Delaunay triangulation (on all threads) whose facets are judged one by one.
Mesh cgalDelaunay(const Particles& particles, double radius);
/// The same by the paper's Algorithm 1: every pair of neighbours of every particle, in floating point.
Mesh algorithmOne(const Particles& particles, double radius);
/// OpenVDB's rasterizeSpheres of that radius, then volumeToMesh.
Mesh openvdbSpheres(const Particles& particles, double radius, double voxel);
/// OpenVDB's rasterizeSmoothSpheres (Zhu & Bridson 2005), then volumeToMesh.
Mesh openvdbZhuBridson(const Particles& particles, double radius, double search_radius, double voxel);

}  // namespace betamesh
