
#include "io/obj.h"

#include "mesh/normals.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace betamesh {

namespace {

constexpr const char* kObjectPrefix = "component_";

class ObjReader {
public:
    ObjReader(std::string_view text, const std::string& file, FileContents& contents)
        : text_(text), file_(file), contents_(contents) {}

    void readAll() {
        while (!text_.empty()) {
            ++line_;
            const std::size_t end = std::min(text_.find('\n'), text_.size());
            readLine(text_.substr(0, end));
            text_.remove_prefix(std::min(end + 1, text_.size()));
        }
        if (any_component_ && !face_without_component_)
            contents_.component = std::move(components_);
        else if (any_component_)
            passOver("objects (o)");
        takeNormals();
        for (std::size_t i = 0; i < contents_.triangles.size(); ++i)
            for (const std::uint32_t corner : contents_.triangles[i])
                if (corner >= contents_.position.size())
                    throw Error(file_ + ": triangle " + std::to_string(i) + " has vertex " +
                                std::to_string(std::uint64_t{corner} + 1) + ", but the file has only " +
                                std::to_string(contents_.position.size()) + " vertices");
        for (const Edge& edge : contents_.edges)
            for (const std::uint32_t end : edge)
                if (end >= contents_.position.size())
                    throw Error(file_ + ": a line element has vertex " + std::to_string(std::uint64_t{end} + 1) +
                                ", but the file has only " + std::to_string(contents_.position.size()) + " vertices");
    }

private:
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(file_ + ": line " + std::to_string(line_) + ": " + text);
    }

    static std::string_view nextWord(std::string_view& line) {
        const std::size_t begin = std::min(line.find_first_not_of(" \t\r"), line.size());
        line.remove_prefix(begin);
        const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
        line.remove_prefix(word.size());
        return word;
    }

    void readLine(std::string_view line) {
        const std::string_view keyword = nextWord(line);
        if (keyword == "v") {
            readVertex(line);
        } else if (keyword == "vn") {
            readNormal(line);
        } else if (keyword == "f") {
            readFace(line);
        } else if (keyword == "o") {
            readObject(line);
        } else if (keyword == "l") {
            readCorners(line);
            for (std::size_t i = 1; i < corners_.size(); ++i) contents_.edges.push_back({corners_[i - 1], corners_[i]});
            contents_.declares_edges = true;
        } else if (!keyword.empty() && !keyword.starts_with('#')) {
            passOverLine(keyword, nextWord(line));
        }
    }

    void passOver(const std::string& what) {
        std::vector<std::string>& all = contents_.passed_over;
        if (std::find(all.begin(), all.end(), what) == all.end()) all.push_back(what);
    }

    void passOverLine(std::string_view keyword, std::string_view value) {
        if (keyword == "vt")
            passOver("texture coordinates (vt)");
        else if (keyword == "usemtl" || keyword == "mtllib")
            passOver("materials (mtllib, usemtl)");
        else if (keyword == "g")
            passOver("groups (g)");
        else if (keyword == "p")
            passOver("point elements (p)");
        else if (keyword != "s")
            passOver("lines of other kinds than v, vn, vt, f, l, p, o, g, s, mtllib and usemtl");
        else if (value != "off" && value != "0")
            passOver("smoothing groups (s)");
    }

    void readVertex(std::string_view line) {
        Vec3f p;
        for (int axis = 0; axis < 3; ++axis) p[axis] = number(nextWord(line));
        if (contents_.position.size() == std::numeric_limits<std::uint32_t>::max()) fail("more than 2^32 - 1 vertices");
        contents_.position.push_back(p);
        if (nextWord(line).empty()) return;
        nextWord(line);
        passOver(nextWord(line).empty() ? "weights of vertices" : "colours of vertices");
    }

