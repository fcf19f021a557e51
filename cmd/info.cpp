#include "batch/config/key_types.h"
#include "batch/job/frames.h"
#include "batch/job/input_frames.h"
#include "batch/job/left_out.h"
#include "batch/job/usd_sequence.h"
#include "batch/report/printable.h"
#include "batch/report/report.h"
#include "command.h"
#include "each_file.h"
#include "io/extension.h"
#include "io/file_info.h"
#include "job_options.h"
#include "skin/spacing.h"
#include "standard_streams.h"

#include <cmath>
#include <iostream>
#include <limits>
#include <optional>

namespace betamesh {
namespace {

/// "24 at frames 1-24, of which frame 1 is shown".
std::string samplesText(const std::vector<double>& times, const FileFrame& file) {
    std::vector<int> whole;
    std::size_t between = 0;
    for (const double time : times) {
        if (time == std::trunc(time) && std::abs(time) <= std::numeric_limits<int>::max())
            whole.push_back(static_cast<int>(time));
        else
            ++between;
    }
    std::string text = std::to_string(times.size());
    if (!whole.empty()) text += " at frames " + printFrames(whole);
    if (between > 0)
        text += whole.empty()
                    ? " between whole frames, from " + shortNumber(times.front()) + " to " + shortNumber(times.back())
                    : " and between them";
    return text + (file.is_one_of_several ? ", of which frame " + std::to_string(file.frame) + " is shown" : "");
}

void print(const FileFrame& file, const FileInfo& info, std::optional<double> particle_spacing) {
    std::cout << printable(file.file) << '\n'
              << "  format      " << printable(info.format) << ", " << info.bytes << " bytes\n";
    if (info.times.size() > 1) std::cout << "  samples     " << samplesText(info.times, file) << '\n';
    std::cout << "  points      " << info.points << '\n';
    for (const VolumeInfo& volume : info.volumes) {
        std::cout << "  volume      " << printable(volume.name) << ": " << printable(volume.kind) << ", "
                  << printable(volume.type) << ", voxel " << volume.voxel << ", " << volume.voxels << " active voxels";
        if (volume.voxels > 0)
            std::cout << ", bounds " << volume.lower.x << ' ' << volume.lower.y << ' ' << volume.lower.z << "  to  "
                      << volume.upper.x << ' ' << volume.upper.y << ' ' << volume.upper.z;
        std::cout << '\n';
    }
    if (info.kind == FileKind::mesh) std::cout << "  triangles   " << info.triangles << '\n';
    if (info.edges > 0) std::cout << "  edges       " << info.edges << '\n';
    if (info.points > 0) {
        std::cout << "  bounds      " << info.lower.x << ' ' << info.lower.y << ' ' << info.lower.z << "  to  "
                  << info.upper.x << ' ' << info.upper.y << ' ' << info.upper.z << '\n';
    }
    if (info.kind == FileKind::particles && info.volumes.empty()) {
        std::cout << "  spacing     ";
        if (particle_spacing) {
            std::cout << *particle_spacing << '\n';
        } else {
            std::cout << "unknown: fewer than seven distinct particles\n";
        }
    }
    if (!info.note.empty()) std::cout << "  note        " << info.note << '\n';
    for (const AttributeInfo& attribute : info.attributes) {
        std::cout << "  attribute   " << printable(attribute.name) << ": " << printable(attribute.type);
        if (attribute.components > 1) std::cout << " x " << attribute.components;
        if (!attribute.codec.empty()) std::cout << ", codec " << printable(attribute.codec);
        std::cout << '\n';
    }
    for (const std::string& group : info.groups) std::cout << "  group       " << printable(group) << '\n';
    for (const GridInfo& grid : info.grids)
        std::cout << "  grid        " << printable(grid.name) << ": " << printable(grid.type) << '\n';
    for (const std::string& what : info.passed_over) std::cout << "  not read    " << printable(what) << '\n';
}

struct InfoArguments {
    std::vector<std::string> files;
    std::string frames = "all";
    bool json = false;
};

void showFile(const FileFrame& file, bool json) {
    std::vector<Vec3f> particles;
    const FileInfo info = inspectFile(file.file, &particles, file.sample());
    std::optional<double> particle_spacing;
    if (info.kind == FileKind::particles) {
        const auto estimate = spacingOf(particles);
        if (estimate) particle_spacing = estimate->spacing;
    }
    if (json) {
        std::cout << infoJson(file.file, file.number(), info, particle_spacing) << '\n';
    } else {
        print(file, info, particle_spacing);
    }
}

int showFiles(const InfoArguments& arguments) {
    StandardStreams streams;
    std::vector<std::string> files = withoutSequenceLayers(withoutManifests(filesNamed(arguments.files)));
    if (arguments.frames == "all") warnOfLeftOut(arguments.files);
    for (std::string& file : files)
        if (file == kStandardStream) file = streams.fileOfStdin();
    const std::vector<FileFrame> frames = framesIn(files, arguments.frames, FileKind::mesh, true);
    const auto show = [&](std::size_t i) {
        showFile(frames[i], arguments.json);
        return true;
    };
    return forEachFile(
        frames.size(),
        [&](std::size_t i) {
            return NamedFile{frames[i].file, frames[i].number()};
        },
        show, [](std::size_t, const std::string&) {});
}

}  // namespace

void addInfoCommand(CLI::App& program, int& exit_code) {
    const auto [command, arguments] =
        addCommand(program, exit_code, "info", "Shows what particle and mesh files contain.", showFiles);
    command
        ->add_option(
            "FILE", arguments->files,
            "Particle or mesh files (" + readableExtensions() +
                "). The format is that of the contents, whatever the extension. A pattern with a frame number "
                "(####) stands for every frame on disk, - for stdin. Of a file with time samples one is shown.")
        ->required();
    addFramesOption(*command, arguments->frames);
    command->add_flag("--json", arguments->json, "Print one JSON object per file on stdout.");
    command->footer("Exit codes: 0 every file is shown; 1 a file cannot be read; 2 wrong usage.");
}

}  // namespace betamesh
