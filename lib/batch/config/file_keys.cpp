// Configuration keys of inputs and outputs, and of how a job runs.

#include "batch/config/key_tables.h"
#include "batch/config/key_types.h"
#include "batch/config/presets.h"
#include "batch/job/frames.h"
#include "batch/job/plane.h"
#include "io/extension.h"
#include "io/mesh_file.h"
#include "io/svg.h"

namespace betamesh {
namespace {

void checkInputPath(const std::string& path) {
    if (!path.empty()) formatOf(inputPattern(path).text, FileKind::particles, Access::read);
}

void checkOutputPath(const std::string& path) {
    if (path.empty()) return;
    framePattern(path);
    if (!isSvg(path)) requireMeshExtension(path);  // curves are written in every format for meshes, too
}

void checkFrames(const std::string& frames) {
    if (frames != "all") parseFrames(frames);
}

}  // namespace

void addPresetKey(std::vector<ConfigKey>& keys) {
    ConfigKey key = namesKey(
        {"preset", "--preset", "",
         "Settings for a kind of simulation; `betamesh config presets` lists them. When several are given, later ones "
         "win. Included files, the keys of the pipeline file and options all override presets."},
        "names of presets, each at most once, separated by commas; or leave it empty",
        [](Config& c) -> std::vector<std::string>& { return c.preset; });
    key.set = [setNames = key.set](Config& config, const std::string& value) {
        setNames(config, value);
        for (const std::string& name : std::vector<std::string>(config.preset)) applyPreset(config, name);
    };
    keys.push_back(key);
}

void addInputKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(textKey(
        {"input.path", "", "",
         "Particle files, one per frame. The frame number is written as #### or @@@@ (one digit each), %04d, $F4 or "
         "$F, in names of files and folders; numbers with more digits are written in full. A folder stands for the "
         "sequence in it. $NAME and ${NAME} are environment variables, and ~/ at the beginning is the home folder. A "
         "relative path starts in the folder in which the command runs."},
        "a path ending in one of " + extensionsFor(FileKind::particles, Access::read) + "; `betamesh run` requires it",
        [](Config& c) -> std::string& { return c.input.path; }, checkInputPath));
    addParticleKeys(keys);
    keys.push_back(textKey(
        {"frames", "--frames", "",
         "Frames to process. all: every frame found on disk, or in a file that holds several. A step is written with "
         "x, as in 1-100x2; a colon is "
         "refused because farm engines disagree about its meaning."},
        "all, or frames such as 12, 1-100, 1-100x2, -5--1 or 1-10,15,20-30",
        [](Config& c) -> std::string& { return c.frames; }, checkFrames));
}

void addOutputKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(textKey(
        {"output.path", "", "",
         "Mesh files, one per frame, with the frame number written as in input.path. Beside each mesh the job writes "
         "its manifest NAME.json, and NAME.spheres.EXT if particles are left out of the mesh as spheres."},
        "a path ending in one of " + extensionsFor(FileKind::mesh, Access::write) +
            ", in two dimensions also .svg but not .stl; `betamesh run` requires it",
        [](Config& c) -> std::string& { return c.output.path; }, checkOutputPath));
    keys.push_back(namesKey(
        {"output.attributes", "--attributes", "",
         "Particle attributes, such as Cd or temperature, to transfer to the mesh vertices. Real numbers are averaged "
         "over nearby particles, whole numbers are taken from the nearest one. accel and acceleration are always "
         "transferred."},
        "names of attributes that every input has, each at most once, separated by commas; or leave it empty",
        [](Config& c) -> std::vector<std::string>& { return c.output.attributes; }));
    addSurfaceOutputKeys(keys);
    keys.push_back(booleanKey(
        {"output.components", "--components", "",
         "Numbers the connected components of each mesh by volume: 0 is the largest, bubbles come last. The number is "
         "the whole-number attribute `component` of faces (.ply, .vtp, .usda, .abc) or primitives (.bgeo), or "
         "an object component_N (.obj). A component may get another number in the next frame."},
        [](Config& c) -> bool& { return c.output.components; }));
    keys.push_back(lengthKey(
        {"output.simplify", "--simplify", "",
         "Leaves out vertices where the surface is flat: no point of it moves farther than this. 0.01dx is invisible. "
         "It keeps 43 % of the triangles of a splash and 25 % of calm water, and takes twice as long as meshing. The "
         "other vertices keep their position, velocity and attributes. Meshes only, not curves."},
        "none", [](Config& c) -> Length& { return c.output.simplify; }));
    keys.push_back(choiceKey<UpAxis>(
        {"output.up_axis", "--output-up-axis", "",
         "Axis that points up in the files that are written. y: nothing is rotated. z: positions, velocities, "
         "accelerations and normals are rotated by 90 degrees about x, (x, y, z) becomes (x, -z, y), which undoes "
         "input.up_axis z. Previews and .svg drawings are not rotated."},
        {{"y", UpAxis::y}, {"z", UpAxis::z}}, [](Config& c) -> UpAxis& { return c.output.up_axis; }));
    keys.push_back(positiveKey(
        {"output.fps", "--output-fps", "frames per second",
         "Frame rate of the sequence, which formats with a time line store. Velocities are per second and do not "
         "depend on it."},
        "a number above 0, at most 10000", 10000, false,
        [](Config& c) -> double& { return c.output.frames_per_second; }));
    keys.push_back(positiveKey(
        {"output.meters_per_unit", "--meters-per-unit", "metres",
         "Length of a world unit, which formats with a unit of length store: 0.01 for centimetres. Numbers are not "
         "scaled; input.scale does that."},
        "a number above 0", std::numeric_limits<float>::max(), false,
        [](Config& c) -> double& { return c.output.meters_per_unit; }));
    keys.push_back(lengthKey({"output.voxel", "--voxel", "",
                              "Voxel size of level sets, which .vdb outputs are. Smaller voxels keep thinner sheets; "
                              "file and memory grow with the inverse square of it."},
                             "", [](Config& c) -> Length& { return c.output.voxel; }));
    keys.push_back(
        realKey({"output.band", "--band", "voxels",
                 "Half width of the narrow band of level sets: distances up to this far from the surface are "
                 "stored, on both sides."},
                1, 100, [](Config& c) -> double& { return c.output.level_set.band; }));
    keys.push_back(booleanKey({"output.velocity_grid", "--velocity-grid", "",
                               "Writes the grid `v` beside a level set: the velocity of the nearest point of the "
                               "surface, in the voxels of the narrow band."},
                              [](Config& c) -> bool& { return c.output.level_set.velocity; }));
}

void addPictureKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(namesKey(
        {"picture.layers", "--layers", "",
         "Layers of an .svg drawing, in two dimensions. discs: the union of the discs. particles: dots. alpha: the "
         "alpha mesh. before: the curves before smoothing, dotted. beta: the curves. vertices: their vertices, pure "
         "beta vertices in red and alphabeta vertices in blue."},
        "some of discs, particles, alpha, before, beta and vertices, each at most once, separated by commas",
        [](Config& c) -> std::vector<std::string>& { return c.picture.layers; },
        [](const auto& names) { parseLayers(names); }));
    keys.push_back(textKey(
        {"picture.bounds", "--bounds", "world units",
         "Part of the plane that an .svg drawing shows: lowest x, lowest y, highest x, highest y. auto: the bounding "
         "box of the discs, separately for each frame."},
        "auto, or four numbers separated by commas", [](Config& c) -> std::string& { return c.picture.bounds; },
        [](const std::string& text) { parseBounds(text); }));
}

void addRunKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(integerKey(
        {"run.frames_in_flight", "--frames-in-flight", "",
         "How many frames may be processed at the same time; fewer run when memory is short. auto: as many as there "
         "are threads. This setting does not change the meshes."},
        1, 4096, true, [](Config& c) -> int& { return c.run.frames_in_flight; }));
    keys.push_back(integerKey(
        {"run.threads", "-j,--threads", "",
         "Number of threads. auto: the processors that this process may use, or fewer if SLURM_CPUS_PER_TASK or "
         "CUE_THREADS says so. This setting does not change the meshes."},
        1, 4096, true, [](Config& c) -> int& { return c.run.threads; }));
    keys.push_back(integerKey(
        {"run.retries", "--io-retries", "",
         "How many times reading or writing a frame is tried again, after a short pause, before the frame fails. "
         "Network storage sometimes fails for a moment."},
        0, 100, false, [](Config& c) -> int& { return c.run.retries; }));
    keys.push_back(realKey(
        {"run.timeout", "--timeout", "seconds",
         "Time limit for each frame, from reading to writing, in case a file server stops responding. A frame that "
         "takes longer fails; the others are written. 0: no limit."},
        0, 604800, [](Config& c) -> double& { return c.run.timeout; }));
    keys.push_back(choiceKey<OnMissing>(
        {"run.on_missing", "--on-missing", "",
         "What to do with a frame whose input file is missing. error: the frame fails; the others are written. skip: "
         "leave it out. empty: write an empty mesh."},
        {{"error", OnMissing::error}, {"skip", OnMissing::skip}, {"empty", OnMissing::empty}},
        [](Config& c) -> OnMissing& { return c.run.on_missing; }));
    keys.push_back(bytesKey(
        {"run.memory_limit", "--memory-limit", "bytes",
         "Memory for all frames together. A frame starts when its estimated memory fits; if a frame is too large, "
         "only the particles near its surface are kept in memory. auto: what the machine, its container or Slurm "
         "grants. A size given here is also enforced, not counting some 30 MiB of the program itself: a frame that "
         "needs more fails, and the job ends with exit code 33."},
        [](Config& c) -> std::uint64_t& { return c.run.memory_limit; }));
    ConfigKey scratch = textKey({"run.scratch", "--scratch", "", "Deprecated, has no effect."}, "any text",
                                [](Config& c) -> std::string& { return c.run.scratch; });
    scratch.replaced_by = "run.memory_limit";
    keys.push_back(scratch);
}

}  // namespace betamesh
