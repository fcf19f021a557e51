#include "batch/job/plan.h"
#include "batch/job/preview.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "io/particle_file.h"
#include "picture_options.h"
#include "render/contact_sheet.h"
#include "render/png_file.h"

#include <iterator>
#include <memory>
#include <sstream>
#include <utility>

namespace betamesh {
namespace {

constexpr const char* kPanels[] = {
    "union of balls: preview.show=union",
    "alpha mesh: surface.kind=alpha surface.skin=none preview.normals=flat",
    "beta mesh (paper): surface.tessellation=paper smoothing.method=paper surface.skin=none features.droplets=mesh "
    "features.tendrils=mesh features.bubbles=mesh",
    "beta mesh (ours):",
};

Plan planOf(Config config, const PictureWorker& worker) {
    if (config.surface.dimension != 3) throw Error("surface.dimension is 2; expected 3, for pictures are of surfaces");
    config.output.path = "nothing.####.ply";  // nothing is written
    config.preview.path = "nothing.####.png";
    PlanOptions any;
    any.overwrite = true;
    any.history.unmeasured = worker.history.unmeasured;
    any.history.last_loss = worker.history.last_loss;
    any.notes = worker.notes;
    return planJob(config, any);
}

/// The same with everything decided that is to be the same in all panels, unless they say otherwise.
Config decided(Config config, const Plan& plan) {
    const Camera& camera = plan.preview->camera;
    const RenderSettings& settings = plan.preview->settings;
    Config::Preview& preview = config.preview;
    config.surface.spacing = plan.spacing;
    if (std::exchange(config.surface.inset, {})) config.surface.skin = LengthText{plan.skin.skin.value_or(0), false};
    preview.camera_position = {camera.position.x, camera.position.y, camera.position.z};
    preview.look_at = {camera.look_at.x, camera.look_at.y, camera.look_at.z};
    preview.ground = settings.ground ? Config::Preview::Ground::given : Config::Preview::Ground::none;
    preview.ground_height = settings.ground.value_or(0);
    preview.colour_range = {settings.colouring.low, settings.colouring.high};
    return config;
}

/// What stands under a picture, and how it is made.
struct Panel {
    std::string caption;
    Plan plan;
};

/// "CAPTION: key=value key=value": all else is as in usual.
Panel panelOf(const std::string& text, Config usual, const PictureWorker& worker) {
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos)
        throw Error("--panel '" + text + "': expected a caption, a colon, and any number of key=value");
    std::istringstream words(text.substr(colon + 1));
    for (std::string word; words >> word;) setConfigKey(usual, word);
    return {text.substr(0, colon), planOf(usual, worker)};
}

Picture pictured(const Plan& plan, const Particles& particles) {
    const PreviewPlan& preview = *plan.preview;
    if (plan.config.preview.show != ShownGeometry::surface)  // smooth balls, rather than what is tessellated
        return renderFrame({}, ballsOf(particles, preview.ball), preview.camera, preview.settings);
    const SkinnedFrame skinned = skinFrame(particles, plan.skin);
    return renderFrame(skinned.mesh, skinned.spheres, preview.camera, preview.settings);
}

/// texts: of panels; empty: the four.
int compare(const PictureJob& job, std::vector<std::string> texts, int columns, const PictureWorker& worker) {
    const Plan plan = planOf(job.config, worker);
    for (const std::string& warning : plan.warnings) logWarning(warning);
    for (const std::string& note : plan.notes) logInfo(note);
    if (texts.empty()) texts.assign(std::begin(kPanels), std::end(kPanels));
    std::vector<Panel> panels;
    for (const std::string& text : texts) panels.push_back(panelOf(text, decided(job.config, plan), worker));
    return writePictures(job, worker, [&](const PictureTask& task) {
        const Particles particles = readParticles(task.input, {job.config.input.velocity, job.config.input.id});
        std::vector<CaptionedImage> images;
        for (const Panel& panel : panels) images.push_back({toneMapped(pictured(panel.plan, particles)), panel.caption});
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
        "Pictures on a sheet, each of --width x --height (without --pipeline, 960 x 540 by default).\n"
        "Examples:\n"
        "  betamesh compare sim/splash.0012.vdb splash.png\n"
        "  betamesh compare sim/splash.0012.vdb skin.png --panel 'as it is:' --panel 'full balls: surface.skin=none'\n"
        "  betamesh compare 'sim/splash.####.vdb' look/splash.####.png --frames 1-24 --movie splash.mp4");
    const auto options = std::make_shared<PictureOptions>();
    options->outputs.resize(1);
    command
        ->add_option("IN", options->input,
                     "Particles (.vdb .bgeo .bgeo.gz .ply), with a place for the frame number where there are several.")
        ->required();
    command->add_option("OUT", options->outputs[0], "Pictures (.png).")->required();
    const auto texts = std::make_shared<std::vector<std::string>>();
    command
        ->add_option("--panel", *texts,
                     "Another picture instead of the four: what stands under it, and the keys that make it differ from "
                     "what the other options say. Repeat it for each.")
        ->type_name("'CAPTION: KEY=VALUE ...'")
        ->expected(1)
        ->take_all()
        ->group("Picture");
    const auto columns = std::make_shared<int>(2);
    command->add_option("--columns", *columns, "How many pictures stand side by side (default 2).")
        ->type_name("N")
        ->check(CLI::Range(1, 100))
        ->group("Picture");
    addPictureOptions(*command, *options, [&](const ConfigKey& key) {
        if (key.path == "preview.show" || key.path == "preview.particle_radius" || key.path == "surface.kind")
            return false;
        for (const char* section : {"preview.", "input.", "surface.", "perturbation.", "smoothing.", "features."})
            if (key.path.starts_with(section)) return true;
        return key.path == "preset" || key.path == "frames" || key.path == "run.threads" || key.path == "run.timeout";
    });
    command->callback([options, texts, columns, &exit_code] {
        if (isExr(options->outputs[0])) throw Error("'" + options->outputs[0] + "': captions need a .png");
        Config usual;
        usual.preview.width = 960, usual.preview.height = 540;
        const PictureJob job = planPictures(*options, usual);
        exit_code =
            inPictureWorker(job, [&](const PictureWorker& worker) { return compare(job, *texts, *columns, worker); });
    });
}

}  // namespace betamesh
