#include "batch/log.h"
#include "batch/plan.h"
#include "batch/preview.h"
#include "command.h"
#include "core/error.h"
#include "core/parallel.h"
#include "io/particle_file.h"
#include "picture_options.h"
#include "preview/contact_sheet.h"
#include "preview/png_file.h"

#include <memory>

namespace betamesh {
namespace {

struct Panel {
    const char* caption;
    SurfaceKind surface;
    Tessellation tessellation;
    SmoothingMethod smoothing;
    bool flat;
};

/// The last one as the options say.
std::vector<Panel> panelsOf(const SkinParams& ours) {
    return {{"union of balls", SurfaceKind::union_, Tessellation::complete, SmoothingMethod::none, false},
            {"alpha mesh", SurfaceKind::alpha, Tessellation::complete, SmoothingMethod::none, true},
            {"beta mesh (paper)", SurfaceKind::beta, Tessellation::paper, SmoothingMethod::paper, false},
            {"beta mesh (ours)", SurfaceKind::beta, ours.tessellation, ours.smoothing, false}};
}

Picture pictured(const Panel& panel, const Particles& particles, const SkinParams& ours, const PreviewPlan& plan) {
    if (panel.surface == SurfaceKind::union_)  // smooth balls, rather than what is tessellated
        return renderFrame({}, ballsOf(particles, ours.radius), plan.camera, plan.look);
    SkinParams params = ours;
    params.surface = panel.surface;
    if (panel.smoothing != ours.smoothing || panel.tessellation != ours.tessellation) {
        params.inset = 0;
        params.features = {};
    }
    params.tessellation = panel.tessellation;
    params.smoothing = panel.smoothing;
    const SkinnedFrame skinned = skinFrame(particles, params);
    Look look = plan.look;
    look.flat = look.flat || panel.flat;
    return renderFrame(skinned.mesh, skinned.spheres, plan.camera, look);
}

int compare(const PictureJob& job, const SkinParams& skin, int columns) {
    Extent extent(job.config.preview);
    if (needsExtent(job.config)) extent = extentOf(job.on_disk, job.config, skin.radius);
    const PreviewPlan plan = planPreview(job.config, extent, skin.radius);
    logInfo("camera " + describe(plan));
    return writePictures(job, [&](const PictureTask& task) {
        const Particles particles = readParticles(task.input, {job.config.input.velocity, job.config.input.id});
        std::vector<CaptionedImage> images;
        for (const Panel& panel : panelsOf(skin))
            images.push_back({developed(pictured(panel, particles, skin, plan)), panel.caption});
        Drawn drawn{{}, contactSheet(images, columns)};
        drawn.files.push_back(encodePng(drawn.image));
        return drawn;
    });
}

}  // namespace

void addCompareCommand(CLI::App& program, int& exit_code) {
    CLI::App* command = program.add_subcommand(
        "compare", "The same frame as union of balls, alpha mesh, beta mesh of the paper and of this program.");
    command->footer(
        "Four pictures on a sheet, each of --width x --height (without --pipeline, 960 x 540 by default).\n"
        "Examples:\n"
        "  betamesh compare sim/splash.0012.vdb splash.png\n"
        "  betamesh compare 'sim/splash.####.vdb' look/splash.####.png --frames 1-24 --movie splash.mp4");
    const auto options = std::make_shared<PictureOptions>();
    options->outputs.resize(1);
    command
        ->add_option("IN", options->input,
                     "Particles (.vdb .bgeo .bgeo.gz .ply), with a place for the frame number where there are several.")
        ->required();
    command->add_option("OUT", options->outputs[0], "Pictures (.png).")->required();
    const auto columns = std::make_shared<int>(2);
    command->add_option("--columns", *columns, "How many of the four stand side by side: 1, 2 (default) or 4.")
        ->type_name("N")
        ->check(CLI::IsMember({1, 2, 4}))
        ->group("Picture");
    addPictureOptions(*command, *options, [&](const ConfigKey& key) {
        if (key.path == "preview.show" || key.path == "preview.particle_radius" || key.path == "surface.kind")
            return false;
        for (const char* section : {"preview.", "input.", "surface.", "perturbation.", "smoothing.", "features."})
            if (key.path.starts_with(section)) return true;
        return key.path == "frames" || key.path == "run.threads";
    });
    command->callback([options, columns, &exit_code] {
        if (isExr(options->outputs[0])) throw Error("'" + options->outputs[0] + "': captions need a .png");
        Config usual;
        usual.preview.width = 960, usual.preview.height = 540;
        const PictureJob job = planPictures(*options, usual);
        Config config = job.config;
        config.output.path = "nothing.####.ply";  // nothing is written
        config.preview.path.clear();
        PlanOptions any;
        any.overwrite = true;
        const Plan plan = planJob(config, any);
        for (const std::string& warning : plan.warnings) logWarning(warning);
        for (const std::string& note : plan.notes) logInfo(note);
        withThreads(threadsOf(job.config), [&] { exit_code = compare(job, plan.skin, *columns); });
    });
}

}  // namespace betamesh
