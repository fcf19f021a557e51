#include "batch/job/frame_input.h"

#include "base/attribute_names.h"
#include "base/list_entries.h"
#include "base/local_origin.h"
#include "base/lower_case.h"
#include "base/parallel.h"
#include "batch/config/key_types.h"
#include "batch/platform/interrupt.h"
#include "batch/platform/memory.h"
#include "batch/report/log.h"
#include "betamesh/error.h"
#include "io/extension.h"
#include "io/format_table.h"
#include "skin/attributes.h"
#include "skin/particle_sizes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace betamesh {
namespace {

constexpr double kSameRadius = 0.01;  // relative difference of radii that count as one

NearSurface nearSurfaceOf(const std::string& file, const ParticleInput& input, const SkinParams& skin) {
    constexpr std::size_t kRowsAtOnce = std::size_t{1} << 20;
    NearSurfaceFinder finder(skin);
    std::vector<Vec3f> positions;
    std::vector<double> radii;  // none if all particles are alike
    const auto handOver = [&] {
        finder.add(positions, radii);
        positions.clear();
        radii.clear();
        leaveIfInterrupted();
    };
    const auto append = [&](std::span<const Vec3f> more, std::span<const double> their_radii) {
        positions.insert(positions.end(), more.begin(), more.end());
        radii.insert(radii.end(), their_radii.begin(), their_radii.end());
        if (positions.size() >= kRowsAtOnce) handOver();
    };
    if (skin.radius_attribute.empty()) {
        visitPositions(file, input, [&](std::span<const Vec3f> more) { append(more, {}); });
    } else {
        std::size_t row = 0;
        visitAttributes(file, input, [&](const Particles& more) {
            append(more.position, particleSizes(more, skin, row).radius);
            row += more.size();
        });
    }
    handOver();
    return finder.find();
}

/// "12000 of 90000 particles are near the surface and need about 40 MiB to mesh".
std::string lineOn(const NearSurface& near) {
    const std::size_t kept = near.particles - near.omitted();
    return std::to_string(kept) + " of " + std::to_string(near.particles) +
           " particles are near the surface and need about " +
           std::to_string((memoryOf(static_cast<double>(kept)) >> 20) + 1) + " MiB to mesh";
}

/// Reads the file twice: first to find the particles near the surface, then to load them.
FrameInput readNearSurface(const FrameTask& task, const Plan& plan,
                           const std::function<void(const std::string&)>& foundNear) {
    const ParticleInput input = inputOf(plan.config, task.frame);
    FrameInput liquid;
    liquid.near = nearSurfaceOf(task.input, input, plan.skin);
    foundNear(lineOn(*liquid.near));
    auto [particles, summary] = readSummarised(task.input, input, liquid.near->all ? nullptr : &liquid.near->row);
    liquid.particles = std::move(particles);
    liquid.summary = std::move(summary);
    return liquid;
}

/// Whether the output depends on the particles near the surface alone.
bool needsOnlySurface(const Plan& plan) {
    const bool shows_particles = plan.preview && plan.config.preview.show != ShownGeometry::surface;
    return plan.config.surface.dimension == 3 && plan.skin.radius > 0 && !shows_particles;
}

/// Whether an attribute, or the vector that it is a component of, is written to the output.
bool isOutput(const std::string& name, const Config& config) {
    const std::vector<std::string>& names = config.output.attributes;
    const auto isWanted = [&](const std::string& attribute) {
        return isAccelerationName(attribute) || std::find(names.begin(), names.end(), attribute) != names.end();
    };
    const auto part = componentName(name);
    return isWanted(name) || (part && isWanted(part->vector));
}

std::string quoted(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "'" : ", '") + name + "'";
    return list;
}

/// The names of the unused parts of one kind, after the word for them; empty if there are none.
std::string unused(const std::vector<InputPart>& parts, InputPart::Kind kind, const std::string& word) {
    std::vector<std::string> names;
    for (const InputPart& part : parts)
        if (part.kind == kind && part.use.empty()) names.push_back(part.name);
    return names.empty() ? "" : word + (names.size() > 1 ? "s " : " ") + quoted(names);
}

