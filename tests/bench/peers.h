// Other methods that betamesh is compared with. Each makes a mesh of the same particles.

#pragma once

#include "betamesh/mesh.h"
#include "betamesh/particles.h"

namespace betamesh {

/// The oriented alpha mesh, double-sided where it is thin, from CGAL's alpha shape with fixed alpha.
Mesh cgalFixedAlphaShape(const Particles& particles, double radius);
/// The same from CGAL's Delaunay triangulation on all threads, by classifying each facet.
Mesh cgalDelaunay(const Particles& particles, double radius);
/// The same by the paper's Algorithm 1, which tests every pair of neighbours of every particle, in floating point.
Mesh algorithmOne(const Particles& particles, double radius);
/// OpenVDB's rasterizeSpheres() with this radius, then volumeToMesh().
Mesh openvdbSpheres(const Particles& particles, double radius, double voxel);
/// OpenVDB's rasterizeSmoothSpheres() (Zhu & Bridson 2005), then volumeToMesh().
Mesh openvdbZhuBridson(const Particles& particles, double radius, double search_radius, double voxel);

}  // namespace betamesh
