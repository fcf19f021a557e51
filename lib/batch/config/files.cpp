// The keys of what is read and written, and how a job runs.

#include "batch/config/kinds.h"
#include "batch/config/presets.h"
#include "batch/config/tables.h"
#include "batch/job/frames.h"
#include "batch/job/plane.h"
#include "io/curve_file.h"
#include "io/particle_file.h"

namespace betamesh {
namespace {

void checkInputPath(const std::string& path) {
    if (path.empty()) return;
    framePattern(path);
    requireParticleExtension(path);
}

void checkOutputPath(const std::string& path) {
    if (path.empty()) return;
    framePattern(path);
    requireCurveExtension(path);  // meshes have no more
}
void checkFrames(const std::string& frames) {
    if (frames != "all") parseFrames(frames);
}
}  // namespace

void addPresetKey(std::vector<ConfigKey>& keys) {
    ConfigKey key =
        namesKey({"preset", "--preset", "",
                  "Settings for a kind of simulation; `betamesh config presets` lists them. Of several, later ones "
                  "win. Included files, the keys of a pipeline file and options all override presets."},
                 "names of presets, each once, with commas between them; or empty",
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
         "The particles, one file a frame. The frame number stands at #### or @@@@ (a digit each), %04d, "
         "$F4 or $F; numbers with more digits are written in full. A relative path starts at the folder "
         "in which the command runs."},
        "a path ending in .vdb, .bgeo, .bgeo.gz or .ply; needed by `run`",
        [](Config& c) -> std::string& { return c.input.path; }, checkInputPath));
    keys.push_back(textKey({"input.velocity", "--velocity", "world units per second",
                            "The attribute that is the velocity. Empty: the first of v, velocity, vel; where none "
                            "exists, zero velocities are written and a warning says so. A name given here must exist."},
                           "the name of an attribute with three components, or empty",
                           [](Config& c) -> std::string& { return c.input.velocity; }));
    keys.push_back(textKey(
        {"input.id", "--id", "",
         "The attribute that stays with a particle from frame to frame. Empty: id, where it exists. A "
         "name given here must exist."},
        "the name of a whole-number attribute, or empty", [](Config& c) -> std::string& { return c.input.id; }));
    keys.push_back(textKey(
        {"frames", "--frames", "",
         "Which frames to mesh; all: every frame found on disk. A step is written x, as in 1-100x2; ':' "
         "is refused because farm engines disagree about it."},
        "all, or frames such as 12, 1-100, 1-100x2, -5--1, 1-10,15,20-30",
        [](Config& c) -> std::string& { return c.frames; }, checkFrames));
}

void addOutputKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(textKey(
        {"output.path", "", "",
         "The meshes, one file a frame, with a place for the frame number as in input.path. Beside each "
         "stand NAME.json, its report, and NAME.spheres.EXT where particles are left out of the mesh as spheres."},
        "a path ending in .ply, .bgeo, .bgeo.gz or .obj, in two dimensions also .svg; needed by `run`",
        [](Config& c) -> std::string& { return c.output.path; }, checkOutputPath));
    keys.push_back(namesKey(
        {"output.attributes", "--attributes", "",
         "Attributes of the particles, such as Cd or temperature, that the mesh's vertices get too: means over the "
         "particles near them; whole numbers from the nearest. Accelerations (accel, acceleration) are carried "
         "unasked."},
        "names of attributes that every input has, each once, with commas between them; or empty",
        [](Config& c) -> std::vector<std::string>& { return c.output.attributes; }));
    keys.push_back(booleanKey(
        {"output.components", "--components", "",
         "Numbers the connected pieces of each mesh by volume, 0 the largest, bubbles last: a whole number `component` "
         "of every face in .ply and of every primitive in .bgeo, objects component_N in .obj. Numbers change from "
         "frame to frame."},
        [](Config& c) -> bool& { return c.output.components; }));
}

void addPictureKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(namesKey(
        {"picture.layers", "--layers", "",
         "What an .svg shows, in two dimensions. discs: their union. particles: dots. alpha: the alpha mesh. before: "
         "the curves before smoothing, dotted. beta: the curves. vertices: theirs, pure beta vertices red, alphabeta "
         "vertices blue."},
        "some of discs, particles, alpha, before, beta, vertices, each once, with commas between them",
        [](Config& c) -> std::vector<std::string>& { return c.picture.layers; }, [](const auto& n) { layersOf(n); }));
    keys.push_back(textKey(
        {"picture.bounds", "--bounds", "world units",
         "The part of the plane that an .svg shows: lowest x, lowest y, highest x, highest y. auto: all discs, of each "
         "frame for itself."},
        "auto or four numbers with commas between them", [](Config& c) -> std::string& { return c.picture.bounds; },
        [](const std::string& text) { boundsOf(text); }));
}

void addRunKeys(std::vector<ConfigKey>& keys) {
    keys.push_back(integerKey(
        {"run.frames_in_flight", "--frames-in-flight", "frames",
         "How many frames are worked on at once, at most; fewer where memory is short. auto: as many as there "
         "are threads. The meshes do not depend on it."},
        1, 4096, true, [](Config& c) -> int& { return c.run.frames_in_flight; }));
    keys.push_back(
        integerKey({"run.threads", "-j,--threads", "threads",
                    "auto: the processors this process may use, or fewer if SLURM_CPUS_PER_TASK or CUE_THREADS "
                    "says so. The meshes do not depend on it."},
                   1, 4096, true, [](Config& c) -> int& { return c.run.threads; }));
    keys.push_back(
        integerKey({"run.retries", "--io-retries", "",
                    "How often reading or writing a frame is tried again, after a short wait, before the frame "
                    "fails: shared disks stumble."},
                   0, 100, false, [](Config& c) -> int& { return c.run.retries; }));
    keys.push_back(realKey({"run.timeout", "--timeout", "seconds",
                            "How long a frame may take, from reading to writing; one that takes longer fails, the "
                            "others are written. Servers that are gone never answer. A farm's own limit ends a "
                            "whole task. 0: as long as it takes."},
                           0, 604800, [](Config& c) -> double& { return c.run.timeout; }));
    keys.push_back(
        choiceKey<OnMissing>({"run.on_missing", "--on-missing", "",
                              "What a frame without an input file is. error: it fails, the others are written. skip: "
                              "it is left out. empty: an "
                              "empty mesh is written for it."},
                             {{"error", OnMissing::error}, {"skip", OnMissing::skip}, {"empty", OnMissing::empty}},
                             [](Config& c) -> OnMissing& { return c.run.on_missing; }));
    keys.push_back(bytesKey(
        {"run.memory_limit", "--memory-limit", "bytes",
         "Memory for all frames together. A frame starts when its estimated memory fits; of a frame that is too large, "
         "only the particles near its surface are kept in memory. auto: what the machine, its container or Slurm "
         "grants. A size given here is also enforced: a frame that needs more fails, and the job ends with exit code "
         "33."},
        [](Config& c) -> std::uint64_t& { return c.run.memory_limit; }));
    ConfigKey scratch = textKey({"run.scratch", "--scratch", "", "Deprecated, has no effect."}, "any text",
                                [](Config& c) -> std::string& { return c.run.scratch; });
    scratch.replaced_by = "run.memory_limit";
    keys.push_back(scratch);
}

}  // namespace betamesh
