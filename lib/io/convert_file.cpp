#include "io/convert_file.h"

#include "betamesh/error.h"
#include "io/curve_file.h"
#include "io/extension.h"
#include "io/file_contents.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"

#include <algorithm>
#include <utility>

namespace betamesh {

namespace {

namespace fs = std::filesystem;

std::string concatenate(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

bool isPosition(const std::string& name) {
    return name == "P" || name == "x" || name == "y" || name == "z" || name == "position";
}

bool has64Bits(const std::string& type) {
    return type.find("64") != std::string::npos || type == "double" || type == "long" || type == "unsigned_long";
}

/// What the reader did not read, or rounded.
void noteReading(const FileContents& contents, std::vector<std::string>& warnings) {
    std::vector<std::string> passed_over = contents.passed_over;
    for (const GridInfo& grid : contents.grids)
        if (!grid.is_read) passed_over.push_back("'" + grid.name + "' (" + grid.type + ")");
    if (!passed_over.empty()) warnings.push_back("not read: " + concatenate(passed_over));
    if (contents.position.empty()) return;
    std::vector<std::string> lost, rounded;
    for (const AttributeInfo& declared : contents.declared) {
        const auto kept = std::find_if(contents.attributes.begin(), contents.attributes.end(),
                                       [&](const Attribute& a) { return a.name == declared.name; });
        if (kept != contents.attributes.end()) {
            if (has64Bits(declared.type) && kept->integer.empty()) rounded.push_back(declared.name);
        } else if (isPosition(declared.name)) {
            if (has64Bits(declared.type)) rounded.push_back(declared.name);
        } else if (declared.type == "string" || declared.type == "group" || declared.type == "dict") {
            lost.push_back(declared.name + " (" + declared.type + ")");
        }
    }
    if (!lost.empty()) warnings.push_back("attributes that cannot be read are left out: " + concatenate(lost));
    if (!rounded.empty()) warnings.push_back("numbers of 64 bits are rounded to 32 bits: " + concatenate(rounded));
}

/// Removes ids that the output cannot hold.
void dropLargeIds(const FileFormat& format, Particles& particles, std::vector<std::string>& warnings) {
    const auto is_large = [&](std::uint64_t id) { return format.id_bits < 64 && id >> format.id_bits != 0; };
    if (std::none_of(particles.id.begin(), particles.id.end(), is_large)) return;
    particles.id.clear();
    warnings.push_back("ids need more than " + std::to_string(format.id_bits) + " bits, which " +
                       std::string(format.write_extensions) + " cannot hold: they are left out");
}

void noteWriting(const fs::path& to, FileKind kind, const Extras& extras, const WriteOptions& options,
                 std::vector<std::string>& warnings) {
    const std::string lost = lossesOf(to, kind, extras, options);
    if (!lost.empty()) warnings.push_back("the output is written without " + lost + ", which its format cannot hold");
}

void noteNames(const fs::path& to, FileKind kind, const std::vector<Attribute>& attributes,
               std::vector<std::string>& warnings) {
    std::vector<std::string> names;
    for (const Attribute& a : attributes) names.push_back(a.name);
    const std::string renamed = renamingsIn(to, kind, names);
    if (!renamed.empty()) warnings.push_back("the output cannot hold some names of attributes: " + renamed);
}

void require(const fs::path& from, const fs::path& to, FileKind kind) {
    const char* what = kind == FileKind::mesh ? "a mesh" : kind == FileKind::curves ? "curves" : "particles";
    try {
        if (formatOf(to, kind, Access::write).is_drawing)
            throw Error(to.string() + ": drawings are made by `betamesh mesh --dimension 2` only");
    } catch (const Error& error) {
        throw Error(from.string() + ": contains " + what + ". " + error.what());
    }
}

}  // namespace

Conversion convertFile(const fs::path& from, const fs::path& to, const WriteOptions& options) {
    Conversion done;
    std::string note;
    FileContents contents = readByContents(from, {}, note);
    if (!note.empty()) done.warnings.push_back(note);
    done.kind = contents.kind();
    done.points = contents.position.size();
    done.triangles = contents.triangles.size();
    done.edges = contents.edges.size();
    require(from, to, done.kind);
    noteReading(contents, done.warnings);
    const std::string file = from.string();
    if (done.kind == FileKind::particles) {
        Particles particles = particlesFrom(std::move(contents), {}, file);
        dropLargeIds(formatOf(to, done.kind, Access::write), particles, done.warnings);
        noteNames(to, done.kind, particles.attributes, done.warnings);
        writeParticles(to, particles, options);
        return done;
    }
    if (!contents.id.empty()) {  // surfaces have no ids: `id` is an ordinary attribute
        const std::vector<std::int64_t> ids(contents.id.begin(), contents.id.end());
        contents.attributes.push_back(integerAttribute("id", 1, ids));
    }
    if (done.kind == FileKind::curves) {
        const Curves curves = curvesFrom(std::move(contents), file);
        noteWriting(to, done.kind, {!curves.velocity.empty(), !curves.attributes.empty(), false}, options,
                    done.warnings);
        writeCurves(to, curves, options);
        return done;
    }
    if (!contents.edges.empty())
        done.warnings.emplace_back("edges are left out, because the file contains a mesh as well");
    const Mesh mesh = meshFrom(std::move(contents), file);
    noteWriting(to, done.kind, {!mesh.velocity.empty(), !mesh.attributes.empty(), mesh.component.has_value()}, options,
                done.warnings);
    noteNames(to, done.kind, mesh.attributes, done.warnings);
    writeMesh(to, mesh, options);
    return done;
}

}  // namespace betamesh
