#include "io/particle_selector.h"

#include "base/list_entries.h"
#include "betamesh/error.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

namespace betamesh {

namespace {

std::string numbers(const Vec3f& v) {
    return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

Vec3f velocityOf(const std::vector<Attribute>& attributes, const VelocitySource& source, std::size_t row) {
    Vec3f velocity;
    for (int axis = 0; axis < 3; ++axis) {
        const auto [index, component] = source.xyz[static_cast<std::size_t>(axis)];
        const Attribute& a = attributes[index];
        const std::size_t at = row * a.components + component;
        velocity[axis] = a.real.empty() ? static_cast<float>(a.integer[at]) : a.real[at];
    }
    return velocity;
}

/// The attributes of a file without points, which readers may know by their declarations alone.
std::vector<Attribute> declaredAttributes(const FileContents& contents) {
    std::vector<Attribute> attributes;
    for (const AttributeInfo& declared : contents.declared)
        attributes.push_back({declared.name, declared.components, {}, {}});
    return attributes;
}

/// Whether a name that the file declares is the attribute or one of its components, such as vx of v.
bool isPartOf(const std::string& declared, const std::string& attribute) {
    if (declared == attribute) return true;
    const auto part = componentName(declared);
    return part && part->vector == attribute;
}

bool isPosition(const std::string& declared) {
    static const std::set<std::string> names{"P", "x", "y", "z", "px", "py", "pz"};
    return names.contains(declared);
}

}  // namespace

ParticleSelector::ParticleSelector(const ParticleInput& input, std::string file)
    : input_(input), file_(std::move(file)) {
    if (!input.where.empty()) where_.emplace(input.where);
}

bool ParticleSelector::mayLeaveOut() const {
    return where_ || input_.box || !input_.group.empty() || input_.on_bad_particle == OnBadParticle::drop;
}

bool ParticleSelector::needs(const std::string& attribute) const {
    const std::vector<std::string> velocity = entriesOf(input_.velocity);
    return (where_ && where_->uses(attribute)) ||
           std::any_of(velocity.begin(), velocity.end(),
                       [&](const std::string& name) { return name == attribute || isPartOf(name, attribute); });
}

bool ParticleSelector::needsAttributes() const {
    return where_ || !input_.group.empty() || input_.on_bad_particle == OnBadParticle::drop;
}

void ParticleSelector::keepMembers(const FileContents& points, RowIndices& rows) const {
    std::vector<const Attribute*> groups;
    for (const std::string& name : input_.group) {
        const auto found = std::find_if(points.attributes.begin(), points.attributes.end(), [&](const Attribute& a) {
            return a.name.starts_with(kGroupPrefix) && a.name.substr(kGroupPrefix.size()) == name;
        });
        if (found != points.attributes.end()) {
            groups.push_back(&*found);
            continue;
        }
        std::vector<std::string> known;
        for (const Attribute& a : points.attributes)
            if (a.name.starts_with(kGroupPrefix)) known.push_back(a.name.substr(kGroupPrefix.size()));
        throw Error(file_ + ": " + unknownGroup(name, known));
    }
    std::erase_if(rows, [&](std::uint32_t row) {
        return std::none_of(groups.begin(), groups.end(), [&](const Attribute* a) { return a->integer[row] != 0; });
    });
}

void ParticleSelector::keepInside(const FileContents& points, RowIndices& rows) const {
    const std::array<double, 6>& box = *input_.box;
    std::erase_if(rows, [&](std::uint32_t row) {
        const Vec3 p = Vec3(points.position[row]) + input_.origin;
        for (int axis = 0; axis < 3; ++axis) {
            const auto low = static_cast<std::size_t>(axis);
            if (!(p[axis] >= box[low] && p[axis] <= box[low + 3])) return true;
        }
        return false;
    });
}

void ParticleSelector::keepFinite(const FileContents& points, RowIndices& rows, std::size_t first_row) {
    const bool drops = input_.on_bad_particle == OnBadParticle::drop;
    std::optional<VelocitySource> velocity;
    if (drops || checks_ == Checks::velocities)
        velocity =
            findVelocity(points.attributes, points.position.size(), input_.velocity, attributeNames(points), file_);
    const auto fail = [&](std::uint32_t row, const char* what, const Vec3f& value) {
        const std::string text = "particle " + std::to_string(first_row + row) + ": " + what + " is " + numbers(value);
        if (!drops)
            throw Error(file_ + ": " + text + "; expected finite numbers" + noteOnLost(lost_numbers_, first_row + row) +
                        ". Use --on-bad-particle drop to leave such particles out.");
        if (dropped_++ == 0) first_dropped_ = text;
        return true;
    };
    std::erase_if(rows, [&](std::uint32_t row) {
        if (!isFinite(points.position[row])) return fail(row, "position", points.position[row]);
        if (!velocity) return false;
        const Vec3f v = velocityOf(points.attributes, *velocity, row);
        return !isFinite(v) && fail(row, "velocity", v);
    });
}

void ParticleSelector::choose(FileContents& points) {
    const std::size_t n = points.position.size(), first_row = std::exchange(row_, row_ + n);
    for (LostNumber lost : points.lost_numbers) {
        lost.particle += first_row;
        noteLost(std::move(lost), lost_numbers_);
    }
    if (n == 0 || (!mayLeaveOut() && checks_ == Checks::none)) return;
    RowIndices rows;
    if (where_) {
        rows = where_->rowsWhereTrue(points, file_, input_.origin);
    } else {
        rows.resize(n);
        std::iota(rows.begin(), rows.end(), 0U);
    }
    if (!input_.group.empty()) keepMembers(points, rows);
    if (input_.box) keepInside(points, rows);
    keepFinite(points, rows, first_row);
    if (rows.size() < n) keepRows(rows, points);
}

InputSummary ParticleSelector::summary(const FileContents& kept, const FileContents& rest) const {
    InputSummary summary;
    summary.particles_read = row_;
    summary.dropped = dropped_;
    summary.polygons = rest.unread_polygons;
    summary.first_dropped = first_dropped_;
    summary.lost_numbers = lost_numbers_;
    const auto velocity = findVelocity(kept.attributes.empty() ? declaredAttributes(kept) : kept.attributes,
                                       kept.position.size(), input_.velocity, attributeNames(kept), file_);
    if (velocity) {
        summary.velocity = velocity->name;
    } else {
        summary.incomplete_velocity = incompleteVelocity(kept.attributes, kept.position.size());
        summary.velocity_candidates = velocityCandidates(kept.attributes);
    }

    using Kind = InputPart::Kind;
    for (const GridInfo& grid : rest.grids)
        summary.parts.push_back({Kind::grid, grid.name, grid.type, grid.is_read ? "position" : ""});
    for (const std::string& group : rest.groups) {
        const bool chooses = std::find(input_.group.begin(), input_.group.end(), group) != input_.group.end();
        summary.parts.push_back({Kind::group, group, "", chooses ? "selection" : ""});
    }
    const std::string id = input_.id.empty() ? "id" : input_.id;
    const std::vector<std::string> velocity_names = entriesOf(summary.velocity);
    const auto isVelocity = [&](const std::string& name) {
        return std::ranges::any_of(velocity_names, [&](const std::string& vector) {
            // Beside an attribute 'v' another one, 'v_x', is no component of it.
            const bool is_whole = std::ranges::find(kept.declared, vector, &AttributeInfo::name) != kept.declared.end();
            return is_whole ? name == vector : isPartOf(name, vector);
        });
    };
    for (const AttributeInfo& declared : kept.declared) {
        if (declared.type == "group") continue;
        const std::string& name = declared.name;
        std::string use;
        if (isPosition(name))
            use = "position";
        else if (name == id && !kept.id.empty())
            use = "id";
        else if (isVelocity(name))
            use = "velocity";
        else if (where_ && where_->uses(name))
            use = "selection";
        const std::string components =
            declared.components > 1 ? std::to_string(declared.components) + " " : std::string();
        summary.parts.push_back({Kind::attribute, name, components + declared.type, use});
    }
    summary.warnings = rest.warnings;
    const auto addOther = [&](const std::string& what, const char* use) {
        if (!what.empty()) summary.parts.push_back({Kind::other, what, "", use});
    };
    addOther(rest.units.up_axis_note, input_.up_axis == UpAxis::z ? "position" : "");
    addOther(rest.units.meters_per_unit_note, "");
    for (const std::string& what : rest.passed_over) addOther(what, "");
    summary.z_is_up = rest.units.up_axis == UpAxis::z;
    summary.frames_per_second = rest.units.frames_per_second;
    summary.meters_per_unit = rest.units.meters_per_unit;
    return summary;
}

std::string dropBadParticles(const std::string& file, FileContents& contents) {
    ParticleInput input;
    input.on_bad_particle = OnBadParticle::drop;
    ParticleSelector selector(input, file);
    selector.choose(contents);
    const InputSummary summary = selector.summary(contents, contents);
    if (summary.dropped == 0) return {};
    return std::to_string(summary.dropped) + (summary.dropped > 1 ? " particles are" : " particle is") +
           " left out because the position or velocity is not finite; the first: " + summary.first_dropped;
}

}  // namespace betamesh
