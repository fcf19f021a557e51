// Dual numbers and vectors: values together with their forward-mode derivatives with respect to time.

#pragma once

#include "betamesh/vec3.h"

#include <algorithm>
#include <cmath>

namespace betamesh {

/// A number and its derivative with respect to time, per second.
struct Dual {
    double value = 0, rate = 0;

    Dual() = default;
    Dual(double constant) : value(constant) {}
    Dual(double number, double per_second) : value(number), rate(per_second) {}

    friend Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.rate + b.rate}; }
    friend Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.rate - b.rate}; }
    friend Dual operator*(Dual a, Dual b) { return {a.value * b.value, a.rate * b.value + a.value * b.rate}; }
    friend Dual operator/(Dual a, Dual b) {
        const double quotient = a.value / b.value;
        return {quotient, (a.rate - quotient * b.rate) / b.value};
    }
};

/// Negative values count as zero; there the derivative, which does not exist, is taken as zero.
inline Dual squareRoot(Dual a) {
    const double value = std::sqrt(std::max(0.0, a.value));
    return {value, value > 0 ? a.rate / (2 * value) : 0};
}

/// Cubic smooth step: 0 for t <= 0, 1 for t >= 1, with zero slope at both ends.
inline Dual smoothStep(Dual t) {
    const double rate = t.value > 0 ? t.rate : 0;
    const Dual part(std::max(0.0, std::min(t.value, 1.0)), t.value < 1 ? rate : 0);
    return part * part * (3 - part * 2);
}

/// A point or vector and its derivative with respect to time, per second.
struct DualVec3 {
    Vec3 position{0, 0, 0}, velocity{0, 0, 0};

    friend DualVec3 operator+(const DualVec3& a, const DualVec3& b) {
        return {a.position + b.position, a.velocity + b.velocity};
    }
    friend DualVec3 operator-(const DualVec3& a, const DualVec3& b) {
        return {a.position - b.position, a.velocity - b.velocity};
    }
    friend DualVec3 operator*(const DualVec3& a, Dual s) {
        return {a.position * s.value, a.velocity * s.value + a.position * s.rate};
    }
    friend DualVec3 operator*(const DualVec3& a, double s) { return {a.position * s, a.velocity * s}; }
    friend DualVec3 operator/(const DualVec3& a, Dual s) { return a * (1 / s); }
};

inline Dual dot(const DualVec3& a, const DualVec3& b) {
    return {dot(a.position, b.position), dot(a.velocity, b.position) + dot(a.position, b.velocity)};
}

inline DualVec3 cross(const DualVec3& a, const DualVec3& b) {
    return {cross(a.position, b.position), cross(a.velocity, b.position) + cross(a.position, b.velocity)};
}

/// At length zero the derivative is taken as zero.
inline Dual length(const DualVec3& a) {
    const double value = a.position.length();
    return {value, value > 0 ? dot(a.position, a.velocity) / value : 0};
}

/// The zero vector gives the zero vector, with derivative zero.
inline DualVec3 normalized(const DualVec3& a) {
    const Dual size = length(a);
    return size.value > 0 ? a / size : DualVec3{};
}

}  // namespace betamesh
