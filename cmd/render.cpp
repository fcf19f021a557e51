#include "batch/config/radius.h"
#include "batch/job/preview.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "command.h"
#include "picture_options.h"
#include "render/exr_file.h"
#include "render/png_file.h"

#include <algorithm>
#include <memory>
#include <set>

namespace betamesh {
namespace {

/// Of balls that show particles.
double ballRadius(const Config& config, const std::map<int, std::string>& on_disk, const WorkerEvents& notes) {
    const auto resolved = resolveRadius(config, on_disk, notes);
    if (!resolved) return 0;
    logInfo("spacing " + std::to_string(resolved->spacing) + " (" + resolved->origin + ')');
    if (config.preview.show == ShownGeometry::union_) return resolved->radius;
    const LengthText& radius = config.preview.particle_radius;
    return radius.value * (radius.in_spacings ? resolved->spacing : 1);
}

bool isEmpty(const Subject& subject) { return subject.mesh.triangles.empty() && subject.spheres.size() == 0; }

/// The first frame on disk that can be read and is not empty, kept so that it need not be read again.
struct First {
    std::string file;
    Subject subject;
    double ball = 0;  ///< of particles, if that is what the files hold
};

First firstFrame(const Config& config, const std::map<int, std::string>& on_disk, const WorkerEvents& notes) {
    First first;
    for (const auto& [frame, file] : on_disk) {
        const WorkerEvents::AtWork note(notes, frame, WorkerEvents::Doing::measuring);
        try {
            first.subject = readSubject(file, config, 0);
        } catch (const Error&) {  // its own frame will tell
            continue;
        }
        first.file = file;
        if (!isEmpty(first.subject)) break;
    }
    if (first.subject.mesh.triangles.empty() && !isEmpty(first.subject)) {
        first.ball = ballRadius(config, on_disk, notes);
        first.subject = readSubject(first.file, config, first.ball);
    }
    return first;
}

int render(const PictureJob& job, const PictureWorker& worker) {
    const Config& config = job.config;
    const auto on_disk = measurableOf(job.on_disk, worker.history);
    First first = firstFrame(config, on_disk, worker.notes);
    const double ball = first.ball;
    Extent extent(config.preview);
    if (on_disk.size() > 1 && needsExtent(config)) {
        extent = extentOf(on_disk, config, ball, worker.notes, worker.history.last_loss.empty());
    } else {
        extent.add(first.subject);
    }
    PreviewPlan plan = planPreview(config, extent, ball);
    logInfo("camera " + describe(plan));
    plan.settings.layers = std::any_of(job.tasks[0].outputs.begin(), job.tasks[0].outputs.end(), isExr);
    return writePictures(job, worker, [&](const PictureTask& task) {
        const Subject subject =
            task.input == first.file ? std::move(first.subject) : readSubject(task.input, config, ball);
        const Picture picture = renderFrame(subject.mesh, subject.spheres, plan.camera, plan.settings);
        Drawn drawn{{}, toneMapped(picture)};
        for (const std::string& output : task.outputs)
            drawn.files.push_back(isExr(output) ? encodeExr(picture) : encodePng(drawn.image));
        return drawn;
    });
}

}  // namespace

void addRenderCommand(CLI::App& program, int& exit_code) {
    CLI::App* command = program.add_subcommand("render", "Pictures of meshes or particles, one frame or a sequence.");
    command->footer(
        "Meshes are shown with the spheres beside them; particles as small balls, or with --show union as the balls\n"
        "that the surface is made from.\n"
        "Examples:\n"
        "  betamesh render mesh/splash.0012.ply splash.png\n"
        "  betamesh render 'mesh/splash.####.ply' look/splash.####.exr look/splash.####.png --shutter 0.5\n"
        "  betamesh render mesh/splash.0012.ply zebra.png --shading zebra --camera-position 2,1,3 --look-at "
        "0.5,0.2,0.5");
    const auto options = std::make_shared<PictureOptions>();
    command
        ->add_option("IN", options->input,
                     "Meshes (.ply .bgeo .bgeo.gz .obj) or particles (.vdb .bgeo .bgeo.gz .ply), with a place for the "
                     "frame number where there are several.")
        ->required();
    command->add_option("OUT", options->outputs, "Pictures: .png, .exr, or one of each.")->required()->expected(1, 2);
    const std::set<std::string> others{"frames",         "run.threads",    "run.timeout",
                                       "input.velocity", "surface.radius", "surface.spacing"};
    addPictureOptions(*command, *options, [&](const ConfigKey& key) {
        return key.path.starts_with("preview.") || others.contains(key.path);
    });
    command->callback([options, &exit_code] {
        for (const std::string& output : options->outputs) isExr(output);
        const PictureJob job = planPictures(*options);
        exit_code = inPictureWorker(job, [&](const PictureWorker& worker) { return render(job, worker); });
    });
}

}  // namespace betamesh