std::optional<InputRemark> remarkOnVelocity(const InputSummary& summary, const Config& config) {
    if (summary.velocity.empty()) {
        std::string text =
            "no velocity (v, velocity, vel and so on): zero velocities are written for all frames without it";
        if (!summary.incomplete_velocity.empty()) text += ". Of the velocity " + summary.incomplete_velocity;
        if (!summary.velocity_candidates.empty())
            text += ". Name the attribute with --velocity (input.velocity) if it is one of " +
                    quoted(summary.velocity_candidates);
        return InputRemark{kNoVelocity, true, text};
    }
    if (!config.input.velocity.empty() || summary.velocity == "v" || summary.velocity == "vx, vy, vz")
        return std::nullopt;
    return InputRemark{"velocity", false, "the velocity is read from '" + summary.velocity + "' (input.velocity)"};
}

std::optional<InputRemark> remarkOnUpAxis(const InputSummary& summary, const Config& config) {
    if (!summary.z_is_up || config.input.up_axis == UpAxis::z) return std::nullopt;
    if (!formatOf(config.output.path, FileKind::mesh, Access::write).holds_units) return std::nullopt;
    return InputRemark{"up axis", true,
                       "z is up in this file, but the output will say y. Turn the particles with --up-axis z "
                       "(input.up_axis); with --output-up-axis z as well, z stays up and the output says so"};
}

/// A unit of the file that the output contradicts, though it could say the same.
std::optional<InputRemark> remarkOnUnit(const std::string& what, std::optional<double> of_file, double of_output,
                                        const std::string& option, const Config& config) {
    if (!of_file || std::abs(*of_file - of_output) <= 1e-6 * of_output) return std::nullopt;
    if (!formatOf(config.output.path, FileKind::mesh, Access::write).holds_units) return std::nullopt;
    return InputRemark{what, true,
                       "the input has " + shortNumber(*of_file) + ' ' + what + ", but the output will say " +
                           shortNumber(of_output) + ". Say the same with " + option};
}

std::optional<InputRemark> remarkOnPolygons(const InputSummary& summary) {
    if (summary.polygons == 0) return std::nullopt;
    return InputRemark{"polygons", true,
                       "contains " + std::to_string(summary.polygons) +
                           (summary.polygons > 1 ? " polygons" : " polygon") + ": its vertices are taken as particles"};
}

std::optional<InputRemark> remarkOnGrids(const InputSummary& summary, const Config& config) {
    std::vector<std::string> read;
    for (const InputPart& part : summary.parts)
        if (part.kind == InputPart::Kind::grid && !part.use.empty()) read.push_back(part.name);
    if (!config.input.grid.empty() || read.size() < 2) return std::nullopt;
    return InputRemark{"grids", true,
                       "the particles of " + std::to_string(read.size()) +
                           (read.front().starts_with('/') ? " prims" : " point grids") +
                           " are meshed together: " + quoted(read) + ". Choose some with --grid (input.grid)"};
}

