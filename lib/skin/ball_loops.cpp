#include "skin/ball_loops.h"

namespace betamesh {

void BallLoopMaker::makeLoops(std::uint32_t ball, std::uint32_t first_face, std::uint32_t last_face,
                              BallLoops& out) const {
    out.clear();
    for (std::uint32_t f = first_face; f < last_face; ++f) {
        for (const std::uint32_t c : boundary_.face[f]) {
            if (c < boundary_.cycle.size())
                addCycle(ball, boundary_.cycle[c], out);
            else
                addCircle(ball, c - static_cast<std::uint32_t>(boundary_.cycle.size()), out);
            out.loops.loop_begin.push_back(static_cast<std::uint32_t>(out.loops.point.size()));
        }
        out.face_begin.push_back(static_cast<std::uint32_t>(out.loops.is_hole.size()));
    }
}

void BallLoopMaker::add(std::uint32_t ball, std::uint32_t point, std::uint32_t circle_before,
                        std::uint32_t circle_after, BallLoops& out) const {
    const Vec3 offset = network_.point[point].position - boundary_.centre(ball);
    out.loops.point.push_back(onHullGrid(offset / boundary_.worldRadiusOf(ball).value));
    out.loops.circles.push_back({circle_before, circle_after});
    out.network_point.push_back(point);
}

bool BallLoopMaker::isNearlyTangent(std::uint32_t ball, std::uint32_t other) const {
    const Vec3 offset = toDouble(boundary_.position[other] - boundary_.position[ball]);
    const auto own = static_cast<double>(boundary_.radiusOf(ball)), r = static_cast<double>(boundary_.radiusOf(other));
    const double squared = dot(offset, offset), sum = own + r, difference = own - r;
    const bool from_outside = squared > sum * sum * (1 - 1e-12);
    return from_outside || (difference > 0 && squared < difference * difference * (1 + 1e-12));
}

void BallLoopMaker::addCycle(std::uint32_t ball, std::span<const std::uint32_t> cycle, BallLoops& out) const {
    bool hole = true;
    for (const std::uint32_t h : cycle) {
        // the loop arrives along the circle with the triangle's second particle and leaves along that with its third
        const std::uint32_t leaving = previousInTriangle(h), ahead = nextInTriangle(h);
        const std::uint32_t before = boundary_.triangle[h / 3][ahead % 3],
                            after = boundary_.triangle[h / 3][leaving % 3];
        add(ball, h / 3, before, after, out);
        hole = hole && isNearlyTangent(ball, after);
        const std::uint32_t arc = network_.arc_of[leaving], first = network_.arc_begin[arc];
        const std::uint32_t n = network_.arcSize(arc);
        const bool forward = network_.arc_start[arc] == leaving;
        for (std::uint32_t m = 0; m < n; ++m) add(ball, first + (forward ? m : n - 1 - m), after, after, out);
    }
    out.loops.is_hole.push_back(hole);
}

void BallLoopMaker::addCircle(std::uint32_t ball, std::uint32_t circle_side, BallLoops& out) const {
    const std::uint32_t k = circle_side / 2, side = circle_side % 2, n = network_.circleSize(k);
    const std::uint32_t other = boundary_.circle[k][1 - side];
    for (std::uint32_t m = 0; m < n; ++m)
        add(ball, network_.circle_begin[k] + (side == 1 ? m : n - 1 - m), other, other, out);
    out.loops.is_hole.push_back(1);
}

}  // namespace betamesh
