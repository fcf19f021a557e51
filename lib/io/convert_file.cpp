#include "io/convert_file.h"

#include "betamesh/error.h"
#include "io/curve_file.h"
#include "io/extension.h"
#include "io/file_contents.h"
#include "io/level_set.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "io/particle_selector.h"
#include "io/up_axis.h"
#include "mesh/normals.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace betamesh {

namespace {

namespace fs = std::filesystem;

std::string textOf(double number) {
    std::ostringstream text;
    text << number;
    return text.str();
}

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

/// Whether a type of whole numbers has no sign.
bool isUnsigned(const std::string& type) {
    return type.find("uint") != std::string::npos || type.find("UInt") != std::string::npos ||
           type.find("unsigned") != std::string::npos;
}

/// Whether some numbers are negative. Ids are numbers with sign in files.
bool haveNegative(const std::vector<std::uint64_t>& ids) {
    return std::ranges::any_of(ids, [](std::uint64_t id) { return id >> 63 != 0; });
}
bool haveNegative(const Attribute& a) {
    const auto isNegative = [](auto number) { return number < 0; };
    return std::ranges::any_of(a.real, isNegative) || std::ranges::any_of(a.integer, isNegative);
}

/// What the reader did not read, or rounded.
void noteReading(const FileContents& contents, std::vector<std::string>& warnings) {
    std::vector<std::string> passed_over = contents.passed_over;
    for (const GridInfo& grid : contents.grids)
        if (!grid.is_read) passed_over.push_back("'" + grid.name + "' (" + grid.type + ")");
    if (!passed_over.empty()) warnings.push_back("not read: " + concatenate(passed_over));
    for (const std::string& warning : contents.warnings) warnings.push_back(warning);
    if (contents.position.empty()) return;
    std::vector<std::string> left_out, rounded, inexact, negative;
    for (const AttributeInfo& declared : contents.declared) {
        const auto kept = std::find_if(contents.attributes.begin(), contents.attributes.end(),
                                       [&](const Attribute& a) { return a.name == declared.name; });
        const bool is_id = declared.name == "id" && kept == contents.attributes.end();
        if (has64Bits(declared.type) && isUnsigned(declared.type) &&
            (is_id ? haveNegative(contents.id) : kept != contents.attributes.end() && haveNegative(*kept)))
            negative.push_back(declared.name);
        if (kept != contents.attributes.end()) {
            if (has64Bits(declared.type) && kept->integer.empty())
                rounded.push_back(declared.name);
            else if (isUnsigned(declared.type) && kept->integer.empty() && !kept->real.empty())
                inexact.push_back(declared.name);
        } else if (isPosition(declared.name)) {
            if (has64Bits(declared.type)) rounded.push_back(declared.name);
        } else if (declared.type == "string" || declared.type == "dict") {
            left_out.push_back(declared.name + " (" + declared.type + ")");
        }
    }
    if (!left_out.empty()) warnings.push_back("attributes that cannot be read are left out: " + concatenate(left_out));
    if (!inexact.empty())
        warnings.push_back("whole numbers from 2^31 on become floats of single precision: " + concatenate(inexact));
    if (!negative.empty())
        warnings.push_back("whole numbers from 2^63 on become negative (2^64 less): " + concatenate(negative));
    std::vector<std::string> infinite;
    for (const LostNumber& lost : contents.lost_numbers)
        infinite.push_back("'" + lost.attribute + "' of particle " + std::to_string(lost.particle) + " is " +
                           describe(lost));
    if (!infinite.empty()) warnings.push_back("numbers become infinite: " + concatenate(infinite));
    if (!rounded.empty()) warnings.push_back("numbers of 64 bits are rounded to 32 bits: " + concatenate(rounded));
}

/// Removes ids that the output cannot hold.
void dropLargeIds(const FileFormat& format, Particles& particles, std::vector<std::string>& warnings) {
    if (holdsIds(format, particles.id)) return;
    const bool has_negative = haveNegative(particles.id);
    particles.id.clear();
    warnings.push_back("ids " + std::string(has_negative ? "are negative or " : "") + "need more than " +
                       std::to_string(format.id_bits) + " bits, which " + std::string(format.write_extensions) +
                       " cannot hold: they are left out");
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

/// The frame rate, up axis and unit of an output.
struct Units {
    WriteOptions write;
    bool turns_to_y = false;  ///< z is up in the input: the writer expects data whose y axis points up
};

Units unitsOf(const FileUnits& units, const FileFormat& format, const ConversionOptions& given,
              std::vector<std::string>& warnings) {
    const UpAxis input_up = given.input_up_axis.value_or(units.up_axis.value_or(UpAxis::y));
    Units result{given.write};
    WriteOptions& write = result.write;
    if (format.holds_frame_rate) write.frames_per_second = units.frames_per_second.value_or(write.frames_per_second);
    if (format.holds_units) {
        write.up_axis = input_up;
        write.meters_per_unit = units.meters_per_unit.value_or(write.meters_per_unit);
    } else {
        if (input_up == UpAxis::z && !given.input_up_axis && !given.units.up_axis)
            warnings.emplace_back(
                "z is up, which the output cannot store: its numbers are those of the input. Use --output-up-axis y to "
                "rotate them");
        if (units.meters_per_unit.value_or(1) != 1 && !given.units.meters_per_unit)
            warnings.push_back("a unit is " + textOf(*units.meters_per_unit) +
                               " metres long, which the output cannot store");
    }
    write.frames_per_second = given.units.frames_per_second.value_or(write.frames_per_second);
    write.meters_per_unit = given.units.meters_per_unit.value_or(write.meters_per_unit);
    write.up_axis = given.units.up_axis.value_or(write.up_axis);
    result.turns_to_y =
        input_up == UpAxis::z && (given.units.up_axis || format.holds_units || given.input_up_axis.has_value());
    return result;
}

void convertParticles(FileContents contents, const std::string& file, const fs::path& to,
                      const ConversionOptions& given, const Units& units, const WriteOptions& options,
                      Conversion& done) {
    if (given.on_bad_particle == OnBadParticle::drop) {
        const std::string bad = dropBadParticles(file, contents);
        done.points = contents.position.size();
        if (!bad.empty()) done.warnings.push_back(bad);
    }
    Particles particles = particlesFrom(std::move(contents), {}, file);
    if (units.turns_to_y) particles = withYUp(std::move(particles));
    dropLargeIds(formatOf(to, done.kind, Access::write), particles, done.warnings);
    noteNames(to, done.kind, particles.attributes, done.warnings);
    writeParticles(to, particles, options);
}

}  // namespace

Conversion convertFile(const fs::path& from, const fs::path& to, const ConversionOptions& given) {
    Conversion done;
    std::string note;
    ReadOptions reading;
    reading.grids = given.grids;
    reading.frame = given.frame;
    reading.all_groups = true;
    if (!given.grids.empty() && !hasGrids(from))
        throw Error(from.string() + ": has no grids, but grid '" + given.grids[0] +
                    "' is asked for. Only .vdb files have grids, .usda files prims and .abc files objects.");
    FileContents contents = readByContents(from, reading, note);
    if (!note.empty()) done.warnings.push_back(note);
    done.kind = contents.kind();
    done.points = contents.position.size();
    done.triangles = contents.triangles.size();
    done.edges = contents.edges.size();
    require(from, to, done.kind);
    const Units units = unitsOf(contents.units, formatOf(to, done.kind, Access::write), given, done.warnings);
    WriteOptions options = units.write;
    const WarningHandler warn = [&](const std::string& warning) {
        if (warning.starts_with(kNoInside)) throw Error(from.string() + ": " + warning + ".");
        done.warnings.push_back(warning);
    };
    options.warn = &warn;
    noteReading(contents, done.warnings);
    const std::string file = from.string();
    if (done.kind == FileKind::particles) {
        convertParticles(std::move(contents), file, to, given, units, options, done);
        return done;
    }
    if (!contents.id.empty()) {  // surfaces have no ids: `id` is an ordinary attribute
        const std::vector<std::int64_t> ids(contents.id.begin(), contents.id.end());
        contents.attributes.push_back(integerAttribute("id", 1, ids));
    }
    if (done.kind == FileKind::curves) {
        Curves curves = curvesFrom(std::move(contents), file);
        if (units.turns_to_y) curves = withYUp(std::move(curves));
        noteWriting(to, done.kind, {!curves.velocity.empty(), !curves.attributes.empty(), false}, options,
                    done.warnings);
        noteNames(to, done.kind, curves.attributes, done.warnings);
        writeCurves(to, curves, options);
        return done;
    }
    if (!contents.edges.empty())
        done.warnings.emplace_back("edges are left out, because the file contains a mesh as well");
    Mesh mesh = meshFrom(std::move(contents), file);
    if (units.turns_to_y) mesh = withYUp(std::move(mesh));
    const bool has_kept_normals = formatOf(to, done.kind, Access::write).holds_normals && normalsIn(mesh.attributes);
    const bool has_others = mesh.attributes.size() > (has_kept_normals ? 1 : 0);
    noteWriting(to, done.kind, {!mesh.velocity.empty(), has_others, mesh.component.has_value()}, options,
                done.warnings);
    noteNames(to, done.kind, mesh.attributes, done.warnings);
    writeMesh(to, mesh, options);
    return done;
}

}  // namespace betamesh
