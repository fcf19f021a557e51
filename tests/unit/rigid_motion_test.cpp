#include "core/rigid_motion.h"

#include "core/random.h"

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
        EXPECT_LE((fit.spin() - spin).length(), 1e-8 * (1 + drift));
        EXPECT_LE((fit.velocityAt(Vec3(1, 2, 3)) - velocity - cross(spin, Vec3(1, 2, 3))).length(), 1e-8 * (1 + drift));
        EXPECT_NEAR(fit.rigidity(fit.spin()), 1, 1e-8 * (1 + drift));
    }
}

TEST(RigidMotionFit, RigidityIsTheShareOfTheMotionThatIsRigid) {
    RigidMotionFit turning, growing, both;
    for (const Vec3& x : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)}) {
        const Vec3 turn = cross(Vec3(0, 0, 2), x);
        turning.add(x, turn, 1);
        growing.add(x, x * 2, 1);
        both.add(x, turn + x * 2, 1);
    }
    EXPECT_NEAR(turning.rigidity(turning.spin()), 1, 1e-8);
    EXPECT_NEAR(growing.rigidity(growing.spin()), 0, 1e-8);
    EXPECT_NEAR(both.rigidity(both.spin()), 0.5, 1e-8);
    EXPECT_EQ(RigidMotionFit().rigidity(Vec3(0)), 1);
}

TEST(RigidMotionFit, ManyPointsAtOnceGiveWhatOneByOneDoes) {
    Random random(2);
    constexpr double kReach = 0.7;
    for (int count = 1; count < 40; ++count) {
        const Moving centre{random.cube(), random.cube()};
        MovingColumns columns;
        RigidMotionFit one_by_one;
        one_by_one.add(Vec3(0), centre.velocity, 1);
        columns.add(centre);
        for (int i = 0; i < count; ++i) {
            const Moving point{random.cube(), random.cube()};
            columns.add(point);
            const Vec3 offset = point.position - centre.position;
            const double near = 1 - offset.length2() / (kReach * kReach);
            if (near > 0) one_by_one.add(offset, point.velocity, near * near);
        }
        columns.fillUp(Vec3(100));
        const RigidMotionFit at_once(columns, centre, kReach);
        const Vec3 spin = one_by_one.spin();
        EXPECT_LE((at_once.spin() - spin).length(), 1e-6 * (1 + spin.length())) << count;
        EXPECT_LE((at_once.velocityAt(Vec3(1)) - one_by_one.velocityAt(Vec3(1))).length(), 1e-6 * (1 + spin.length()));
        EXPECT_NEAR(at_once.rigidity(spin), one_by_one.rigidity(spin), 1e-6);
    }
}

TEST(RigidMotionFit, APairDoesNotTurnAboutItsLineHoweverLittleOneWeighs) {
    Random random(3);
    for (const double short_of : {0.5, 1e-2, 1e-3, 1e-5}) {
        const Moving centre{random.cube(), random.cube()};
        const Vec3 along = random.cube().normalized();
        MovingColumns columns;
        columns.add(centre);
        columns.add({centre.position + along * (1 - short_of), random.cube()});
        columns.fillUp(Vec3(100));
        const Vec3 spin = RigidMotionFit(columns, centre, 1).spin();
        EXPECT_LE(std::abs(dot(spin, along)), 1e-5 * spin.length()) << short_of;
    }
}

}  // namespace betamesh
