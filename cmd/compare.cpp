#include "batch/job/plan.h"
#include "batch/job/render_frames.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "help.h"
#include "io/extension.h"
#include "io/particle_file.h"
#include "preview_options.h"
#include "render/contact_sheet.h"
#include "render/png_file.h"
#include "value_checks.h"

#include <iterator>
#include <memory>
#include <sstream>
#include <utility>

namespace betamesh {
namespace {

constexpr const char* kDefaultPanels[] = {
    "union of balls: preview.show=union",
    "alpha mesh: surface.kind=alpha surface.skin=none preview.normals=flat",
    ("beta mesh (paper): surface.tessellation=paper smoothing.method=paper surface.skin=none features.droplets=mesh "
     "features.tendrils=mesh features.bubbles=mesh"),
    "beta mesh (ours):",
};
constexpr int kPanelWidth = 960, kPanelHeight = 540;  // pixels

std::string panelSize() { return std::to_string(kPanelWidth) + " x " + std::to_string(kPanelHeight); }

Plan planOf(Config config, const PreviewWorker& worker) {
    if (config.surface.dimension != 3) throw Error("surface.dimension is 2, but only surfaces can be compared. Use 3.");
    config.output.path = "nothing.####.ply";  // planning needs a path; no file is written
    config.preview.path = "nothing.####.png";
    PlanOptions options;
    options.overwrite = true;
    options.history.unmeasured = worker.history.unmeasured;
    options.history.last_loss = worker.history.last_loss;
    options.events = worker.events;
    return planOutputs(config, options).front();
}

/// The configuration with the automatic values that all panels share replaced by those of the plan.
Config withSharedValues(Config config, const Plan& plan) {
    const Camera& camera = plan.preview->camera;
    const RenderSettings& settings = plan.preview->settings;
    Config::Preview& preview = config.preview;
    config.surface.spacing = plan.spacing;
    if (std::exchange(config.surface.inset, {})) config.surface.skin = Length{plan.skin.skin.value_or(0), false};
    preview.camera_position = {camera.position.x, camera.position.y, camera.position.z};
    preview.look_at = {camera.look_at.x, camera.look_at.y, camera.look_at.z};
    preview.ground = settings.ground ? Config::Preview::Ground::given : Config::Preview::Ground::none;
    preview.ground_height = settings.ground.value_or(0);
    preview.colour_range = {settings.colouring.low, settings.colouring.high};
    return config;
}

/// One panel of the sheet: its caption, and the plan by which it is made.
struct Panel {
    std::string caption;
    Plan plan;
};

/// The panel of a text "CAPTION: key=value key=value". Keys that are not set are those of `base`.
Panel panelOf(const std::string& text, Config base, const PreviewWorker& worker) {
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos)
        throw Error("--panel '" + text +
                    "' has no colon. Use a caption, a colon and any number of KEY=VALUE, as in 'full "
                    "balls: surface.skin=none'.");
    std::istringstream words(text.substr(colon + 1));
    for (std::string word; words >> word;) {
        const KeyValue given = keyValueOf(word, "--panel '" + text.substr(0, colon) + "':");
        setConfigKey(base, given.path, given.value, given.where);
    }
    return {text.substr(0, colon), planOf(base, worker)};
}

Picture rendered(const Plan& plan, const Particles& particles) {
    const RenderPlan& preview = *plan.preview;
    if (plan.config.preview.show != ShownGeometry::surface)  // exact spheres instead of a tessellated union
        return renderFrame({}, ballsAround(particles, preview.balls), preview.camera, preview.settings);
    const SkinnedFrame skinned = skinFrame(particles, plan.skin);
    return renderFrame(skinned.mesh, skinned.spheres, preview.camera, preview.settings);
}

/// The default panels; without those that cannot have what the configuration asks for, such as walls.
std::vector<Panel> defaultPanels(const Config& config, const PreviewWorker& worker) {
    std::vector<Panel> panels;
    for (const std::string text : kDefaultPanels) {
        try {
            panels.push_back(panelOf(text, config, worker));
        } catch (const Error& error) {
            if (text == std::end(kDefaultPanels)[-1]) throw;  // the configuration as it is
            logInfo("the panel '" + text.substr(0, text.find(':')) + "' is left out: " + error.what());
        }
    }
    return panels;
}

/// panel_texts: as panelOf() reads them; empty: defaultPanels().
int compare(const PreviewJob& job, const std::vector<std::string>& panel_texts, int columns,
            const PreviewWorker& worker) {
    const Plan plan = planOf(job.config, worker);
    for (const std::string& warning : plan.warnings) logWarning(warning);
    for (const std::string& note : plan.notes) logInfo(note);
    const Config shared = withSharedValues(job.config, plan);
    std::vector<Panel> panels;
    if (panel_texts.empty()) panels = defaultPanels(shared, worker);
    for (const std::string& text : panel_texts) panels.push_back(panelOf(text, shared, worker));
    return writePreviews(job, worker, [&](const PreviewTask& task) {
        const Particles particles = readParticles(task.input, inputOf(plan.config, task.frame));
        std::vector<CaptionedImage> images;
        for (const Panel& panel : panels)
            images.push_back({toneMapped(rendered(panel.plan, particles)), panel.caption});
        Rendering rendering{{}, contactSheet(images, columns)};
        rendering.files.push_back(encodePng(rendering.image));
        return rendering;
    });
}

}  // namespace