    void readNormal(std::string_view line) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto value = numberOf(nextWord(line));
            other_normals_ = other_normals_ || !value;
            normals_.push_back(value.value_or(0));
        }
    }

    /// Normals become the attribute N if they are those of the vertices, in their order.
    void takeNormals() {
        if (normals_.empty()) return;
        if (other_normals_ || normals_.size() != 3 * contents_.position.size())
            return passOver("normals (vn) that are not one per vertex");
        Attribute n;
        n.name = "N";
        n.components = 3;
        n.real = std::move(normals_);
        contents_.declared.push_back({"N", "float", 3, {}});
        contents_.attributes.push_back(std::move(n));
    }

    float number(std::string_view word) const {
        const auto value = numberOf(word);
        if (!value) fail("a vertex needs three numbers");
        return *value;
    }

    static std::optional<float> numberOf(std::string_view word) {
        if (word.starts_with('+')) word.remove_prefix(1);
        double value = 0;
        float single = 0;
        const char* end = word.data() + word.size();
        const auto as_float = std::from_chars(word.data(), end, single);
        if (as_float.ec == std::errc() && as_float.ptr == end) return single;
        const auto as_double = std::from_chars(word.data(), end, value);
        if (as_double.ec != std::errc() || as_double.ptr != end) return std::nullopt;
        return static_cast<float>(value);
    }

    void readFace(std::string_view line) {
        readCorners(line);
        other_normals_ = other_normals_ || other_normal_;
        if (corners_.size() < 3)
            fail("a face has " + std::to_string(corners_.size()) + " corners; it needs at least 3");
        appendFan(corners_, contents_.triangles);
        components_.resize(contents_.triangles.size(), component_.value_or(0));
        face_without_component_ = face_without_component_ || !component_;
    }

    void readObject(std::string_view line) {
        const std::string_view name = nextWord(line), start = kObjectPrefix;
        component_.reset();
        std::int32_t number = 0;
        const char* end = name.data() + name.size();
        const bool is_component = name.starts_with(start);
        const auto [stop, error] = std::from_chars(is_component ? name.data() + start.size() : end, end, number);
        if (error != std::errc() || stop != end) return passOver("objects (o)");
        component_ = number;
        any_component_ = true;
    }

    void readCorners(std::string_view line) {
        corners_.clear();
        other_normal_ = false;
        for (std::string_view word = nextWord(line); !word.empty(); word = nextWord(line)) {
            const std::size_t texture = word.find('/'), normal = word.rfind('/');
            const auto index = indexOf(word.substr(0, texture), contents_.position.size());
            if (!index) fail("vertex indices must be integers: 1, 2 … or, counted from the last vertex, -1, -2 …");
            corners_.push_back(*index);
            other_normal_ =
                other_normal_ || normal == texture || indexOf(word.substr(normal + 1), normals_.size() / 3) != index;
        }
    }

    /// Counted from 0; nothing unless the word is 1, 2 … or, counted from the last of `count`, -1, -2 …
    static std::optional<std::uint32_t> indexOf(std::string_view word, std::size_t count) {
        std::int64_t index = 0;
        const char* end = word.data() + word.size();
        const auto [stop, error] = std::from_chars(word.data(), end, index);
        if (error == std::errc() && index < 0) index += static_cast<std::int64_t>(count) + 1;
        if (error != std::errc() || stop != end || index < 1 || index > std::numeric_limits<std::uint32_t>::max())
            return std::nullopt;
        return static_cast<std::uint32_t>(index - 1);
    }

    std::string_view text_;
    const std::string& file_;
    FileContents& contents_;
    std::size_t line_ = 0;
    std::vector<std::uint32_t> corners_;
    std::vector<float> normals_;             // of the lines vn, three numbers each
    bool other_normal_ = false;              // a corner in corners_ has none, or that of another index
    bool other_normals_ = false;             // any face has such a corner, or a normal is not three numbers
    std::optional<std::int32_t> component_;  // of the current object
    bool any_component_ = false, face_without_component_ = false;
    std::vector<std::int32_t> components_;  // of the triangles read so far
};

template <typename Value>
void writeNumber(ByteWriter& out, Value value) {
    std::array<char, 32> text;
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
    out.text({text.data(), static_cast<std::size_t>(end - text.data())});
}

void writeVectors(ByteWriter& out, const char* keyword, const std::vector<Vec3>& vectors) {
    for (const Vec3& v : vectors) {
        out.text(keyword);
        for (int axis = 0; axis < 3; ++axis) {
            out.text(" ");
            writeNumber(out, static_cast<float>(v[axis]));
        }
        out.text("\n");
    }
}

void writeVertices(ByteWriter& out, const std::vector<Vec3>& position) {
    out.text("# betamesh: world units\n");
    writeVectors(out, "v", position);
}

}  // namespace

FileContents parseObj(std::span<const std::byte> bytes, const std::string& file) {
    FileContents contents;
    contents.format = "obj";
    contents.declared.push_back({"v", "float", 3, {}});
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.find('\0') != std::string_view::npos)
        throw Error(file + ": contains zero bytes, so it is not an .obj text file");
    ObjReader(text, file, contents).readAll();
    contents.declares_faces = !contents.declares_edges || !contents.triangles.empty();
    return contents;
}

void encodeObj(ByteWriter& out, const Mesh& mesh, const std::string& file) {
    requireWritable(mesh, file);
    writeVertices(out, mesh.position);
    writeVectors(out, "vn", normalsOf(mesh));
    const auto writeFace = [&](const Triangle& t) {
        out.text("f");
        for (const std::uint32_t corner : t) {
            out.text(" ");
            writeNumber(out, std::uint64_t{corner} + 1);
            out.text("//");
            writeNumber(out, std::uint64_t{corner} + 1);
        }
        out.text("\n");
    };
    if (!mesh.component) {
        for (const Triangle& t : mesh.triangles) writeFace(t);
    } else {
        const std::vector<std::int32_t>& component = *mesh.component;
        std::vector<std::uint32_t> order(component.size());
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return component[a] < component[b]; });
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (i == 0 || component[order[i]] != component[order[i - 1]]) {
                out.text("o ");
                out.text(kObjectPrefix);
                writeNumber(out, component[order[i]]);
                out.text("\n");
            }
            writeFace(mesh.triangles[order[i]]);
        }
    }
    out.flush();
}

void encodeObj(ByteWriter& out, const Curves& curves, const std::string& file) {
    requireWritable(curves, file);
    writeVertices(out, curves.position);
    for (const std::span<const Edge> line : linesOf(curves)) {
        out.text("l ");
        writeNumber(out, std::uint64_t{line.front()[0]} + 1);
        for (const Edge& edge : line) {
            out.text(" ");
            writeNumber(out, std::uint64_t{edge[1]} + 1);
        }
        out.text("\n");
    }
    out.flush();
}

}  // namespace betamesh
