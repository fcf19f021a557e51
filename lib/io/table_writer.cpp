#include "io/table.h"

#include <array>
#include <charconv>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace betamesh {

namespace {

constexpr std::array kReserved{"x", "y", "z", "P", "vx", "vy", "vz", "v", "id"};

/// The names of the columns of an attribute: "a", "a.x" … "a.w" or "a[0]" …, of whole numbers in quotes.
std::string columnName(const Attribute& a, std::uint32_t component) {
    std::string name = a.name;
    if (a.components > 4)
        name += '[' + std::to_string(component) + ']';
    else if (a.components > 1)
        name += std::string(".") + "xyzw"[component];
    if (!a.hasIntegers() && name.find_first_of(",;\"") == std::string::npos) return name;
    std::string quoted = "\"";
    for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

class RowWriter {
public:
    explicit RowWriter(ByteWriter& out) : out_(out) {}

    template <typename Number>
    void number(Number value) {
        std::array<char, 64> text;
        const auto [end, error] = std::to_chars(text.data(), text.data() + text.size() - 2, value);
        std::string_view digits(text.data(), static_cast<std::size_t>(end - text.data()));
        cell(digits);
        if constexpr (std::is_floating_point_v<Number>)  // so that it does not look like an integer
            if (digits.find_first_not_of("-0123456789") == std::string_view::npos) out_.text(".0");
    }
    void vector(const Vec3f& v) {
        for (int axis = 0; axis < 3; ++axis) number(v[axis]);
    }
    void cell(std::string_view text) {
        if (!std::exchange(is_first_, false)) out_.text(",");
        out_.text(text);
    }
    void end() {
        out_.text("\n");
        is_first_ = true;
    }

private:
    ByteWriter& out_;
    bool is_first_ = true;
};

}  // namespace

void encodeTable(ByteWriter& out, const Particles& particles, const std::string& file) {
    const std::size_t n = particles.size();
    const bool has_velocity = !particles.velocity.empty() || n == 0, has_id = !particles.id.empty() || n == 0;
    requireWritable(particles, file);
    requireWritable(particles.attributes, n, {kReserved.begin(), kReserved.end()}, file);
    RowWriter row(out);
    for (const char* name : {"x", "y", "z"}) row.cell(name);
    if (has_velocity)
        for (const char* name : {"vx", "vy", "vz"}) row.cell(name);
    if (has_id) row.cell("id");
    for (const Attribute& a : particles.attributes)
        for (std::uint32_t c = 0; c < a.components; ++c) row.cell(columnName(a, c));
    row.end();
    for (std::size_t i = 0; i < n; ++i) {
        row.vector(particles.position[i]);
        if (has_velocity) row.vector(particles.velocity[i]);
        if (has_id) row.number(static_cast<std::int64_t>(particles.id[i]));
        for (const Attribute& a : particles.attributes)
            for (std::size_t k = i * a.components; k < (i + 1) * a.components; ++k)
                if (a.integer.empty())
                    row.number(a.real[k]);
                else
                    row.number(a.integer[k]);
        row.end();
    }
    out.flush();
}

}  // namespace betamesh
