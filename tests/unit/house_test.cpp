// The order of the house: which file may include what. Read from the sources themselves.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

// A room includes itself and rooms of lower floors.
const std::map<std::string, int> kFloors{{"cmd", 4},     {"batch", 3}, {"skin", 2},   {"planar", 2}, {"preview", 2},
                                         {"measure", 2}, {"io", 2},    {"sample", 2}, {"exact", 1},  {"core", 0}};

// How a library's headers begin -> the files that include them.
const std::vector<std::pair<std::string, std::vector<std::string>>> kDoors{
    {"CLI/", {"cmd/command.h", "cmd/job_options.h", "cmd/picture_options.h"}},
    {"Imath/", {"core/vec3.h"}},
    {"OpenEXR/", {"preview/exr_file.cpp"}},
    {"blosc.h", {"io/houdini_scf.cpp"}},
    {"boost/multiprecision/", {"exact/orientation.cpp"}},
    {"dlfcn.h", {"core/module.cpp"}},
    {"embree3/", {"preview/ray_tracer.cpp"}},
    {"freetype/", {"preview/text.cpp"}},
    {"nlohmann/", {"batch/report.cpp"}},
    {"openvdb/", {"io/vdb_file.cpp"}},
    {"png.h", {"preview/png_file.cpp"}},
    {"spdlog/", {"batch/log.cpp"}},
    {"tbb/", {"core/parallel.h"}},
    {"xxhash.h", {"batch/origin.cpp"}},
    {"yaml-cpp/", {"batch/config.cpp"}},
    {"zlib.h", {"io/gzip.cpp"}},
};
const std::vector<std::string> kSystem{"fcntl.h",    "linux/",  "malloc.h", "poll.h", "pthread.h",
                                       "sanitizer/", "sched.h", "signal.h", "sys/",   "unistd.h"};

template <typename T>
bool contains(const std::vector<T>& all, const T& one) {
    return std::find(all.begin(), all.end(), one) != all.end();
}

std::string roomOf(const std::string& file) { return file.substr(0, file.find('/')); }

std::string withoutExtension(const std::string& file) { return file.substr(0, file.rfind('.')); }

/// What is wrong with a file, named from lib or as cmd/NAME, that includes one of ours; empty if nothing is.
std::string faultOfOurs(const std::string& file, const std::string& header) {
    const std::string room = roomOf(file);
    const std::string other = header.find('/') == std::string::npos ? room : roomOf(header);
    if (!kFloors.contains(room)) return "a room that the house does not have";
    if (!kFloors.contains(other)) return "includes from no room of the house";
    if (other == room) return "";
    return kFloors.at(other) < kFloors.at(room) ? "" : "includes upwards or sideways";
}

/// The same for a header in angle brackets.
std::string faultOfTheirs(const std::string& file, const std::string& header) {
    const auto begins = [&](const std::string& start) { return header.starts_with(start); };
    for (const auto& [start, doors] : kDoors) {
        if (begins(start)) return contains(doors, file) ? "" : "is not the door of this library";
    }
    const bool standard = header.find_first_of("/.") == std::string::npos;
    return standard || std::any_of(kSystem.begin(), kSystem.end(), begins) ? "" : "of a library without a door";
}

std::string faultOf(const std::string& file, const std::string& line) {
    const std::size_t begin = line.find_first_of("<\"");
    const std::size_t end = line.find_last_of(">\"");
    if (begin == std::string::npos || begin == end) return "an #include without a name";
    const std::string header = line.substr(begin + 1, end - begin - 1);
    return line[begin] == '<' ? faultOfTheirs(file, header) : faultOfOurs(file, header);
}

TEST(House, IncludesKeepToTheOrderOfRoomsStagesAndDoors) {
    const fs::path source(BETAMESH_SOURCE);
    int includes = 0;
    for (const fs::path& part : {source / "lib", source / "cmd"}) {
        const fs::path base = part.filename() == "lib" ? part : source;
        for (const auto& entry : fs::recursive_directory_iterator(part)) {
            if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
            const std::string file = entry.path().lexically_relative(base).generic_string();
            std::ifstream lines(entry.path());
            for (std::string line; std::getline(lines, line);) {
                if (!line.starts_with("#include")) continue;
                ++includes;
                EXPECT_EQ(faultOf(file, line), "") << file << ": " << line;
            }
        }
    }
    EXPECT_GT(includes, 300);
}

