#include "io/particle_input.h"

#include "base/list_entries.h"
#include "base/lower_case.h"
#include "base/parallel.h"
#include "betamesh/error.h"
#include "io/up_axis.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

namespace betamesh {

namespace {

/// A name in lower case without a unit in brackets: "Vel.x [m/s]" becomes "vel.x".
std::string plainName(const std::string& name) {
    std::string plain = lowerCase(name);
    for (const char* unit : {" [", "_[", " (", "_("})
        if (const std::size_t at = plain.find(unit); at != std::string::npos && at > 0) plain.erase(at);
    return plain;
}

bool isFloatVector(const Attribute& a, std::size_t n) { return a.components == 3 && a.real.size() == 3 * n; }

bool isScalar(const Attribute& a, std::size_t n) { return a.components == 1 && a.real.size() + a.integer.size() == n; }

VelocitySource oneAttribute(std::size_t index, const std::string& name) {
    return {{{{index, 0}, {index, 1}, {index, 2}}}, name, true};
}

/// One component of the velocity by its requested name: an attribute of one number, or a component of a vector.
VelocitySource::Component requestedComponent(const std::vector<Attribute>& attributes, std::size_t n,
                                             const std::string& name, const std::string& known,
                                             const std::string& file) {
    const auto part = componentName(name);
    for (std::size_t a = 0; a < attributes.size(); ++a) {
        if (attributes[a].name == name && isScalar(attributes[a], n)) return {a, 0};
        if (part && attributes[a].name == part->vector && part->index < attributes[a].components)
            return {a, part->index};
    }
    throw Error(file + ": has no velocity attribute '" + name + "' with one number per point. The file has " + known +
                ". Name one of these, or leave --velocity out (input.velocity).");
}

VelocitySource requestedVelocity(const std::vector<Attribute>& attributes, std::size_t n, const std::string& requested,
                                 const std::string& known, const std::string& file) {
    const std::vector<std::string> names = entriesOf(requested);
    if (names.size() == 3) {
        VelocitySource source{{}, names[0] + ", " + names[1] + ", " + names[2], false};
        for (std::size_t k = 0; k < 3; ++k) source.xyz[k] = requestedComponent(attributes, n, names[k], known, file);
        return source;
    }
    const auto found =
        std::find_if(attributes.begin(), attributes.end(), [&](const Attribute& a) { return a.name == requested; });
    if (found == attributes.end())
        throw Error(file + ": has no velocity attribute '" + requested + "'. The file has " + known +
                    ". Name one of these, three components as in vx,vy,vz, or leave --velocity out (input.velocity).");
    if (!isFloatVector(*found, n))
        throw Error(file + ": velocity attribute '" + requested + "' has " + std::to_string(found->components) +
                    (found->real.empty() ? " integers" : " floats") + " per point, but needs 3 floats");
    return oneAttribute(static_cast<std::size_t>(found - attributes.begin()), requested);
}

/// The names that the components of a vector may have, in lower case.
std::vector<std::array<std::string, 3>> namesOfComponents(const std::string& vector) {
    std::vector<std::array<std::string, 3>> names;
    for (const std::string_view endings : {"xyz", "012", "123", "uvw"}) {
        const auto add = [&](const std::string& before, const std::string& after) {
            names.push_back({before + endings[0] + after, before + endings[1] + after, before + endings[2] + after});
        };
        for (const char* separator : {"", "_", ".", ":", " "}) add(vector + separator, "");
        add(vector + "[", "]");
    }
    return names;
}

/// The usual names of three attributes that are a velocity together.
std::vector<std::array<std::string, 3>> velocityTriples() {
    std::vector<std::array<std::string, 3>> triples;
    for (const char* vector : {"v", "velocity", "vel", "velocities"})
        for (auto& names : namesOfComponents(vector)) triples.push_back(std::move(names));
    triples.push_back({"u", "v", "w"});
    return triples;
}

std::optional<VelocitySource> usualVelocity(const std::vector<Attribute>& attributes, std::size_t n) {
    const auto find = [&](const auto& isWanted) -> std::optional<std::size_t> {
        const auto found = std::find_if(attributes.begin(), attributes.end(), isWanted);
        if (found == attributes.end()) return std::nullopt;
        return static_cast<std::size_t>(found - attributes.begin());
    };
    for (const char* name : {"v", "velocity", "vel"})
        if (const auto a = find([&](const Attribute& x) { return x.name == name && isFloatVector(x, n); }))
            return oneAttribute(*a, name);
    for (const char* name : {"v", "velocity", "vel", "velocities", "u"})
        if (const auto a = find([&](const Attribute& x) { return plainName(x.name) == name && isFloatVector(x, n); }))
            return oneAttribute(*a, attributes[*a].name);
    const bool has_scalars =
        std::count_if(attributes.begin(), attributes.end(), [&](const Attribute& x) { return isScalar(x, n); }) >= 3;
    if (!has_scalars) return std::nullopt;
    for (const auto& names : velocityTriples()) {
        VelocitySource source;
        std::size_t k = 0;
        for (; k < 3; ++k) {
            const auto a = find([&](const Attribute& x) { return plainName(x.name) == names[k] && isScalar(x, n); });
            if (!a) break;
            source.xyz[k] = {*a, 0};
            source.name += (k > 0 ? ", " : "") + attributes[*a].name;
        }
        if (k == 3) return source;
    }
    return std::nullopt;
}

/// The rotation of up axis z to y.
template <typename T>
void turn(T* v) {
    const T y = v[1];
    v[1] = v[2];
    v[2] = -y;
}

void transform(float* vectors, std::size_t n, double scale, UpAxis up) {
    if (scale == 1 && up == UpAxis::y) return;
    parallelFor(n, 4096, [&](std::size_t i) {
        float* v = vectors + 3 * i;
        if (scale != 1)
            for (int k = 0; k < 3; ++k) v[k] = static_cast<float>(static_cast<double>(v[k]) * scale);
        if (up == UpAxis::z) turn(v);
    });
}

}  // namespace

std::string describe(const LostNumber& lost) {
    std::ostringstream text;
    if (std::abs(lost.value) < std::numeric_limits<double>::max())
        text << lost.value;
    else
        text << "beyond 1.8e308";
    if (lost.line > 0) text << " (line " << lost.line << ')';
    text << ", which is too large for single precision";
    return text.str();
}

std::string noteOnLost(const std::vector<LostNumber>& numbers, std::uint64_t particle) {
    const auto lost = std::ranges::find(numbers, particle, &LostNumber::particle);
    return lost == numbers.end() ? "" : ". In the file, '" + lost->attribute + "' is " + describe(*lost);
}

std::optional<VelocitySource> findVelocity(const std::vector<Attribute>& attributes, std::size_t n,
                                           const std::string& requested, const std::string& known,
                                           const std::string& file) {
    if (!requested.empty()) {
        if (n == 0) return std::nullopt;  // files without particles may lack attributes
        return requestedVelocity(attributes, n, requested, known, file);
    }
    return usualVelocity(attributes, n);
}

std::string incompleteVelocity(const std::vector<Attribute>& attributes, std::size_t n) {
    for (const Attribute& a : attributes)
        for (const char* name : {"v", "velocity", "vel", "velocities"})
            if (a.components == 2 && plainName(a.name) == name) return "'" + a.name + "' has x and y, but z is missing";
    std::vector<std::string> pair, third;  // 'v_1' and 'v_2' lack 'v_0' or 'v_3'
    for (const auto& names : velocityTriples()) {
        if (names[0] == "u") continue;  // u and v are often coordinates of textures
        std::vector<std::string> there, missing;
        for (const std::string& name : names) {
            const auto a = std::ranges::find_if(
                attributes, [&](const Attribute& x) { return plainName(x.name) == name && isScalar(x, n); });
            if (a != attributes.end())
                there.push_back(a->name);
            else
                missing.push_back(name);
        }
        if (missing.size() != 1 || (!pair.empty() && there != pair)) continue;
        pair = there;
        third.push_back("'" + missing[0] + "'");
    }
    if (pair.empty()) return {};
    return "there are '" + pair[0] + "' and '" + pair[1] + "', but " +
           (third.size() > 1 ? "either " + third[0] + " or " + third[1] : third[0]) + " is missing";
}

std::vector<std::string> velocityCandidates(const std::vector<Attribute>& attributes) {
    std::vector<std::string> candidates;
    std::vector<std::pair<std::string, std::vector<std::string>>> vectors;
    for (const Attribute& a : attributes) {
        if (a.components == 3 && !a.real.empty()) candidates.push_back(a.name);
        const auto part = a.components == 1 ? componentName(a.name) : std::nullopt;
        if (!part) continue;
        auto found =
            std::find_if(vectors.begin(), vectors.end(), [&](const auto& v) { return v.first == part->vector; });
        if (found == vectors.end()) found = vectors.insert(vectors.end(), {part->vector, {}});
        found->second.push_back(a.name);
    }
    for (const auto& [vector, names] : vectors)
        if (names.size() == 3) candidates.push_back(names[0] + "," + names[1] + "," + names[2]);
    return candidates;
}

std::optional<ComponentName> componentName(const std::string& name) {
    const auto indexOf = [](char c) -> std::optional<std::size_t> {
        for (const std::string_view endings : {"xyzw", "0123456789"})
            if (const std::size_t at = endings.find(lowerCase(c)); at != std::string_view::npos) return at;
        return std::nullopt;
    };
    if (name.size() == 2 && std::isalpha(static_cast<unsigned char>(name[1])))  // vx
        if (const auto index = indexOf(name[1])) return ComponentName{name.substr(0, 1), *index};
    if (name.size() < 3) return std::nullopt;
    if (name.size() > 3 && name.back() == ']' && name[name.size() - 3] == '[') {
        if (const auto index = indexOf(name[name.size() - 2]))
            return ComponentName{name.substr(0, name.size() - 3), *index};
        return std::nullopt;
    }
    const char before = name[name.size() - 2];
    const auto index = indexOf(name.back());
    if (!index || std::string_view("_.: ").find(before) == std::string_view::npos) return std::nullopt;
    return ComponentName{name.substr(0, name.size() - 2), *index};
}

void toWorld(const ParticleInput& input, std::vector<Vec3f>& positions) {
    if (!positions.empty()) transform(&positions[0].x, positions.size(), input.scale, input.up_axis);
}

Vec3 worldOrigin(const ParticleInput& input, UpAxis up_axis) {
    const Vec3 origin = input.origin * input.scale;
    if (input.up_axis == up_axis) return origin;
    return up_axis == UpAxis::y ? Vec3(origin.x, origin.z, -origin.y) : Vec3(origin.x, -origin.z, origin.y);
}

void toWorld(const ParticleInput& input, Particles& particles) {
    if (!particles.velocity.empty())
        transform(&particles.velocity[0].x, particles.velocity.size(),
                  input.scale * input.velocity_scale * input.time_scale, input.up_axis);
    for (Attribute& a : particles.attributes) {
        if (isAcceleration(a))
            transform(a.real.data(), a.real.size() / 3, input.scale * input.time_scale * input.time_scale,
                      input.up_axis);
        if (isNormal(a)) transform(a.real.data(), a.real.size() / 3, 1, input.up_axis);
    }
}

}  // namespace betamesh
