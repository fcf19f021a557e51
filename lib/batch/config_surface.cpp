// The keys that shape the surface.

#include "batch/config_kinds.h"
#include "batch/config_tables.h"

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
    keys.push_back(lengthKey(
        {"surface.inset", "--inset", "world units, or particle spacings with dx",
         "Takes the surface inwards, less where the liquid is thin: the balls reach a radius beyond their particles, "
         "so "
         "sheets are two radii thick. At most the radius less half a spacing, which leaves half a spacing of liquid "
         "round the outermost particles. 0 keeps the volume of the balls."},
        "0", [](Config& c) -> LengthText& { return c.surface.inset; }));
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
         "long stay. auto: 2.8 radii, which is 4.2dx at the default radius."},
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
    keys.push_back(choiceKey<Bubbles>(
        {"features.bubbles", "--bubbles", "",
         "What becomes of small voids inside the liquid. mesh: they get a surface that faces inwards. fill: they, and "
         "what is in them, are left out of the mesh; complete tessellation only. The rest of the mesh stays as it is."},
        {{"mesh", Bubbles::mesh}, {"fill", Bubbles::fill}}, [](Config& c) -> Bubbles& { return c.features.bubbles; }));
    keys.push_back(positiveKey(
        {"features.bubble_volume", "--bubble-volume", "spacings cubed, in two dimensions squared",
         "Voids of less volume, before smoothing and inset, are filled. One spacing cubed is what a particle stands "
         "for, "
         "so that 8 treats bubbles as features.droplet_particles treats droplets. The balls narrow a void by a radius "
         "all round: 8 is a gap in the particles about 5 spacings wide."},
        "a number above 0", std::numeric_limits<double>::max(), false,
        [](Config& c) -> double& { return c.features.bubble_volume; }));
}

}  // namespace betamesh
