// The light of the studio and what a wet surface makes of it.

#pragma once

#include "render/camera.h"
#include "render/render_settings.h"

namespace betamesh {

/// Directions are unit vectors towards the lights. They turn with the camera, so that every view is lit alike.
struct Lights {
    Vec3f up, key, rim;
    Vec3f bright;         ///< towards the brightest side of the room
    Vec3f key_across[2];  ///< span the disc that the key light is, seen from the surface
};

Lights studioLights(const View& view, const Vec3& up);

/// Linear light from a point of a surface towards the eye, by where it comes from.
struct ShadedLight {
    Vec3f always{0, 0, 0};  ///< what nothing can hide
    Vec3f key{0, 0, 0};     ///< by the key light, where all of it arrives
    Vec3f sky{0, 0, 0};     ///< by the room, where all of its light arrives
};

/// normal and to_eye are unit vectors; normal faces the eye.
ShadedLight shadedLight(const Vec3f& normal, const Vec3f& to_eye, const Vec3f& colour, const Lights& lights,
                        Shading shading);

}  // namespace betamesh