double largestCoordinate(const Vec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

/// Coordinates so large that single precision, in which meshes are written, is coarse beside the particle spacing.
///
/// in      spacing: 0 if it is not known
std::optional<InputRemark> remarkOnCoordinates(const std::vector<Vec3f>& position, double spacing) {
    Box box;
    std::size_t far = 0;
    for (const Vec3f& p : position) {
        box.extendBy(Vec3(p));
        if (spacing > 0 && isCoarselyRounded(largestCoordinate(Vec3(p)), spacing)) ++far;
    }
    const bool all_are_far = !position.empty() && localOrigin(box, position.size()) != Vec3(0, 0, 0);
    if (far == 0 && !all_are_far) return std::nullopt;
    const double largest = std::max(largestCoordinate(box.min), largestCoordinate(box.max));
    const double step = largest - std::nextafter(static_cast<float>(largest), 0.0F);
    if (!all_are_far) {
        const bool most_are_far = 2 * far > position.size();
        return InputRemark{
            "coordinates", true,
            std::to_string(far) + " of " + std::to_string(position.size()) +
                " particles are so far from the origin, up to " + shortNumber(largest) +
                ", that vertices there are rounded to multiples of " + shortNumber(step) + ", beside a spacing of " +
                shortNumber(spacing) + ": the surface gets steps, and meshing may take long. " +
                (most_are_far ? "Subtract a point near them with --origin x,y,z (input.origin), and leave the others"
                              : "Leave them") +
                " out with --box (input.box)"};
    }
    return InputRemark{"coordinates", true,
                       "the coordinates reach " + shortNumber(largest) +
                           ", where those of vertices are rounded to multiples of " + shortNumber(step) +
                           ": the surface gets steps, and meshing may take long. Subtract a point near the particles "
                           "with --origin x,y,z (input.origin)"};
}

std::optional<InputRemark> remarkOnRadius(const Attribute& attribute) {
    if ((attribute.name != "pscale" && attribute.name != "radius") || attribute.components != 1 ||
        attribute.real.empty())
        return std::nullopt;
    const auto [least, most] = std::minmax_element(attribute.real.begin(), attribute.real.end());
    if (!(*most - *least > static_cast<float>(kSameRadius) * std::abs(*most))) return std::nullopt;
    return InputRemark{"radius", true,
                       "the attribute '" + attribute.name + "' gives each particle a radius, from " +
                           std::to_string(*least) + " to " + std::to_string(*most) +
                           ". It is not used: all balls have the same radius. Use it with --radius-attribute " +
                           attribute.name + " (surface.radius_attribute)"};
}

/// "particle 17", or its position where rows are not those of the file, because particles are left out.
std::string particleName(const FrameInput& liquid, std::size_t row) {
    if (liquid.particles.size() == liquid.summary.particles_read) return "particle " + std::to_string(row);
    const Vec3f& p = liquid.particles.position[row];
    return "the particle at " + shortNumber(p.x) + ", " + shortNumber(p.y) + ", " + shortNumber(p.z);
}

/// A particle whose ball is so much larger than most that it swallows others.
std::optional<InputRemark> remarkOnSizes(const FrameInput& liquid, const SkinParams& skin) {
    constexpr double kOutlier = 20;     // medians
    constexpr std::size_t kRare = 100;  // at most one in so many; more of them are no mistake
    constexpr double kCrowd = 4;        // particles in a ball, as a multiple of those in a ball of regular liquid
    const double crowd = kCrowd * 4.19 * std::pow(skin.radius / particleSpacing(skin), 3);
    const std::vector<Vec3f>& position = liquid.particles.position;
    const auto attribute = std::ranges::find(liquid.particles.attributes, skin.radius_attribute, &Attribute::name);
    if (skin.radius_attribute.empty() || attribute == liquid.particles.attributes.end() || attribute->components != 1 ||
        position.empty())
        return std::nullopt;
    std::vector<double> size(attribute->real.begin(), attribute->real.end());
    if (attribute->real.empty()) size.assign(attribute->integer.begin(), attribute->integer.end());
    std::vector<double> sorted = size;
    if (std::ranges::any_of(sorted, [](double x) { return !std::isfinite(x); })) return std::nullopt;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const auto isOutlier = [limit = kOutlier * *middle](double x) { return x > limit; };
    const auto outliers = static_cast<std::size_t>(std::ranges::count_if(size, isOutlier));
    if (outliers == 0 || outliers * kRare > size.size()) return std::nullopt;
    const auto row = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
    const double radius = size[row] * skin.radius_scale / particleSpacing(skin) * skin.radius;
    const auto inside = static_cast<std::size_t>(std::ranges::count_if(
        position, [&](const Vec3f& p) { return (Vec3(p) - Vec3(position[row])).length() < radius; }));
    if (static_cast<double>(inside) <= crowd) return std::nullopt;
    const std::string& name = skin.radius_attribute;
    return InputRemark{"sizes", true,
                       particleName(liquid, row) + " has " + name + " = " + shortNumber(size[row]) + ", " +
                           shortNumber(size[row] / *middle) + " times the median, " + shortNumber(*middle) +
                           ": its ball swallows " + std::to_string(inside - 1) + " other particles" +
                           (outliers > 1 ? ", and " + std::to_string(outliers - 1) + " more " +
                                               (outliers > 2 ? "particles are" : "particle is") + " as unusual"
                                         : "") +
                           ". If that is a mistake, leave it out with --where '" + name +
                           " <= " + shortNumber(kOutlier * *middle) + "' (input.where)"};
}

std::optional<InputRemark> remarkOnValues(const Attribute& attribute, const FrameInput& liquid) {
    std::size_t count = 0, first = 0;
    for (std::size_t i = 0; i < attribute.real.size(); ++i)
        if (!std::isfinite(attribute.real[i]) && count++ == 0) first = i;
    if (count == 0) return std::nullopt;
    const std::size_t row = first / attribute.components;
    const std::string particle = particleName(liquid, row) + " (" + std::to_string(attribute.real[first]) + ")";
    std::string text =
        "the attribute '" + attribute.name + "' has " +
        (count == 1 ? "a number that is NaN or infinite, that of " + particle
                    : std::to_string(count) + " numbers that are NaN or infinite, the first of them for " + particle) +
        ". They spread to the vertices nearby";
    for (const LostNumber& lost : liquid.summary.lost_numbers) {
        const auto part = componentName(lost.attribute);
        if (lost.attribute != attribute.name && !(part && part->vector == attribute.name)) continue;
        text += ". In the file, particle " + std::to_string(lost.particle) + " has " + describe(lost);
        break;
    }
    return InputRemark{"values of " + attribute.name, true, text};
}

/// An attribute whose numbers in the file have more digits than those in the output.
std::optional<InputRemark> remarkOnPrecision(const Attribute& attribute, const std::vector<InputPart>& parts) {
    if (attribute.real.empty()) return std::nullopt;
    const auto part = std::find_if(parts.begin(), parts.end(), [&](const InputPart& p) {
        const auto component = componentName(p.name);
        return p.kind == InputPart::Kind::attribute &&
               (p.name == attribute.name || (component && component->vector == attribute.name));
    });
    if (part == parts.end()) return std::nullopt;
    const std::string type = lowerCase(part->type);
    const auto has = [&](const char* word) { return type.find(word) != std::string::npos; };
    const bool has_negative = std::ranges::any_of(attribute.real, [](float x) { return x < 0; });
    if (has("int"))
        return InputRemark{
            "precision of " + attribute.name, true,
            "the attribute '" + attribute.name +
                "' has whole numbers of more than 32 bits (with their sign), which are rounded to single precision" +
                (has("uint64") && has_negative ? "; those from 2^63 on become negative (2^64 less)" : "")};
    if (has("double") || has("64") || has("vec3d"))
        return InputRemark{"precision of " + attribute.name, false,
                           "the attribute '" + attribute.name +
                               "' has double precision in the file and single precision in the output"};
    return std::nullopt;
}

}  // namespace

