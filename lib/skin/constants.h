// The numbers that shape the surface, stage by stage. Sizes of tasks and bounds of rounding stay beside their code.
//
// "dx" is the particle spacing, "radius" the ball radius. Lengths are given in one of them, as each comment says;
// angles are in radians. Where a comment says "chosen so that", the value comes from trials on the property and golden
// tests' scenes and on simulated frames; where it says "derived", the derivation is given.

#pragma once

#include <cstddef>

namespace betamesh {

// Tessellation of the union of balls.
//
// Lengths are in ball radii and angles in radians unless a line says otherwise. A "spacing" is the angle between
// neighbouring directions of the points inside faces (0.25 to 0.7); a "rim distance" is what FacePoints defines, about
// the angle to the rim of the exposed part. "Jump" is how far the surface moves at once when its combinatorics change.

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
inline constexpr double kFlipEndMargin = 0.01;
/// Least weight of the other diagonal for which an edge is split: below, nothing moves and vertices may coincide.
inline constexpr double kMinFlipWeight = 1e-4;

// Features

/// Volume enclosed by a component that faces outwards, in volumes of one ball: every such component holds at least one
/// whole ball, whose tessellation has more than half of its volume. What encloses less is a bubble, even where rounding
/// gives a tiny one a positive volume.
inline constexpr double kMinLiquidVolume = 0.25;

// Lengths of the skin (skin_params.cpp) -------------------------------------------------------------------------------

/// Ball radius in dx, > 0, that is assumed where only a radius is given: the beta mesh paper's.
inline constexpr double kPaperRadius = 1.5;

/// Least and largest ball radius, spacings. Beyond them a mistake in units is certain; within, each ball has at most
/// some ten million neighbours in a lattice of that spacing.
inline constexpr double kFewestSpacings = 0.01;
inline constexpr double kMostSpacings = 100;
/// Skin depth in dx, > 0: the volume of bulk and sheets is true at 0.5, that of threads at 0.56, of drops at 0.62.
inline constexpr double kAutomaticSkin = 0.55;
/// Skin depth in dx in two dimensions: the area of bulk and rows is true at half a spacing (derived).
inline constexpr double kAutomaticPlanarSkin = 0.5;
/// Skin depth in dx of a lone particle in two dimensions: sqrt(1/π), the radius of a disc of area dx² (derived).
inline constexpr double kLonePlanarSkin = 0.5641896;
/// Largest automatic skin depth in radii, < 1: keeps the skin inside the balls where these are small.
inline constexpr double kMaxAutomaticSkin = 0.8;
/// Largest radius in skin depths: a skin thinner than a seventh of the radius is drawn as thick as that. Its depth is
/// measured from balls of (radius² + skin²) / (2 skin), here 3.57 radii; larger ones would
/// need neighbours from outside the neighbourhood that is searched.
inline constexpr double kMaxRadiusInSkins = 7;
/// Reach of the neighbourhood whose motion limits vertex velocities: in dx, and at least in radii. Every vertex is
/// within a radius of a ball, so the neighbourhood is never empty.
inline constexpr double kLiquidReachSpacings = 3.5, kLiquidReachRadii = 2;

// Resolution of the tessellation (stage_settings.cpp) -----------------------------------------------------------------

/// Radians between samples inside faces for smoothing the paper's tessellation: its faces have no points of their own.
inline constexpr double kPaperSampleAngle = 0.56;
/// Radians between points inside faces where every arc has one segment: the angle of a common arc, so that arcs and
/// faces are equally fine. With n segments it is divided by n and clamped to the following range.
inline constexpr double kCommonArcAngle = 0.75;
inline constexpr double kMinFaceAngle = 0.05, kMaxFaceAngle = 0.7;
/// The union of balls that is smoothed without a skin: radians per arc segment, and between points inside faces. Chosen
/// so that jumps where balls meet stay small.
inline constexpr double kSmoothedArcAngle = 0.235, kSmoothedFaceAngle = 0.37;
/// The same where there is a skin: coarser, because retract() splits edges that become too long.
inline constexpr double kSkinArcAngle = 0.65, kSkinFaceAngle = 0.55;
/// Factor, >= 1, on the edge lengths at which the skin is refined, where arcs have one segment: the user asked for
/// coarse.
inline constexpr double kSingleSegmentEdgeFactor = 1.5;

// Samples of the boundary (boundary_samples.cpp) ----------------------------------------------------------------------

/// Radians: longest piece of an arc that one sample represents.
inline constexpr double kMaxPieceAngle = 0.8;
/// How far samples of an arc are lifted from the arc towards the sphere around its centre, 0 to 1: arcs are the valleys
/// between balls, the sphere their hilltops.
inline constexpr double kArcLift = 0.5;
/// Length of arc that counts as much as an area of one, in radii.
inline constexpr double kAreaWeight = 3;
/// rim_distance at which points inside faces begin to count, and from which they count in full.
inline constexpr double kFaceSampleBegins = 0.2, kFaceSampleFull = 0.7;
/// Mean squared distance, in square radii, of what is exposed of a ball: up to the first it is one sample, from the
/// second on four, one towards each corner of a tetrahedron.
inline constexpr double kOneSampleSpread = 0.4, kFourSamplesSpread = 0.55;

// Coherent smoothing without a skin (smooth_coherent.cpp) -------------------------------------------------------------

/// Kernel width in radii, > 0. Chosen so that a jittered slab becomes flat while waves of 8 dx stay.
inline constexpr double kSmoothingWidth = 2.8;
/// Largest displacement of a vertex in radii, < 1: no particle is ever left outside.
inline constexpr double kMaxSmoothingStep = 0.5;
/// rim_distance up to which vertices take the whole step, and from which they stay: drops and tips keep their shape.
inline constexpr double kStayBegins = 0.7, kStayFull = 1.4;
/// Weight of samples, in radii of arc, at which a step counts half (smooth_coherent.h: trust); on a plane they
/// weigh 20.
inline constexpr double kHalfTrustWeight = 1.5;
/// Squared length of the mean direction at which a step counts half; 1 on a plane, 0 where parts meet in a point.
inline constexpr double kHalfTrustDirection = 0.15;
/// Added to the variance of the samples, square radii: a single sample fits a plane instead of a tiny sphere.
inline constexpr double kFitVariance = 1e-3;
/// Added to the squared length of the mean direction, so that it can be divided by.
inline constexpr float kMinSquaredMean = 0.01F;
/// Squared slope, height over distance, at which samples cease to count: keeps apart surfaces above one another.
inline constexpr float kMaxSquaredSlope = 0.5F;

// Outer boundary: what the skin's depth is measured from (outer_boundary.cpp) -----------------------------------------

/// Radians of a great circle between samples of an arc, and radians between samples inside a face.
inline constexpr double kOuterArcAngle = 0.4, kOuterFaceAngle = 0.5;
/// rim_distance, radians, up to which samples inside faces fade out towards the rim.
inline constexpr double kOuterFadeWidth = 0.15;
/// Mean length of the arcs at a vertex, dx, from which the rolling ball there has its full size (skin_lengths.h).
inline constexpr double kEntranceArc = 0.25;

// Gaps too narrow for the rolling ball (narrow_gaps.cpp) --------------------------------------------------------------

/// Cosine of the angle between the directions away from two balls from which these are opposite, and from which in
/// full. Chosen so that the dimples of a level surface, where more is opposite, stay closed.
inline constexpr double kOppositeBegins = -0.5, kOppositeFull = -0.9;
/// How much larger a ball may be, dx, that touches the opposite side; up to 0 in full.
inline constexpr double kOppositeExcess = 0.4;
/// Radii of the ball in the gap from which it counts and from which in full, dx. Chosen: smaller ones show more of a
/// gap, but in tunnels they make the surface jump.
inline constexpr double kTightGap = 0.3, kWideGap = 1.2;
/// Radius of the circle in which two balls meet, in radii of a ball, from which its points count in full.
inline constexpr double kFullHeight = 0.3;
/// Radians from which the middle of an arc counts in full, from which less, and from which no longer: long arcs have
/// points of their own, which change less than their middles do where a ball cuts them in two.
inline constexpr double kFullArc = 0.2, kLongArc = 0.6, kLongestArc = 1;
/// Part of its square radius that a ball loses as it becomes as large as the rolling one, and the share from which on:
/// where the outer boundary begins, its samples are farther apart.
inline constexpr double kGapEnd = 0.1, kGapEndBegins = 0.8;
/// Mean offset of samples, in square radii of the rolling ball, over which vertices cease to be raised to them and to
/// have their velocity.
inline constexpr double kGapOffset = 0.2;

// Retraction to the skin (retract.cpp); lengths in dx -----------------------------------------------------------------

/// Outer samples so much farther away than the nearest one contribute to the direction. Wide enough to vary slowly,
/// narrow enough to point to the nearest part.
inline constexpr double kDirectionBand = 0.25;
/// Vertices so much deeper than the skin are out of reach and stay; in between they fade. Chosen: farther, more pits
/// are raised to the skin (area over 30 degrees of SPH frame 24 at 0.3, 0.45, 0.6 and 1: .066, .062, .061 and .059 %),
/// but they move farther while the rolling ball enters a cavity.
inline constexpr double kReachFade = 0.45;
/// Added to the squared distance of an outer sample that has only just appeared (square dx): it comes gradually.
inline constexpr float kNewSampleSquaredOffset = 0.3F;
/// The same among balls of different sizes, where the spacings by which distances are divided change along an arc.
inline constexpr float kNewSampleSquaredOffsetOfUnequal = 1;
/// Length of a wide step, and their largest number.
inline constexpr double kWideStep = 0.37, kMaxWideSteps = 16;
/// Kernel widths over which steps are averaged: of the wide steps, then of each narrower one.
inline constexpr double kWideKernel = 1.3;
inline constexpr double kNarrowKernels[] = {1.0, 0.8, 0.6}, kCoarseNarrowKernels[] = {1.0, 0.6};
/// Longest step inwards, in kernel widths: an averaged field that changes so slowly does not fold the mesh. Longest
/// step outwards, in dx.
inline constexpr double kMaxStepInKernels = 0.2, kMaxOutwardStep = 0.1;
/// Least share of a step by which the distance from the outer boundary is assumed to grow. On a flat surface it is 1,
/// at the rim of a hole less, as the outer boundary is near on both sides.
inline constexpr double kLeastGain = 0.3;
/// Gap beyond which a vertex lags behind.
inline constexpr double kLagging = 0.07;
/// Steps of vertices that lag behind, before the mesh is refined (edges around holes grow until then) and after; their
/// kernel width; their length over what the gap exceeds kLagging by, > 1, as averaging shortens them.
inline constexpr int kCatchUpsBefore = 3, kCatchUpsAfter = 2;
inline constexpr double kCatchUpKernel = 0.5, kCatchUpGain = 2;
/// Kernel width over which velocities are averaged.
inline constexpr double kVelocityKernel = 0.6;
/// Depth beyond the automatic skin that makes volumes true: of threads, which expose a fifth of each outer ball, and of
/// lone particles, which expose all of it, in addition (0.55 + 0.1 - 0.02 is near 0.62). Chosen so that the volumes of
/// threads and drops are true.
inline constexpr double kThreadExtraDepth = 0.1, kDropExtraDepth = -0.02;
/// Exposed share of an outer ball, 0 to 1, from which each extra depth counts, and the width over which it fades in.
inline constexpr double kThreadExposure = 0.1, kThreadExposureFade = 0.1, kDropExposure = 0.8, kDropExposureFade = 0.2;

// Meetings (meetings.cpp); lengths in dx ------------------------------------------------------------------------------

/// Radius of the circle in which two balls meet from which a neck is not thin; half of it is thin in full. The neck of
/// two particles is then 0.05 dx thick.
inline constexpr double kThinNeck = 0.6;
/// How far along and across the axis a neck reaches; half of it in full.
inline constexpr double kNeckLength = 0.9, kNeckWidth = 0.5;
/// Radius that a neck has at least, or half of the circle's: thinner ones are hairs in a picture.
inline constexpr double kLeastNeck = 0.03;
/// Height of three spheres' common point over the plane of their centres up to which a membrane is thin, in proportion.
/// Likewise, for a hole, the root of how much their square radii are too small for a common point. Chosen: more leaves
/// more dimples unsmoothed, with less holes open faster (area over 30 degrees and largest jump between two frames of a
/// splash at 0.4: 0.075 %, 0.28 dx; at 0.3: 0.074 %, 0.30 dx).
inline constexpr double kThinMembrane = 0.4;
/// How far along and across its axis such a place reaches; half of it in full.
inline constexpr double kHoleLength = 0.9, kHoleWidth = 1;
/// Barycentric coordinates of its middle in the triangle of the centres, radii of the circles in which each two balls
/// meet, and by how much less another ball's power is there, or how little more where the circles are nearest to it
/// (square dx): over these nearness fades to 0.
inline constexpr double kHoleInside = 0.1, kHoleCircle = 0.15, kHoleCovered = 0.05;

// Pinholes (pinholes.cpp); lengths in radii of the smallest of three balls --------------------------------------------

/// Radius of a hole up to which it is narrowed in full, and from twice which on not at all; and half the thickness of a
/// membrane from which on its dimples stay as they are.
inline constexpr double kPinholeRadius = 0.27, kPinholeMembrane = 0.1;
/// Points at a distance r from the axis move to r² / sqrt(r² + the first²), unless they are nearer than the second;
/// this many times.
inline constexpr double kPinholeNarrowing = 0.23, kPinholeLeast = 0.033;
inline constexpr int kPinholeRounds = 2;
/// How far that reaches along the axis and across it; half of it in full.
inline constexpr double kPinholeLength = 0.6, kPinholeWidth = 0.47;
/// Area of what is steep around a pinhole from which on its middle is there rather than between the particles.
inline constexpr double kPinholeArea = 0.0044;
/// By how much less another ball's power is at the middle for the hole to be covered; power of the middle between two
/// of the three from which on the hole is open to that side.
inline constexpr double kPinholeCovered = 0.022, kPinholeSide = 0.09;
/// Cosine of the angle between the normals at the ends of an edge below which there may be a pinhole, and how far
/// beyond its surface a ball may be from there.
inline constexpr double kPinholeTurn = 0.8, kPinholeReach = 0.47;
/// Number of larger balls near a ball beyond which, as where particles coincide, no holes are looked for beside it.
inline constexpr std::size_t kMaxPinholeNeighbours = 128;

// Refinement (refine_mesh.cpp); lengths in dx -------------------------------------------------------------------------

/// Longest edges where the surface is flat: in dx, or in radii where that is more, a little longer than arc segments.
inline constexpr double kMaxFlatEdge = 0.9, kMaxFlatEdgeRadii = 0.55;
/// Longest edges where it is as round as a thread.
inline constexpr double kMaxRoundEdge = 0.4;
/// Kernel width for the variation of normals, and the variations (0 to 1) that count as flat and as round.
inline constexpr double kVariationKernel = 0.8, kFlatVariation = 0.03, kRoundVariation = 0.1;
/// Longest edges along rims and threads, where the surface turns across the edge but hardly along it; the concavity
/// along an edge, radians per dx, from which it counts as one and from which in full; the variation of normals from
/// which that counts, in full at twice it. Rims of holes have bumps, so convex edges count, too.
inline constexpr double kMaxRimEdge = 0.25, kRimBegins = -0.4, kRimFull = -0.2, kRimVariation = 0.07;
/// Radians by which an edge may turn, as on the rims of pinholes, unless it is shorter than the second.
inline constexpr double kMaxTurn = 0.8, kMinTurningEdge = 0.1;
/// Excess length, in longest lengths, over which the vertex that splits an edge fades in.
inline constexpr double kSplitFade = 0.5;
/// Demand for a split (SplitDemand), 0 to 1, over which a vertex in a quad goes to the middles of its diagonals.
inline constexpr double kQuadCentreFade = 0.05;

// Fairing along edges (fairing.cpp, deforming_mesh.cpp); lengths in dx ------------------------------------------------

/// Kernel width of meanNormals().
inline constexpr double kMeanNormalKernel = 0.3;
/// Flatness of a one-ring, 0 to 1, at which a vertex begins to move to the mean of its ring, and where it moves in
/// full.
inline constexpr double kFoldBegins = 0.95, kFoldFull = 0.8;
/// Vertices that an edge shorter than this connects share their one-rings in part, because where a ball emerges three
/// take the place of one.
inline constexpr float kFoldCluster = 0.05F;
/// Share of the distance to that mean in one step.
inline constexpr double kFoldRelaxation = 0.7;
/// Cosine between a triangle's normal and the surface's below which it counts as inverted.
inline constexpr double kInvertedCosine = 0.5;
/// An inverted triangle is turned in full where its longest edge's square exceeds the others' by this share.
inline constexpr double kLongestEdgeMargin = 0.1;
/// Height over its longest edge, as a share of that edge, of a triangle that has been turned.
inline constexpr double kTurnedHeight = 0.03;
/// Longest step of relaxFolds().
inline constexpr float kMaxFoldStep = 0.25F;

/// Flatness of a one-ring below which it is sharp, and from which in full.
inline constexpr double kSharpBegins = 0.96, kSharpFull = 0.8;
/// Flatness that a one-ring of a drop lacks, per area of its vertex in square dx: 0.14 / R² with six neighbours
/// (derived), R the radius of a drop of one particle, 0.6. So coarse triangles of drops are not sharp.
inline constexpr double kDropBend = 0.4;
/// Kernel width of the mean over sharp vertices, its gain, and what is subtracted so that most vertices have no share.
inline constexpr double kSharpKernel = 0.7;
inline constexpr float kSharpGain = 4, kLeastSharp = 0.005F;
/// Steps of fairing, their gain, and the share of the last step that is added to each (Polyak 1964), with
/// 2 gain < 1 + momentum: beyond, they oscillate. Chosen: features of a hole's rim up to ten edges long become half as
/// large; with twice as many steps the crease is the same and the surface jumps more. Without momentum, 60 steps of
/// gain 0.4 do as much.
inline constexpr int kFairingSteps = 17;
inline constexpr float kFairingGain = 0.6F, kFairingMomentum = 0.65F;
/// Area of a triangle, over that of an equilateral one with the same sum of squared edges, below which it counts less
/// in the mean over a one-ring.
inline constexpr double kWellShaped = 0.5;

// Particles of different sizes (deforming_mesh.cpp, scale_means.cpp, outer_boundary.cpp); lengths in dx ---------------

/// How often, and with a kernel how wide, the local particle spacing is averaged along the surface.
inline constexpr int kScaleMeans = 3;
inline constexpr double kScaleKernel = 1.5;
/// How much less than the skin's depth the outermost of irregularly spaced particles lie beneath a level surface.
inline constexpr double kOutermost = 0.1;

// Particles at risk of being left outside (keep_inside.cpp) -----------------------------------------------------------

/// All particles are checked where the skin is thinner than kThinSkin · edge factor dx, or where there are more
/// smoothing passes than kFewPasses: there facets may cut particles off. From a ball radius of kLargeBalls on the limit
/// grows with the radius, as facets do.
inline constexpr double kThinSkin = 0.5, kLargeBalls = 3;
inline constexpr int kFewPasses = 2;
/// A particle is beside larger ones, and checked, if a vertex is within kReachOfLarger local spacings of it and that
/// spacing is more than kMuchLarger times the particle's own. 1.1 left particles outside where the skin was 0.5 dx.
inline constexpr double kReachOfLarger = 1.5, kMuchLarger = 1.05;
/// Radius of a bump over its height, or over the distance from the particle to the farthest corner of the nearest
/// triangle, whichever is larger.
inline constexpr double kBumpWidth = 2;
/// How often bumps are raised: each raises the surface over a particle by about half of what is missing, less where
/// bumps over others pull it down.
inline constexpr int kBumpRounds = 16;
/// How often at most displacements are taken back, each time twice as far, around particles that are outside.
inline constexpr int kMaxRestorations = 16;

// Smoothing of the skin (skin_smoothing.cpp, kernel_shapes.cpp, long_waves.cpp and others); lengths in dx -----------

/// Steps of the bi-Laplacian in a pass; their gain: as much as four steps of 1, and below where it oscillates. Two
/// steps of 1.2 and 2.8 are as smooth, but the surface jumps more.
inline constexpr int kBiLaplacianSteps = 3;
inline constexpr float kBiLaplacianGain = 1.6F;
/// Its kernel width and longest step.
inline constexpr double kBiLaplacianKernel = 0.8, kMaxBiLaplacianStep = 0.15;
/// Kernel widths of the mean over steps, which keeps slivers from folding, and of the normals along which vertices
/// move.
inline constexpr double kStepKernel = 0.3, kNormalKernel = 0.5;
/// Widest and narrowest kernel of a sphere fit.
inline constexpr double kWidestFit = 5.8, kNarrowestFit = 0.8;
/// Kernel widths between which fits fade in: narrower ones would reproduce creases.
inline constexpr double kFitBegins = 1, kFitFull = 2;
/// Kernel widths between which vertices go over from averaged steps to their own.
inline constexpr double kOwnStepBegins = 4, kOwnStepFull = 5.4;
/// Longest step onto a fitted sphere.
inline constexpr double kMaxFitStep = 0.3;
/// Added to the variance of what is fitted, square dx: a small neighbourhood fits a plane.
inline constexpr double kSkinFitVariance = 1e-3;
/// Cosines to an element's normal between which a surface faces sideways, neither the same way nor the opposite one,
/// and the width over which that fades.
inline constexpr float kSidewaysMax = 0.5F, kSidewaysMin = -0.3F, kSidewaysFade = 0.25F;
/// Kernel width of the means over the elements' kernels.
inline constexpr double kShapeKernel = 2.5;
/// 2 / π: the inverse square distance of a wall across the surface is this times the sum over it (derived).
inline constexpr double kWallFactor = 0.6366;
/// Kernel width of fits at edges of thick liquid, which are rounded whatever faces sideways. On rims of sheets and on
/// threads it may be narrower: with a surface at distance D that faces the opposite way, 1 / sqrt(1 / kEdgeFit² +
/// kThinFactor / D²).
inline constexpr double kEdgeFit = 2.5, kThinFactor = 2;
/// Added to squared distances in those sums, square dx.
inline constexpr float kSidewaysSoftening = 0.02F;
/// Height between a vertex' being below and above the tangent plane of what faces sideways, over which that goes over
/// from turning towards the vertex to turning away.
inline constexpr float kConvexFade = 0.25F;
/// Weight of a kernel's width along an edge in the harmonic mean that decides how much of a step the fit gets, 0 to 1.
/// Chosen so that edges are smooth along themselves and creases are not sharpened.
inline constexpr double kLengthwiseShare = 0.35;
/// Agreement of a surface element's normals, 0 to 1, below which it is divided by directions, and the width over which
/// it fades.
inline constexpr double kUndividedFlatness = 0.75, kDivisionFade = 0.15;
/// How often lost long waves are returned, and the kernel width from which on all of what is lost returns. Chosen so
/// that edges, whose kernels are narrower, stay round.
inline constexpr int kWaveReturns = 3;
inline constexpr double kWavesFull = 4;
/// Calls of relaxFolds() after a pass; there is one before it, because fits depend on how vertices face.
inline constexpr int kFoldRelaxations = 3, kCoarseFoldRelaxations = 2;
/// Largest displacement by smoothing in skin depths, < 1: no vertex passes a particle.
inline constexpr double kMaxSkinSmoothing = 0.9;
/// Share of that from which displacements near by are shortened alike, so that no vertex stays behind alone: by the
/// mean over a kernel of the fourth power of the excess, times a gain, as tips are a small part of what is near.
inline constexpr double kGentleLimit = 0.8, kExcessKernel = 1;
inline constexpr float kExcessGain = 8;
/// Logarithm of an excess that does not count there, so that most vertices have none.
inline constexpr float kLeastExcess = 0.001F;

// Self-intersections (self_intersections.cpp, displacement_limits.cpp); lengths in radii -----------------------------

/// Attempts to remove crossings of the skin by moving corners to the mean of their one-rings.
inline constexpr int kCornerRelaxations = 6;
/// After these, attempts to move layers back through each other, and the distance of each. Chosen so that most layers
/// that have passed through each other by a few thousandths are apart then, and no vertex has moved visibly.
inline constexpr int kMovesBack = 6;
inline constexpr double kMoveBack = 0.002;
/// Kernel width of mean displacements, and the edge of cells whose triangles count as one element in them.
inline constexpr double kMeanDisplacementKernel = 0.5, kDisplacementCell = 0.0625;
/// Rounds, and rounds in a row without fewer crossings, after which vertices that still cross return to their origins.
inline constexpr int kMaxReductionRounds = 24, kMaxRoundsInVain = 4;
/// Share of the crossing-free displacement that is used, < 1: stays clear of the contact.
inline constexpr double kContactMargin = 0.999;
/// The contact's rate of change: the time step in which nothing moves further than this; how far the contact may move
/// in it, as a share of the displacement; the largest speed of a vertex by it, in largest speeds of the triangles.
inline constexpr double kContactTimeStep = 1e-4, kMaxContactChange = 0.05, kMaxContactSpeed = 2;
/// Attempts to separate triangles that cross in every known state, the first of which move fading vertices to their
/// supports; growth of the distance from one attempt to the next, and its largest value.
inline constexpr int kMaxSeparations = 24, kSupportSeparations = 4;
inline constexpr double kSeparationGrowth = 1.5, kMaxSeparation = 0.02;

// Inverted triangles (unfold.cpp); lengths in dx ----------------------------------------------------------------------

/// Smallest inverted area that could be seen, and that replacing an edge has to gain; square dx.
inline constexpr double kLeastInverted = 1e-4;
/// Largest distance between two diagonals of which one replaces the other; its share of the skin's depth.
inline constexpr double kMaxDiagonalDistance = 0.02, kMaxDiagonalShare = 0.04;
/// How often all inverted triangles are tried.
inline constexpr int kUnfoldingRounds = 8;

// Velocities (velocity.cpp, limit_velocities.cpp) ---------------------------------------------------------------------

/// |q1·(q2 × q3)|, unit directions to the three balls, from which a vertex' equations are solved exactly: 99.9 % of
/// vertices (measured).
inline constexpr double kWellConditioned = 0.01;
/// Weight of the rigid motion against the three equations where that is 0.
inline constexpr double kRigidMotionDamping = 0.25;
/// Added to the inertia of the balls near a vertex, in squares of the reach: always, so that it can be inverted for a
/// line of balls; and up to the second where they do not move as a rigid body, or noise would make threads spin.
inline constexpr double kMinInertia = 1e-7, kNoiseInertia = 0.03;
/// Largest speed by rotation, over the root mean square of what it gives the balls: two balls close together have a
/// large angular velocity, which must not be extrapolated to the surface.
inline constexpr double kMaxRotationGain = 8;
/// Largest normal velocity relative to the rigid motion, over the root mean square of the balls' own. Measured: more is
/// farther from the surface half a frame later.
inline constexpr double kMaxRelativeVelocity = 0.7;

// Walls (walls.cpp); lengths in dx ------------------------------------------------------------------------------------

/// Distance from a wall up to which the surface is flat, and from which it stays as it is.
inline constexpr double kWallFlat = 0.5, kWallReach = 1.25;
/// What remains of distances up to the first, as a share: more than 0, so that opposite sides of what is thin there do
/// not meet.
inline constexpr double kWallRemainder = 0.01;

// Attributes measured on the surface (surface_attributes.cpp); lengths in dx ------------------------------------------

/// Kernel width of the fit of normals.
inline constexpr double kAttributeFit = 1.2;
/// Length of a mean of normals, 0 to 1, up to which they cancel, and the width over which that fades.
inline constexpr double kCancelling = 0.6, kCancellingFade = 0.4;
/// Length of the mean normal below which there is no fit.
inline constexpr double kMinMeanNormal = 1e-3;
/// Largest thickness.
inline constexpr double kMaxThickness = 4;
/// Added to the sum over the opposite side: the thickness approaches its largest value smoothly.
inline constexpr double kThicknessSmoothing = 0.01;
/// Cosine between the normal of a vertex and the opposite of another one below which the latter fades out of that sum,
/// and down to minus which; sine of the elevation over the tangent plane up to which it fades in.
inline constexpr float kOppositeFade = 0.25F, kOppositeElevation = 0.2F;
/// Thickness at which bulk begins, and from which everything is bulk.
inline constexpr double kBulkBegins = 2, kBulkFull = 3.5;
/// Principal curvature times thickness, which is 0 on plane sheets and along threads, 2 across threads and on drops:
/// where the surface begins to count as round, and where it does in full.
inline constexpr double kRoundBegins = 0.5, kRoundFull = 1.5;

}  // namespace betamesh
