// Configuration keys that shape the surface.

#include "batch/config/key_tables.h"
#include "batch/config/key_types.h"
#include "batch/config/surface_params.h"
#include "skin/constants.h"

#include <limits>

namespace betamesh {

namespace {

void checkWalls(const std::vector<std::string>& walls) {
    for (const std::string& wall : walls)
        if (!wallOf(wall)) failValue(wall, "planes such as x>0 or 0.6x+0.8y<2, separated by commas");
}

void checkSurfaceAttributes(const std::vector<std::string>& names) {
    const std::vector<std::string> known{"thickness", "curvature", "shape"};
    for (const std::string& name : names)
        if (std::find(known.begin(), known.end(), name) == known.end())
            failValue(name, "some of thickness, curvature and shape, separated by commas", known);
}

ConfigKey surfaceBoxKey(const KeyText& text) {
    const std::string accepts = "none, or six numbers separated by commas, each lowest one below the highest";
    return makeKey(
        text, ConfigKey::Kind::list, accepts,
        [](const Config& config) { return config.surface.box ? textOfNumbers(*config.surface.box) : "none"; },
        [=](Config& config, const std::string& value) {
            const auto box = numbersOf<6>(value);
            if (!box && value != "none") failValue(value, accepts);
            for (std::size_t k = 0; box && k < 3; ++k)
                if (!((*box)[k] < (*box)[k + 3])) failValue(value, accepts);
            config.surface.box = box;
        });
}

}  // namespace

void addSurfaceKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(lengthKey(
        {"surface.radius", "--radius", "",
         "Ball radius: `0.03` in world units, or `1.5dx` in particle spacings. The paper uses 1.5 spacings, which "
         "closes the surface of still liquid. A larger radius gives a smoother surface and merges drops earlier; a "
         "smaller one keeps more detail but may open holes."},
        "", [](Config& c) -> Length& { return c.surface.radius; }));
    keys.push_back(positiveKey(
        {"surface.spacing", "--spacing", "world units",
         "Particle spacing, which `dx` stands for: the distance at which the simulation seeded its particles. auto: "
         "radius / " +
             textOf(kDefaultRadiusSpacings) +
             " if the radius is given in world units; otherwise measured once, in the first, a middle and the "
             "last frame on disk with at least seven distinct particles, and used for all frames."},
        "auto, or a number above 0", std::numeric_limits<float>::max(), true,
        [](Config& c) -> double& { return c.surface.spacing; }));
    keys.push_back(textKey(
        {"surface.radius_attribute", "--radius-attribute", "",
         "Particle attribute, such as pscale or radius, that gives each particle a spacing of its own, for adaptive "
         "simulations, spray and whitewater. At this particle, dx in surface.radius, surface.skin and "
         "smoothing.width means this attribute times surface.radius_scale. All other lengths are in units of "
         "surface.spacing. Empty: "
         "all particles are alike."},
        "the name of an attribute with one number above 0 per particle, or leave it empty",
        [](Config& c) -> std::string& { return c.surface.radius_attribute; }));
    keys.push_back(positiveKey(
        {"surface.radius_scale", "--radius-scale", "particle spacings per unit of the attribute",
         "Multiplies surface.radius_attribute: 2 where it is half of the distance at which particles were seeded. "
         "Numbers of the attribute are in units of the file, as positions are: input.scale multiplies them, too."},
        "a number above 0", std::numeric_limits<float>::max(), false,
        [](Config& c) -> double& { return c.surface.radius_scale; }));
    keys.push_back(textKey(
        {"surface.radius_rate_attribute", "--radius-rate-attribute", "",
         "Particle attribute with the change of surface.radius_attribute per second, for the velocities of growing and "
         "shrinking particles. Empty: they keep their sizes during the shutter."},
        "the name of an attribute with one number per particle, or leave it empty",
        [](Config& c) -> std::string& { return c.surface.radius_rate_attribute; }));
    keys.push_back(choiceKey<SurfaceKind>(
        {"surface.kind", "--surface", "",
         "Surface to build. beta: the closed beta mesh. alpha: triangles between the particle centres, fast and rough. "
         "union: the boundary of the union of balls, for comparison."},
        {{"beta", SurfaceKind::beta}, {"alpha", SurfaceKind::alpha}, {"union", SurfaceKind::union_}},
        [](Config& c) -> SurfaceKind& { return c.surface.kind; }));
    keys.push_back(integerKey(
        {"surface.dimension", "--dimension", "",
         "3: balls, which give closed triangle meshes. 2: discs, which give closed curves, for particles in a plane "
         "perpendicular to a coordinate axis: all have the same z, the same y or the same x. Curves are written as "
         ".ply edges, .bgeo polylines, .obj lines or .svg drawings."},
        2, 3, false, [](Config& c) -> int& { return c.surface.dimension; }));
    keys.push_back(choiceKey<Tessellation>(
        {"surface.tessellation", "--tessellation", "",
         "How the faces of the beta mesh are divided into triangles. complete: all of them, so that the mesh is closed "
         "and manifold and includes every sheet, tendril and drop. paper: one triangle fan per face as in the paper; "
         "isolated particles and tendrils one particle thick are written as spheres beside the mesh."},
        {{"complete", Tessellation::complete}, {"paper", Tessellation::paper}},
        [](Config& c) -> Tessellation& { return c.surface.tessellation; }));
    keys.push_back(integerKey(
        {"surface.arc_subdivisions", "--arc-subdivisions", "segments per arc",
         "Resolution of the complete tessellation along the arcs between neighbouring balls and across the faces; in "
         "two dimensions a circle has 8 times as many segments. auto: without a skin no arc deviates by more than 0.01 "
         "radii, or 0.02 radii where smoothing flattens the surface; with one arcs are coarser, and long edges are "
         "split "
         "later. 1 gives the smallest meshes."},
        1, 64, true, [](Config& c) -> int& { return c.surface.arc_subdivisions; }));
    keys.push_back(choiceKey<PredicateKind>(
        {"surface.predicates", "--predicates", "",
         "How geometric tests are evaluated. exact: exact signs, with ties broken by a fixed rule; never fails. float: "
         "the paper's test in double precision; if its result is inconsistent, the particles are jittered and the "
         "frame is tried again."},
        {{"exact", PredicateKind::exact}, {"float", PredicateKind::floating}},
        [](Config& c) -> PredicateKind& { return c.surface.predicates; }));
    keys.push_back(optionalLengthKey(
        {"surface.skin", "--skin", "",
         "Distance from the outermost particles to the surface; less than the radius. auto: the mesh encloses the "
         "volume of the liquid. none: the surface of the balls themselves, one radius outside the particles, which "
         "makes thin sheets two radii thick. A length requires surface.kind beta with the complete tessellation; for "
         "other surfaces, and without smoothing, auto means none."},
        "none", [](Config& c) -> std::optional<Length>& { return c.surface.skin; }));
    keys.push_back(namesKey(
        {"surface.walls", "--walls", "world units",
         "Plane walls of a tank, each by the side on which the liquid lies: `x>0` or `0.6x+0.8y<2`, with y up, after "
         "input.scale and input.up_axis. Where the surface is within 0.5 particle spacings of a wall it is laid flat "
         "against it, to within 0.005 spacings, except where triangles would cross; farther away the displacement "
         "fades out, up to 1.25 spacings. Walls nearer to each other than that disturb each other. Requires "
         "surface.kind beta with the complete tessellation."},
        "planes such as x>0 or 0.6x+0.8y<2, each at most once, separated by commas; or leave it empty",
        [](Config& c) -> std::vector<std::string>& { return c.surface.walls; }, checkWalls));
    keys.push_back(surfaceBoxKey(
        {"surface.box", "--surface-box", "world units",
         "Cuts the mesh off at a box and closes it with plane polygons: lowest x, y, z, highest x, y, z, with y up, "
         "after input.scale and input.up_axis. Particles outside still shape the surface inside; input.box leaves "
         "particles out. Requires surface.kind beta with the complete tessellation."}));
    ConfigKey inset =
        optionalLengthKey({"surface.inset", "--inset", "",
                           "Deprecated; use surface.skin. An inset of D equals a skin of radius - D. auto: not set."},
                          "0", [](Config& c) -> std::optional<Length>& { return c.surface.inset; });
    inset.replaced_by = "surface.skin";
    keys.push_back(inset);
    keys.push_back(
        booleanKey({"surface.resolve_intersections", "--resolve-intersections", "",
                    "Step 4 of the paper, for its tessellation: moves vertices outwards to enclose particles that "
                    "smoothing left outside. The complete tessellation leaves no particle outside."},
                   [](Config& c) -> bool& { return c.surface.resolve_intersections; }));
}

void addPerturbationKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(
        integerKey({"perturbation.retries", "--retries", "",
                    "For float predicates: how many times a frame is jittered and tried again before it fails."},
                   0, 100, false, [](Config& c) -> int& { return c.perturbation.retries; }));
    keys.push_back(positiveKey(
        {"perturbation.tolerance", "--tolerance", "multiples of the radius",
         "For float predicates: size of the jitter. A larger jitter succeeds sooner but moves the surface more."},
        "a number above 0, at most 0.1", 0.1, false, [](Config& c) -> double& { return c.perturbation.tolerance; }));
}

void addSmoothingKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(choiceKey<SmoothingMethod>(
        {"smoothing.method", "--smoothing", "",
         "Smoothing method. coherent: moves vertices onto spheres fitted to the surface around them; removes the bumps "
         "of the balls, keeps drops and sheets, and changes continuously over time. paper: moves vertices to the "
         "weighted centroids of the adjacent faces, on the paper's tessellation. none: vertices stay on the balls."},
        {{"coherent", SmoothingMethod::coherent}, {"paper", SmoothingMethod::paper}, {"none", SmoothingMethod::none}},
        [](Config& c) -> SmoothingMethod& { return c.smoothing.method; }));
    keys.push_back(lengthKey(
        {"smoothing.width", "--smoothing-width", "",
         "Coherent smoothing: width of the neighbourhood to which each vertex is fitted. Bumps much shorter than this "
         "vanish; waves twice as long are kept. auto: " +
             textOf(kWidestFit) + "dx."},
        "auto", [](Config& c) -> Length& { return c.smoothing.width; }));
    keys.push_back(integerKey(
        {"smoothing.passes", "--passes", "",
         "Number of smoothing passes. The paper uses 1; each additional pass removes some detail and volume."},
        0, 100, false, [](Config& c) -> int& { return c.smoothing.passes; }));
}

void addFeaturesKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(choiceKey<Droplets>(
        {"features.droplets", "--droplets", "",
         "What to do with droplets: small groups of particles whose balls touch each other but no others. mesh: mesh "
         "them like everything else. points: leave them out of the mesh and write their particles to NAME.spheres.EXT "
         "with position, radius, velocity and id, to be rendered as spheres. drop: leave them out entirely."},
        {{"mesh", Droplets::mesh}, {"points", Droplets::points}, {"drop", Droplets::drop}},
        [](Config& c) -> Droplets& { return c.features.droplets; }));
    keys.push_back(integerKey(
        {"features.droplet_particles", "--droplet-particles", "",
         "A group with fewer particles than this is a droplet. Interior particles count; particles at the same "
         "position count once. 8 particles fill a cube two spacings wide, which is what a FLIP solver seeds per cell."},
        1, 1000000000, false, [](Config& c) -> int& { return c.features.droplet_particles; }));
    keys.push_back(choiceKey<Tendrils>(
        {"features.tendrils", "--tendrils", "",
         "What to do with tendrils one particle thick: particles that belong to no triangle of the alpha mesh but "
         "whose balls touch others. mesh: mesh them. points: leave them out of the mesh and write them as spheres "
         "beside it; whatever they connected stays in the mesh, however small."},
        {{"mesh", Tendrils::mesh}, {"points", Tendrils::points}},
        [](Config& c) -> Tendrils& { return c.features.tendrils; }));
    ConfigKey bubbles = choiceKey<Bubbles>(
        {"features.bubbles", "--bubbles", "",
         "What to do with small voids inside the liquid, which are mostly gaps in the sampling. fill: remove them and "
         "everything inside them from the mesh and leave the rest unchanged; complete tessellation only. mesh: give "
         "them a surface that faces inwards, as large voids have."},
        {{"mesh", Bubbles::mesh}, {"fill", Bubbles::fill}},
        [](Config& c) -> std::optional<Bubbles>& { return c.features.bubbles; });
    bubbles.get = [given = bubbles.get](const Config& c) { return c.features.bubbles ? given(c) : "fill"; };
    keys.push_back(bubbles);
    ConfigKey gap =
        lengthKey({"features.bubble_gap", "--bubble-gap", "",
                   "A void is small, and filled, if no empty ball of this diameter fits between its particles; in two "
                   "dimensions, no empty disc."},
                  "", [](Config& c) -> Length& { return c.features.bubble_gap; });
    gap.set = [setGap = gap.set](Config& config, const std::string& value) {
        setGap(config, value);
        config.features.bubble_volume = 0;
    };
    keys.push_back(gap);
    ConfigKey volume = positiveKey(
        {"features.bubble_volume", "--bubble-volume", "spacings cubed, in two dimensions squared",
         "Deprecated; use features.bubble_gap. Fills voids between the balls with a smaller volume than this. If both "
         "keys are set, the later one counts. auto: not set."},
        "auto, or a number above 0", std::numeric_limits<float>::max(), true,
        [](Config& c) -> double& { return c.features.bubble_volume; });
    volume.replaced_by = "features.bubble_gap";
    keys.push_back(volume);
}

void addSurfaceOutputKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(automaticBooleanKey(
        {"output.normals", "--output-normals", "",
         "Writes normals fitted to the surface near each vertex as the attribute `N`, which previews use, too. They "
         "shade far more smoothly than those of the triangles, and change continuously over time. auto: true in three "
         "dimensions with the complete tessellation, if the format can store them and no attribute `N` is carried. "
         ".vtp, .usda, .abc and .obj files have normals in any case, computed from the triangles where this is false."},
        [](Config& c) -> std::optional<bool>& { return c.output.normals; }));
    keys.push_back(namesKey(
        {"output.surface_attributes", "--surface-attributes", "",
         "Attributes of the mesh vertices that are measured on the surface; all change continuously over time. "
         "thickness: distance through the liquid, in world units, at most 4 particle spacings. curvature: mean "
         "curvature, in 1 / world units, positive on drops. shape: the weights `drop`, `thread`, `sheet` and `bulk`, "
         "from 0 to 1 with sum 1."},
        "some of thickness, curvature and shape, each at most once, separated by commas; or leave it empty",
        [](Config& c) -> std::vector<std::string>& { return c.output.surface_attributes; }, checkSurfaceAttributes));
}

}  // namespace betamesh