FrameInput readInput(const FrameTask& task, const Plan& plan, bool near_surface, FileIdentity& identity,
                     const std::function<void(const std::string&)>& foundNear) {
    const FileFingerprint before = fileFingerprint(task.input);
    FrameInput liquid;
    const auto read = [&] {
        if (near_surface && needsOnlySurface(plan)) {
            liquid = readNearSurface(task, plan, foundNear);
            return;
        }
        auto [particles, summary] = readSummarised(task.input, inputOf(plan.config, task.frame));
        liquid.particles = std::move(particles);
        liquid.summary = std::move(summary);
    };
    parallelBoth(read, [&] { identity = fileIdentity(task.input); });
    if (fileFingerprint(task.input) != before)
        throw Error(task.input + ": changed while it was read. Wait until the simulation has finished the file");
    return liquid;
}

std::vector<InputPart> partsOf(const FrameInput& liquid, const Config& config) {
    std::vector<InputPart> parts = liquid.summary.parts;
    const Config::Surface& surface = config.surface;
    for (InputPart& part : parts) {
        if (part.kind != InputPart::Kind::attribute || !part.use.empty()) continue;
        if (part.name == surface.radius_attribute || part.name == surface.radius_rate_attribute) part.use = "size";
        if (isOutput(part.name, config)) part.use = "output";
    }
    return parts;
}

