#include "batch/job.h"
#include "batch/log.h"
#include "batch/report.h"
#include "command.h"
#include "core/error.h"
#include "io/file_info.h"
#include "io/particle_file.h"
#include "skin/spacing.h"

#include <iostream>
#include <memory>

namespace betamesh {
namespace {

void print(const std::string& file, const FileInfo& info, std::optional<double> particle_spacing) {
    std::cout << file << '\n'
              << "  format      " << info.format << ", " << info.bytes << " bytes\n"
              << "  points      " << info.points << '\n';
    if (info.kind == FileKind::mesh) std::cout << "  triangles   " << info.triangles << '\n';
    if (info.edges > 0) std::cout << "  edges       " << info.edges << '\n';
    if (info.points > 0) {
        std::cout << "  bounds      " << info.lower.x << ' ' << info.lower.y << ' ' << info.lower.z << "  to  "
                  << info.upper.x << ' ' << info.upper.y << ' ' << info.upper.z << '\n';
    }
    if (info.kind == FileKind::particles) {
        std::cout << "  spacing     ";
        if (particle_spacing) {
            std::cout << *particle_spacing << '\n';
        } else {
            std::cout << "unknown: fewer than seven distinct particles\n";
        }
    }
    for (const AttributeInfo& attribute : info.attributes) {
        std::cout << "  attribute   " << attribute.name << ": " << attribute.type;
        if (attribute.components > 1) std::cout << " x " << attribute.components;
        if (!attribute.codec.empty()) std::cout << ", codec " << attribute.codec;
        std::cout << '\n';
    }
}

void inform(const std::string& file, bool json) {
    const FileInfo info = inspectFile(file);
    std::optional<double> particle_spacing;
    if (info.kind == FileKind::particles) particle_spacing = spacing(readParticles(file));
    if (json) {
        std::cout << infoJson(file, info, particle_spacing) << '\n';
    } else {
        print(file, info, particle_spacing);
    }
}

}  // namespace

void addInfoCommand(CLI::App& program, int& exit_code) {
    CLI::App* command = program.add_subcommand("info", "Says what is in particle and mesh files.");
    struct Arguments {
        std::vector<std::string> files;
        bool json = false;
    };
    const auto arguments = std::make_shared<Arguments>();
    command->add_option("FILE", arguments->files, "Particles or meshes: .vdb .bgeo .bgeo.gz .ply .obj")->required();
    command->add_flag("--json", arguments->json, "One JSON object per file on stdout.");
    command->callback([arguments, &exit_code] {
        for (const std::string& file : arguments->files) {
            try {
                inform(file, arguments->json);
            } catch (const Error& error) {
                logError(error.what());
                exit_code = kSomeFailed;
            }
        }
    });
}

}  // namespace betamesh
