// The keys that shape the surface.

#include "batch/config/kinds.h"
#include "batch/config/tables.h"

#include <limits>

namespace betamesh {

void addSurfaceKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(
        lengthKey({"surface.radius", "--radius", "world units, or particle spacings with dx",
                   "Of the balls. The paper uses 1.5 spacings: large enough to close the surface over still "
                   "liquid. Larger is smoother and joins drops earlier; smaller keeps detail and opens holes."},
                  "", [](Config& c) -> LengthText& { return c.surface.radius; }));
    keys.push_back(
        positiveKey({"surface.spacing", "--spacing", "world units",
                     "What dx stands for: the distance at which the simulation seeded its particles. auto: radius "
                     "/ 1.5 where the radius is a plain number, otherwise measured once, in the first frame on "
                     "disk that has seven distinct particles."},
                    "auto or a number above 0", std::numeric_limits<double>::max(), true,
                    [](Config& c) -> double& { return c.surface.spacing; }));
    keys.push_back(choiceKey<SurfaceKind>(
        {"surface.kind", "--surface", "",
         "beta: the method's result. alpha: triangles between the particles themselves, quick and rough. union: the "
         "balls "
         "as they are, the ground truth to look at."},
        {{"beta", SurfaceKind::beta}, {"alpha", SurfaceKind::alpha}, {"union", SurfaceKind::union_}},
        [](Config& c) -> SurfaceKind& { return c.surface.kind; }));
    keys.push_back(integerKey(
        {"surface.dimension", "--dimension", "",
         "3: balls and closed meshes. 2: discs and closed curves, for particles that all have the same z; written as "
         ".ply edges, .bgeo polylines, .obj lines, or drawn as .svg."},
        2, 3, false, [](Config& c) -> int& { return c.surface.dimension; }));
    keys.push_back(choiceKey<Tessellation>(
        {"surface.tessellation", "--tessellation", "",
         "How the faces become triangles. complete: all of them, so that the mesh is closed and manifold, and holds "
         "every sheet, tendril and drop. paper: fans around one vertex a face; drops and tendrils of single "
         "particles become spheres beside the mesh."},
        {{"complete", Tessellation::complete}, {"paper", Tessellation::paper}},
        [](Config& c) -> Tessellation& { return c.surface.tessellation; }));
    keys.push_back(
        integerKey({"surface.arc_subdivisions", "--arc-subdivisions", "segments",
                    "Complete tessellation: how finely the arcs between neighbouring balls are cut, and the "
                    "faces with them; in two dimensions an eighth of how often a circle is cut. auto: so "
                    "that no arc is missed by more than 0.01 radii, 0.02 where smoothing lays the surface flat. "
                    "1 makes meshes small."},
                   1, 64, true, [](Config& c) -> int& { return c.surface.arc_subdivisions; }));
    keys.push_back(choiceKey<PredicateKind>({"surface.predicates", "--predicates", "",
                                             "exact: signs are computed exactly and ties broken by rule, which never "
                                             "fails. float: the paper's test in double "
                                             "precision, repeated on jittered particles while its result is invalid."},
                                            {{"exact", PredicateKind::exact}, {"float", PredicateKind::floating}},
                                            [](Config& c) -> PredicateKind& { return c.surface.predicates; }));
    keys.push_back(optionalLengthKey(
        {"surface.skin", "--skin", "world units, or particle spacings with dx",
         "How far the surface lies from the outermost particles; less than the radius. auto: the mesh "
         "encloses the volume of the liquid. none: the surface is that of the balls themselves, a radius "
         "outside the particles, so sheets are two radii thick. A length needs surface.kind beta with the "
         "complete tessellation; otherwise auto is the same as none."},
        "none", [](Config& c) -> std::optional<LengthText>& { return c.surface.skin; }));
    ConfigKey inset = optionalLengthKey(
        {"surface.inset", "--inset", "world units, or particle spacings with dx",
         "Deprecated, use surface.skin: an inset D is the same as a skin of radius - D. auto: not set."},
        "0", [](Config& c) -> std::optional<LengthText>& { return c.surface.inset; });
    inset.replaced_by = "surface.skin";
    keys.push_back(inset);
    keys.push_back(booleanKey(
        {"surface.resolve_intersections", "--resolve-intersections", "",
         "The paper's step 4, for its tessellation: move vertices out to particles that smoothing left outside. The "
         "complete tessellation leaves none outside."},
        [](Config& c) -> bool& { return c.surface.resolve_intersections; }));
}

void addPerturbationKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(integerKey({"perturbation.retries", "--retries", "",
                               "float predicates only: how often a frame is jittered and tried again before it fails."},
                              0, 100, false, [](Config& c) -> int& { return c.perturbation.retries; }));
    keys.push_back(positiveKey(
        {"perturbation.tolerance", "--tolerance", "multiples of the radius",
         "float predicates only: the size of the jitter. Larger succeeds sooner and moves the surface "
         "more."},
        "a number above 0, at most 0.1", 0.1, false, [](Config& c) -> double& { return c.perturbation.tolerance; }));
}

void addSmoothingKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(choiceKey<SmoothingMethod>(
        {"smoothing.method", "--smoothing", "",
         "coherent: vertices move onto spheres fitted to the surface round them, which calms "
         "the bumps of the balls, keeps drops and sheets, and never jumps in time. paper: to "
         "the weighted centroids of the faces around them, on the paper's tessellation. "
         "none: they stay on the balls."},
        {{"coherent", SmoothingMethod::coherent}, {"paper", SmoothingMethod::paper}, {"none", SmoothingMethod::none}},
        [](Config& c) -> SmoothingMethod& { return c.smoothing.method; }));
    keys.push_back(lengthKey(
        {"smoothing.width", "--smoothing-width", "world units, or particle spacings with dx",
         "Coherent smoothing: how far around it a vertex looks. Bumps much shorter than this vanish, waves twice as "
         "long stay. auto: 5.8dx."},
        "auto", [](Config& c) -> LengthText& { return c.smoothing.width; }));
    keys.push_back(
        integerKey({"smoothing.passes", "--passes", "",
                    "How often the surface is smoothed. The paper uses 1; each further pass costs detail and "
                    "volume."},
                   0, 100, false, [](Config& c) -> int& { return c.smoothing.passes; }));
}

void addFeaturesKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(choiceKey<Droplets>(
        {"features.droplets", "--droplets", "",
         "What becomes of droplets, groups of few particles whose balls meet each other and no others. mesh: they get "
         "a "
         "surface like everything else. points: they are left out of the mesh, and their particles written beside it "
         "as NAME.spheres.EXT with position, radius, velocity and id, to be rendered as spheres. drop: they are left "
         "out."},
        {{"mesh", Droplets::mesh}, {"points", Droplets::points}, {"drop", Droplets::drop}},
        [](Config& c) -> Droplets& { return c.features.droplets; }));
    keys.push_back(integerKey(
        {"features.droplet_particles", "--droplet-particles", "particles",
         "Groups of fewer particles are droplets. All particles count, also those inside; several at one place are "
         "one. 8 make a cube two spacings wide, what a FLIP solver seeds in one cell."},
        1, 1000000000, false, [](Config& c) -> int& { return c.features.droplet_particles; }));
    keys.push_back(choiceKey<Tendrils>(
        {"features.tendrils", "--tendrils", "",
         "What becomes of threads a single particle thick: particles in no triangle of the alpha mesh whose balls meet "
         "others. mesh: they get a surface. points: they are left out of the mesh and written as spheres beside it. "
         "What they held together stays in the mesh, however small."},
        {{"mesh", Tendrils::mesh}, {"points", Tendrils::points}},
        [](Config& c) -> Tendrils& { return c.features.tendrils; }));
    ConfigKey bubbles = choiceKey<Bubbles>(
        {"features.bubbles", "--bubbles", "",
         "What becomes of small voids inside the liquid, which are mostly gaps in the sampling. fill: they"
         " are left out of the mesh with everything inside them, and the rest of it stays as it is; "
         "complete tessellation only. mesh: they get a surface that faces inwards, like large voids."},
        {{"mesh", Bubbles::mesh}, {"fill", Bubbles::fill}},
        [](Config& c) -> std::optional<Bubbles>& { return c.features.bubbles; });
    bubbles.get = [given = bubbles.get](const Config& c) { return c.features.bubbles ? given(c) : "fill"; };
    keys.push_back(bubbles);
    ConfigKey gap =
        lengthKey({"features.bubble_gap", "--bubble-gap", "world units, or particle spacings with dx",
                   "A void is small, and filled, if no empty ball of this diameter fits between its particles; in "
                   "two dimensions, no empty disc."},
                  "", [](Config& c) -> LengthText& { return c.features.bubble_gap; });
    gap.set = [setGap = gap.set](Config& config, const std::string& value) {
        setGap(config, value);
        config.features.bubble_volume = 0;
    };
    keys.push_back(gap);
    ConfigKey volume =
        positiveKey({"features.bubble_volume", "--bubble-volume", "spacings cubed, in two dimensions squared",
                     "Deprecated, use features.bubble_gap: fills voids between the balls of less than this volume. "
                     "Whichever of the two keys is set later counts. auto: not set."},
                    "auto or a number above 0", std::numeric_limits<double>::max(), true,
                    [](Config& c) -> double& { return c.features.bubble_volume; });
    volume.replaced_by = "features.bubble_gap";
    keys.push_back(volume);
}

}  // namespace betamesh