void addCompareCommand(CLI::App& program, int& exit_code) {
    CLI::App* command = program.add_subcommand(
        "compare", "Renders a frame as union of balls, alpha mesh and beta meshes, side by side.");
    command->footer(
        "Each panel of the sheet has --width x --height pixels; without --pipeline, " + panelSize() +
        " by default.\n"
        "Examples:\n"
        "  betamesh compare sim/splash.0012.vdb splash.png\n"
        "  betamesh compare sim/splash.0012.vdb skin.png --panel 'as it is:' --panel 'full balls: surface.skin=none'\n"
        "  betamesh compare 'sim/splash.####.vdb' look/splash.####.png --frames 1-24 --movie splash.mp4");
    const auto options = std::make_shared<PreviewOptions>();
    options->outputs.resize(1);
    command
        ->add_option("IN", options->input,
                     "Particle files (" + extensionsFor(FileKind::particles, Access::read) +
                         "). Write the frame number of a sequence as ####.")
        ->required();
    command->add_option("OUT", options->outputs[0], "Sheets to write (.png).")->required();
    const auto texts = std::make_shared<std::vector<std::string>>();
    command
        ->add_option("--panel", *texts,
                     "Show this panel instead of the four default ones: its caption, and the keys in which it differs "
                     "from the other options. Repeat the option for each panel.")
        ->type_name("'CAPTION: KEY=VALUE ...'")
        ->expected(1)
        ->take_all()
        ->group("Preview");
    const auto columns = std::make_shared<int>(2);
    command->add_option("--columns", *columns, "Number of panels side by side.")
        ->type_name("N")
        ->capture_default_str()
        ->check(wholeNumber(1, 100))
        ->group("Preview");
    addPreviewOptions(*command, *options, [&](const ConfigKey& key) {
        if (key.path == "preview.show" || key.path == "preview.particle_radius" || key.path == "surface.kind")
            return false;
        for (const char* section : {"preview.", "input.", "surface.", "perturbation.", "smoothing.", "features."})
            if (key.path.starts_with(section)) return true;
        return key.path == "preset" || key.path == "frames" || key.path == "run.threads" || key.path == "run.timeout";
    });
    showInShortHelp(*command,
                    {"--frames", "--preset", "--radius", "--spacing", "--camera-position", "--look-at", "--azimuth",
                     "--elevation", "--width", "--height", "--panel", "--columns", "--movie", "--overwrite"});
    command->callback([options, texts, columns, &exit_code] {
        if (isExr(options->outputs[0]))
            throw Error(options->outputs[0] +
                        ": sheets with captions are written as .png. Use a name that ends in .png.");
        Config defaults;
        defaults.preview.width = kPanelWidth, defaults.preview.height = kPanelHeight;
        const PreviewJob job = planPreviews(*options, FileKind::particles, defaults);
        exit_code =
            inPreviewWorker(job, [&](const PreviewWorker& worker) { return compare(job, *texts, *columns, worker); });
    });
}

}  // namespace betamesh
