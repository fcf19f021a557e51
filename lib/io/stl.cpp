#include "io/stl.h"

#include "betamesh/error.h"
#include "io/file_contents.h"

#include <array>
#include <limits>

namespace betamesh {

void encodeStl(ByteWriter& out, const Mesh& mesh, const std::string& file) {
    constexpr std::size_t kTitle = 80;
    requireWritable(mesh, file);
    if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max())
        throw Error(file + ": " + std::to_string(mesh.triangles.size()) +
                    " triangles, expected less than 2^32 in .stl");
    std::string title = "betamesh";  // must not begin with "solid", by which text is told apart
    title.resize(kTitle, ' ');
    out.text(title);
    out.little(static_cast<std::uint32_t>(mesh.triangles.size()));
    const auto put = [&](const Vec3& v) {
        out.little(std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
    };
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        put(cross(b - a, c - a).normalized());
        for (const Vec3* corner : {&a, &b, &c}) put(*corner);
        out.little(std::uint16_t{0});
    }
    out.flush();
}

}  // namespace betamesh
