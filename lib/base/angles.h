// Arctangent, sine and cosine with the same bits on every machine: those of the C library depend on the instruction
// set.

#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace betamesh {

inline constexpr double kTwoPi = 2 * std::numbers::pi;  ///< a full turn, radians

/// Angle of (x, y) from the x axis, radians in (-π, π]; 0 at the origin. Absolute error below 3e-16.
///
/// source  Taylor series of the arctangent about the nearest multiple of 1/8
inline double angleOf(double y, double x) {
    constexpr std::array<double, 9> kArctanOfEighths = {0,
                                                        0.12435499454676144,
                                                        0.24497866312686414,
                                                        0.35877067027057225,
                                                        0.46364760900080609,
                                                        0.5585993153435624,
                                                        0.64350110879328437,
                                                        0.71882999962162453,
                                                        0.78539816339744828};
    constexpr double kPi = 3.141592653589793;
    const double ax = std::abs(x), ay = std::abs(y), larger = ax > ay ? ax : ay, smaller = ax > ay ? ay : ax;
    if (!(larger > 0)) return 0;
    const double t = smaller / larger;
    const auto eighths = static_cast<std::size_t>(t * 8 + 0.5);
    const double near = static_cast<double>(eighths) / 8, u = (t - near) / (1 + near * t), s = u * u;
    const double series = u * (1 - s * (1.0 / 3 - s * (1.0 / 5 - s * (1.0 / 7 - s * (1.0 / 9 - s * (1.0 / 11))))));
    double angle = kArctanOfEighths[eighths] + series;
    if (ay > ax) angle = kPi / 2 - angle;
    if (x < 0) angle = kPi - angle;
    return y < 0 ? -angle : angle;
}

struct SineCosine {
    double sine, cosine;
};

/// Sine and cosine of an angle of at most a few turns, radians. Absolute error below 3e-16.
///
/// source  argument reduction of Cody & Waite 1980, then Taylor series
inline SineCosine sineCosine(double angle) {
    constexpr double kQuarterHigh = 1.5707963267341256, kQuarterLow = 6.0771005065061922e-11;  // π/2: 33 bits + rest
    const double quarters = std::floor(angle / kQuarterHigh + 0.5);
    const double x = (angle - quarters * kQuarterHigh) - quarters * kQuarterLow, s = x * x;
    const double sine =
        x *
        (1 - s * (1.0 / 6) *
                 (1 - s * (1.0 / 20) *
                          (1 - s * (1.0 / 42) *
                                   (1 - s * (1.0 / 72) *
                                            (1 - s * (1.0 / 110) * (1 - s * (1.0 / 156) * (1 - s * (1.0 / 210))))))));
    const double cosine =
        1 -
        s * (1.0 / 2) *
            (1 -
             s * (1.0 / 12) *
                 (1 - s * (1.0 / 30) *
                          (1 - s * (1.0 / 56) *
                                   (1 - s * (1.0 / 90) *
                                            (1 - s * (1.0 / 132) * (1 - s * (1.0 / 182) * (1 - s * (1.0 / 240))))))));
    switch (static_cast<long>(quarters) & 3) {
        case 0:
            return {sine, cosine};
        case 1:
            return {cosine, -sine};
        case 2:
            return {-sine, -cosine};
        default:
            return {-cosine, sine};
    }
}

}  // namespace betamesh
