// The whole public interface of the core library. Data are structs of arrays: Particles, Mesh, Spheres, Curves.
// Functions go from data to new data, without state between calls, and may be called from several threads at once:
//
// - skinFrame() computes the surface of one frame of particles, with the parameters in SkinParams;
// - skinPlane() does so in two dimensions;
// - simplified() leaves out triangles where a surface is flat;
// - checkMesh() and checkCurves() validate a surface, measureMesh() and measureCurves() measure a valid one;
// - surfaceDistance() and particleMotion() measure what moves from frame to frame.
//
// Lengths are in world units and times in seconds unless the name says otherwise. What a user can cause throws Error.

#pragma once

#include "betamesh/check.h"
#include "betamesh/coherence.h"
#include "betamesh/curves.h"
#include "betamesh/error.h"
#include "betamesh/mesh.h"
#include "betamesh/particles.h"
#include "betamesh/simplify.h"
#include "betamesh/skin.h"
#include "betamesh/skin_params.h"
#include "betamesh/vec3.h"
#include "betamesh/version.h"
