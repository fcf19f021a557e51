// The loops round the exposed parts of one ball, for its hull.

#pragma once

#include "skin/arcs.h"
#include "skin/ball_boundary.h"
#include "skin/sphere_loops.h"

#include <cstdint>
#include <vector>

namespace betamesh {

/// One ball's loops, on a sphere round its centre.
struct BallLoops {
    LoopsOnSphere loops;
    std::vector<std::uint32_t> network_point;  ///< of each loop point: its row in ArcNetwork::point
    std::vector<std::uint32_t> face_begin;     ///< first loop of each face, and one entry past the last

    void clear() {
        loops.clear();
        network_point.clear();
        face_begin.assign(1, 0);
    }
};

/// Lists the loops of balls of one boundary.
class BallLoopMaker {
public:
    BallLoopMaker(const BallBoundary& boundary, const ArcNetwork& network) : boundary_(boundary), network_(network) {}

    /// Replaces `out` by the loops of a ball whose faces are first_face to last_face - 1.
    void makeLoops(std::uint32_t ball, std::uint32_t first_face, std::uint32_t last_face, BallLoops& out) const;

private:
    void add(std::uint32_t ball, std::uint32_t point, std::uint32_t circle_before, std::uint32_t circle_after,
             BallLoops& out) const;
    bool isNearlyTangent(std::uint32_t ball, std::uint32_t other) const;
    void addCycle(std::uint32_t ball, std::span<const std::uint32_t> cycle, BallLoops& out) const;
    void addCircle(std::uint32_t ball, std::uint32_t circle_side, BallLoops& out) const;

    const BallBoundary& boundary_;
    const ArcNetwork& network_;
};

}  // namespace betamesh