// Stages, each a header and its source, may include those that do not include them, directly or through others.
TEST(House, NoStageIncludesItselfThroughOthers) {
    const fs::path lib = fs::path(BETAMESH_SOURCE) / "lib";
    std::map<std::string, std::set<std::string>> includes;
    for (const auto& entry : fs::recursive_directory_iterator(lib)) {
        if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
        const std::string file = withoutExtension(entry.path().lexically_relative(lib).generic_string());
        if (roomOf(file) != "skin" && roomOf(file) != "planar") continue;
        std::ifstream lines(entry.path());
        for (std::string line; std::getline(lines, line);) {
            if (!line.starts_with("#include \"")) continue;
            const std::size_t begin = line.find('"') + 1;
            const std::string other = withoutExtension(line.substr(begin, line.rfind('"') - begin));
            if (other != file) includes[file].insert(other);
        }
    }
    std::set<std::string> done, under_way;
    std::string cycle;
    const std::function<bool(const std::string&)> hasCycle = [&](const std::string& file) {
        if (done.contains(file)) return false;
        if (!under_way.insert(file).second) return true;
        for (const std::string& other : includes[file])
            if (hasCycle(other)) {
                cycle += file + " includes " + other + "; ";
                return true;
            }
        under_way.erase(file);
        return !done.insert(file).second;
    };
    std::vector<std::string> files;
    for (const auto& [file, others] : includes) files.push_back(file);
    for (const std::string& file : files) ASSERT_FALSE(hasCycle(file)) << cycle;
    EXPECT_GT(files.size(), 30u);
}

TEST(House, RulesTellRightFromWrong) {
    const auto right = [](const std::string& file, const std::string& header) {
        EXPECT_EQ(faultOf(file, "#include " + header), "") << file << ' ' << header;
    };
    const auto wrong = [](const std::string& file, const std::string& header) {
        EXPECT_NE(faultOf(file, "#include " + header), "") << file << ' ' << header;
    };
    right("cmd/mesh.cpp", "\"command.h\"");
    right("cmd/info.cpp", "\"skin/spacing.h\"");
    right("skin/stage.cpp", "\"skin/stage.h\"");
    right("skin/skin_frame.cpp", "\"skin/stage.h\"");
    right("planar/skin_plane.cpp", "\"planar/stage.h\"");
    right("skin/stage.cpp", "\"skin/earlier_stage.h\"");
    right("io/ply.cpp", "\"io/bytes.h\"");
    right("core/parallel.h", "<tbb/parallel_for.h>");
    right("io/bytes.cpp", "<sys/stat.h>");
    right("core/graph.h", "<vector>");

    wrong("core/mesh.h", "\"exact/predicates.h\"");
    wrong("exact/predicates.cpp", "\"skin/stage.h\"");
    wrong("io/ply.cpp", "\"batch/log.h\"");
    wrong("io/ply.cpp", "\"skin/spacing.h\"");
    wrong("batch/job.cpp", "\"cmd/command.h\"");
    wrong("planar/skin_plane.cpp", "\"skin/stage.h\"");
    wrong("skin/stage.cpp", "\"measure/mesh_measure.h\"");
    wrong("attic/a.cpp", "\"core/mesh.h\"");
    wrong("core/mesh.h", "\"attic/a.h\"");
    wrong("io/ply.cpp", "<openvdb/openvdb.h>");
    wrong("skin/stage.cpp", "<tbb/parallel_for.h>");
    wrong("cmd/info.cpp", "<nlohmann/json.hpp>");
    wrong("skin/stage.cpp", "<boost/container/small_vector.hpp>");
    wrong("skin/stage.cpp", "<Eigen/Dense>");
}

}  // namespace
}  // namespace betamesh