void requireAttributes(const FrameInput& liquid, const Config& config) {
    const auto has = [&](const std::string& name) {
        return std::ranges::find(liquid.particles.attributes, name, &Attribute::name) !=
               liquid.particles.attributes.end();
    };
    const std::string& found = liquid.summary.velocity;
    const std::vector<std::string> velocity = entriesOf(found.empty() ? config.input.velocity : found);
    for (const std::string& name : config.output.attributes) {
        if (has(name)) continue;
        const auto part = componentName(name);
        const bool is_vector = velocity.size() == 1;
        if (std::ranges::find(velocity, name) != velocity.end() ||
            (is_vector && part && part->vector == velocity[0] && part->index < 3))
            throw Error("'" + name + "' is " + (is_vector && name == velocity[0] ? "" : "a component of ") +
                        "the velocity, which is written anyway. Leave it out of --attributes (output.attributes)");
        if (name == config.input.id && name != "id" && !liquid.particles.id.empty())
            throw Error("'" + name +
                        "' is read as the id of particles, which vertices do not have. Without --id (input.id) it is "
                        "an attribute");
        if (part && has(part->vector))
            throw Error("'" + name + "' is a component of the attribute '" + part->vector + "'. Use --attributes " +
                        part->vector + " (output.attributes)");
    }
    requireAttributesNamed(liquid.particles, config.output.attributes);
}

std::vector<InputRemark> remarksOn(const FrameInput& liquid, const Plan& plan) {
    const Config& config = plan.config;
    const InputSummary& summary = liquid.summary;
    std::vector<InputRemark> remarks;
    const auto add = [&](std::optional<InputRemark>&& remark) {
        if (remark) remarks.push_back(std::move(*remark));
    };
    if (summary.dropped > 0)
        add(InputRemark{"dropped", true,
                        std::to_string(summary.dropped) + (summary.dropped > 1 ? " particles are" : " particle is") +
                            " left out because the position or velocity is not finite (input.on_bad_particle); the "
                            "first: " +
                            summary.first_dropped});
    for (const std::string& warning : summary.warnings) {
        const std::string fault = warning.substr(0, warning.find(": line "));  // the same in all frames
        add(InputRemark{"reader: " + fault, true, warning});
    }
    add(remarkOnPolygons(summary));
    add(remarkOnUpAxis(summary, config));
    add(remarkOnUnit(
        "metres per unit of length", summary.meters_per_unit, config.output.meters_per_unit * config.input.scale,
        "--meters-per-unit (output.meters_per_unit), or scale the particles with --scale (input.scale)", config));
    add(remarkOnUnit("frames per second", summary.frames_per_second, config.output.frames_per_second,
                     "--output-fps (output.fps)", config));
    add(remarkOnCoordinates(liquid.particles.position, plan.spacing));
    if (liquid.particles.size() == 0) {
        if (summary.particles_read > summary.dropped)
            add(InputRemark{"none", true,
                            "none of the " + std::to_string(summary.particles_read) +
                                " particles is chosen by input.where, input.box and input.group"});
        return remarks;
    }
    add(remarkOnVelocity(summary, config));
    add(remarkOnGrids(summary, config));
    add(remarkOnSizes(liquid, plan.skin));
    for (const Attribute& attribute : liquid.particles.attributes) {
        if (config.surface.radius_attribute.empty()) add(remarkOnRadius(attribute));
        if (!isOutput(attribute.name, config)) continue;
        add(remarkOnValues(attribute, liquid));
        add(remarkOnPrecision(attribute, summary.parts));
    }
    const std::vector<InputPart> parts = partsOf(liquid, config);
    std::string rest;
    for (const std::string& names :
         {unused(parts, InputPart::Kind::attribute, "attribute"), unused(parts, InputPart::Kind::group, "group"),
          unused(parts, InputPart::Kind::grid, "grid"), unused(parts, InputPart::Kind::other, "other item")})
        if (!names.empty()) rest += (rest.empty() ? "" : "; ") + names;
    if (!rest.empty()) add(InputRemark{"unused", false, "not used: " + rest});
    return remarks;
}

}  // namespace betamesh
