// The constants that shape the tessellation of the union of balls: where its points lie, and how they fade in and out.
//
// Lengths are in ball radii and angles in radians unless a line says otherwise. A "spacing" is the angle between
// neighbouring directions of the points inside faces (0.25 to 0.7); a "rim distance" is what FacePoints defines, about
// the angle to the rim of the exposed part. "Jump" is how far the surface moves at once when its combinatorics change.

#pragma once

namespace betamesh {

// Arcs

/// Angle per segment of a great circle when every vertex lies on the balls: a sagitta δ²/8 of 0.008. In (0, 2].
inline constexpr double kBoundaryArcAngle = 0.25;
/// Largest angle of any segment, whatever its sagitta: a full circle has at least four segments.
inline constexpr double kMaxSegmentAngle = 2;
/// Arcs below this angle are not subdivided further than needed for manifoldness: far below any visible sagitta (1e-9).
inline constexpr double kStraightArcAngle = 1e-4;
/// Lengths of the longest segment by which an arc grows while a new point fades in from its chord, and while the halves
/// next to new points grow to full length. In (0, 1); chosen so that both end before the next point is needed.
inline constexpr double kFadeInLength = 0.2, kRegrowLength = 0.25;
/// Least fade weight of a point on an arc: above 0, so that points are never collinear; small, as the point appears at
/// once with it: a jump of 2 % of a sagitta.
inline constexpr double kMinFadeWeight = 0.02;

// Flat faces: small patches of a ball in the surface of a liquid, which smoothing lays flat. Chosen together so that
// the coarser arcs between them (a fifth fewer triangles) jump less than those on drops and edges do.

/// Squared length of the mean direction from the ball to the lines round a face, in [0, 1]. Up to the first the lines
/// surround the ball, as on drops; from the second on they lie on one side, as round a small patch.
inline constexpr double kSurroundingRim = 0.5, kOneSidedRim = 0.7;
/// Share of that mean direction that points towards the neighbouring balls, in [0, 1]. Up to the first the small patch
/// is exposed; from the second on it is what is covered, and the face is the rest of the ball.
inline constexpr double kExposedPatch = 0.35, kCoveredPatch = 0.6;

// Points inside faces

/// Sine of a cap's half-angle below which the cap counts as narrow, and rim distances round it are scaled up: a ball
/// that barely touches has no influence at a distance. In (0, 1]; 0.28 is a half-angle of 16 degrees.
inline constexpr double kWideCapSine = 0.28;
/// Rim distance of a direction without caps: above every threshold below.
inline constexpr double kMaxRimDistance = 10;
/// Gap between two spheres below which both have a point in the direction of the other ball, which fades in as the gap
/// closes. Measured: contacts then jump by less than 0.001, without such points by up to 0.014.
inline constexpr double kContactGap = 0.1;
/// Least distance of a contact point from rims and from other points for it to be a point of its own, in radii.
inline constexpr double kMinContactSeparation = 1e-3;

/// Least rim distance of points when all vertices lie on the boundary, in spacings: closer points make slivers.
inline constexpr double kMinRimSpacings = 0.2;
/// Rim distance below which points are lowered below the sphere where they fade in gradually, in spacings. Above
/// kMinRimSpacings, and below 1 so that a face wider than two spacings has points on the sphere.
inline constexpr double kLoweringRimSpacings = 0.75;
/// Depth of a lowered point at the rim, in radii per square of the spacing: about the sagitta of an edge between
/// neighbouring points (1/8), so that the hull passes over the point before it reaches the rim.
inline constexpr double kLoweringDepth = 0.12;
/// The same where the mesh is retracted far below the balls afterwards, in sagittas of the longest segment. Above 1:
/// points vanish below the chords.
inline constexpr double kLoweringDepthSagittas = 1.5;
/// Depth of a contact point where it begins to fade in, in radii per square of the spacing: deeper than the centre of
/// any facet between neighbouring points (1/6).
inline constexpr double kContactDepth = 0.25;
/// Height over the facet beneath from which on a lowered point has fade weight 1, in radii per square of the spacing.
/// Below kLoweringDepth.
inline constexpr double kFreeHeight = 0.05;
/// Square root of the relative depth from which on a lowered point is blended towards the facet beneath it in full, in
/// (0, 1]. Points less deep are blended in proportion, so that blending begins continuously where lowering begins.
inline constexpr double kFullBlendDepth = 0.3;

/// Rim distances between which the volume-compensating offset of points fades in. Chosen so that only drops and the
/// ends of threads have such points.
inline constexpr double kOffsetBegins = 0.7, kOffsetFull = 1.4;

// Edge flips

/// Distance between the two diagonals of a quad below which an edge flip is in progress, in radii per square of the
/// spacing: a small part of the sagitta of an edge (1/8). Larger where the mesh is retracted far afterwards.
inline constexpr double kFlipDistance = 0.0025, kRetractedFlipDistance = 0.01;
/// Distance from the ends of both diagonals, as a fraction of their lengths, from which on a flip counts in full. In
/// (0, 0.5]; fades flips out whose vertex would reach a corner of the quad.
inline constexpr double kFlipEndMargin = 0.1;
/// Least weight of the other diagonal for which an edge is split: below, nothing moves and vertices may coincide.
inline constexpr double kMinFlipWeight = 1e-4;

// Features

/// Volume enclosed by a component that faces outwards, in volumes of one ball: every such component holds at least one
/// whole ball, whose tessellation has more than half of its volume. What encloses less is a bubble, even where rounding
/// gives a tiny one a positive volume.
inline constexpr double kMinLiquidVolume = 0.25;

}  // namespace betamesh
