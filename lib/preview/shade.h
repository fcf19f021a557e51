// The light of the studio and what a wet surface makes of it.

#pragma once

#include "preview/camera.h"
#include "preview/look.h"

namespace betamesh {

/// Directions are unit vectors towards the lights. They turn with the camera, so that every view is lit alike.
struct Lights {
    Vec3f up, key, rim;
    Vec3f bright;         ///< towards the brightest side of the room
    Vec3f key_across[2];  ///< span the disc that the key light is, seen from the surface
};

Lights studioLights(const View& view, const Vec3& up);

/// A point of a surface as the light finds it. normal and to_eye are unit vectors; normal faces the eye.
struct Shaded {
    Vec3f normal, to_eye;
    Vec3f colour;
    float key = 1;  ///< share of the key light that arrives
    float sky = 1;  ///< of the room's light
};

/// Linear light towards the eye.
Vec3f shaded(const Shaded& point, const Lights& lights, Shading shading);

}  // namespace betamesh
