// Lights and shading: the studio lights, and how a wet surface or zebra stripes reflect them.

#pragma once

#include "render/camera.h"
#include "render/render_settings.h"

namespace betamesh {

/// Unit vectors towards the lights. They are fixed relative to the camera, so that every view is lit alike.
struct Lights {
    Vec3f up, key, rim;
    Vec3f bright;         ///< towards the brightest part of the room
    Vec3f key_across[2];  ///< span the disc of the key light at unit distance
};

Lights studioLights(const View& view, const Vec3& up);

/// Linear light that a surface point sends towards the eye, by light source.
struct ShadedLight {
    Vec3f always{0, 0, 0};  ///< light that is never occluded
    Vec3f key{0, 0, 0};     ///< from the key light, unoccluded
    Vec3f sky{0, 0, 0};     ///< from the room, unoccluded
};

/// normal and to_eye are unit vectors with a positive dot product. colour is linear.
ShadedLight shadedLight(const Vec3f& normal, const Vec3f& to_eye, const Vec3f& colour, const Lights& lights,
                        Shading shading);

}  // namespace betamesh
