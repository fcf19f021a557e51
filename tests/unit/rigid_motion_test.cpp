#include "base/rigid_motion.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace betamesh {

TEST(RigidMotionFit, FindsTheMotionOfARigidBodyWhateverItsDrift) {
    Random random(1);
    for (const double drift : {0.0, 1.0, 1e6}) {
        const Vec3 spin = random.cube(), velocity = random.cube() * drift;
        RigidMotionFit fit;
        for (int i = 0; i < 20; ++i) {
            const Vec3 x = random.cube();
            fit.add(x, velocity + cross(spin, x), random.unit());
        }
        EXPECT_LE((fit.angularVelocity() - spin).length(), 1e-8 * (1 + drift));
        EXPECT_LE((fit.velocityAt(Vec3(1, 2, 3)) - velocity - cross(spin, Vec3(1, 2, 3))).length(), 1e-8 * (1 + drift));
    }
}

TEST(RigidMotionFit, APairDoesNotTurnAboutItsLineHoweverLittleOneWeighs) {
    Random random(3);
    for (const double short_of : {0.5, 1e-2, 1e-3, 1e-5}) {
        const DualVec3 centre{random.cube(), random.cube()};
        const Vec3 along = random.cube().normalized();
        RigidMotionFit fit;
        fit.add(centre.position, centre.velocity, 1);
        fit.add(centre.position + along * (1 - short_of), random.cube(), short_of * short_of);
        const Vec3 spin = fit.angularVelocity();
        EXPECT_LE(std::abs(dot(spin, along)), 1e-5 * spin.length()) << short_of;
    }
}

}  // namespace betamesh
