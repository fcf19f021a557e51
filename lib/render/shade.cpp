
#include "render/shade.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace betamesh {
namespace {

const Vec3f kKeyLight(1.15f, 1.10f, 1.02f), kRimLight(0.42f, 0.50f, 0.60f);
// Light of the room from its bright and its dark side.
const Vec3f kSky(0.55f, 0.58f, 0.62f), kFloor(0.22f, 0.21f, 0.20f);
constexpr float kKeyRadius = 0.14f;          // of the key light's disc at unit distance
constexpr float kNormalReflectance = 0.06f;  // at normal incidence; water has 0.02
constexpr float kGloss = 90;                 // exponent of the key light's highlight
constexpr float kHighlight = 0.5f;           // brightness of that highlight
constexpr float kStripes = 18;               // of the zebra, from straight down to straight up

float smoothStep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/// Light of the room from a direction: pale floor, walls that are brighter towards the key light, large softbox
/// overhead.
float roomLight(const Vec3f& direction, const Lights& lights) {
    const float height = direction.dot(lights.up), side = direction.dot(lights.bright);
    return 0.30f + 0.30f * smoothStep(-0.3f, 0.4f, height) + 0.30f * smoothStep(-0.2f, 0.9f, side) +
           0.9f * smoothStep(0.80f, 0.90f, side) + 0.3f * smoothStep(0.80f, 0.92f, height);
}

float raised(float base, int squarings) {  // base^(2^squarings)
    for (int i = 0; i < squarings; ++i) base *= base;
    return base;
}

}  // namespace

Lights studioLights(const View& view, const Vec3& up) {
    const Vec3 level = (view.forward() - up * dot(view.forward(), up)).length() > 1e-6
                           ? (view.forward() - up * dot(view.forward(), up)).normalized()
                           : view.up();
    const Vec3 right = cross(level, up).normalized();
    Lights lights;
    lights.up = Vec3f(up);
    const Vec3 key = (right * -0.75 + up * 0.95 - level * 0.45).normalized();
    lights.key = Vec3f(key);
    lights.bright = Vec3f((right * -0.35 + up - level * 0.35).normalized());
    lights.rim = Vec3f((right * 0.8 + up * 0.35 + level * 0.9).normalized());
    const Vec3 across = cross(key, up).normalized();
    lights.key_across[0] = Vec3f(across) * kKeyRadius;
    lights.key_across[1] = Vec3f(cross(across, key)) * kKeyRadius;
    return lights;
}

ShadedLight shadedLight(const Vec3f& normal, const Vec3f& to_eye, const Vec3f& colour, const Lights& lights,
                        Shading shading) {
    ShadedLight light;
    const float facing = std::max(normal.dot(to_eye), 0.0f);
    const Vec3f reflected = normal * (2 * normal.dot(to_eye)) - to_eye;
    if (shading == Shading::zebra) {
        const float angle = std::acos(std::clamp(reflected.dot(lights.up), -1.0f, 1.0f)) / std::numbers::pi_v<float>;
        const float stripe = smoothStep(-0.25f, 0.25f, std::sin(2 * std::numbers::pi_v<float> * kStripes / 2 * angle));
        const float all = (0.03f + 0.8f * stripe) * (0.55f + 0.45f * facing);
        light.always = Vec3f(all, all, all) * 0.4f;
        light.sky = Vec3f(all, all, all) * 0.6f;
        return light;
    }
    const float grazing = raised(1 - facing, 2) * (1 - facing);
    const float reflectance = kNormalReflectance + (1 - kNormalReflectance) * 0.75f * grazing;
    const Vec3f body = colour * (1 - reflectance);
    const float key = normal.dot(lights.key), rim = std::max(normal.dot(lights.rim), 0.0f);
    const float up = 0.5f + 0.5f * normal.dot(lights.bright), room = roomLight(reflected, lights) * reflectance;
    light.always = body * kRimLight * rim;
    light.sky = body * (kFloor * (1 - up) + kSky * up) + Vec3f(room, room, room);
    if (key <= 0) return light;
    const Vec3f half = (lights.key + to_eye).normalized();
    const float above = std::min(key / kKeyRadius, 1.0f);  // fraction of the light's disc above the horizon
    const float highlight = kHighlight * std::pow(std::max(normal.dot(half), 0.0f), kGloss) * above;
    light.key = body * kKeyLight * key + kKeyLight * highlight;
    return light;
}

}  // namespace betamesh
