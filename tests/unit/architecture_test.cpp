// The architecture: which file may include which. Read from the sources themselves.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

// The level of each folder. A file may include files of its own folder and of folders at lower levels.
const std::map<std::string, int> kLevels{{"base", 0},   {"exact", 1}, {"mesh", 2},   {"skin", 3},
                                         {"planar", 4}, {"io", 3},    {"render", 3}, {"sample", 3},
                                         {"batch", 5},  {"cmd", 6},   {"python", 6}};

// Public headers, included as "betamesh/NAME", that belong to the lowest level. CMake makes version.h.
const std::set<std::string> kPublicHeaders{
    "betamesh/betamesh.h",    "betamesh/check.h", "betamesh/coherence.h", "betamesh/curves.h",   "betamesh/error.h",
    "betamesh/io.h",          "betamesh/mesh.h",  "betamesh/particles.h", "betamesh/simplify.h", "betamesh/skin.h",
    "betamesh/skin_params.h", "betamesh/vec3.h",  "betamesh/version.h"};
// Includes the others but kFiles, which needs another library.
const std::string kUmbrella = "betamesh/betamesh.h", kFiles = "betamesh/io.h";

// How the headers of a third-party library begin, and the files that may include them.
const std::vector<std::pair<std::string, std::vector<std::string>>> kThirdParty{
    {"CLI/", {"cmd/command.h", "cmd/job_options.h", "cmd/preview_options.h"}},
    {"Imath/", {"include/betamesh/vec3.h"}},
    {"OpenEXR/", {"render/exr_file.cpp"}},
    {"blosc.h", {"io/houdini_scf.cpp"}},
    {"boost/multiprecision/", {"exact/orientation.cpp"}},
    {"embree3/", {"render/ray_tracer.cpp"}},
    {"freetype/", {"render/text.cpp"}},
    {"nanobind/", {"python/binding.h"}},
    {"nlohmann/", {"batch/report/report.cpp"}},
    {"openvdb/", {"io/level_set.cpp", "io/vdb_file.h", "io/vdb_grid_file.h", "io/vdb_reader.cpp", "io/vdb_writer.cpp"}},
    {"png.h", {"render/png_file.cpp"}},
    {"pugixml.hpp", {"io/vtk_xml.cpp"}},
    {"muParser.h", {"io/attribute_expression.cpp"}},
    {"spdlog/", {"batch/report/log.cpp"}},
    {"tbb/", {"base/parallel.h"}},
    {"xxhash.h", {"io/digest.cpp"}},
    {"yaml-cpp/", {"batch/config/config.cpp"}},
    {"zlib.h", {"io/gzip.cpp"}},
};
const std::vector<std::string> kSystem{"fcntl.h",    "linux/",  "malloc.h", "poll.h", "pthread.h",
                                       "sanitizer/", "sched.h", "signal.h", "sys/",   "unistd.h"};

constexpr std::size_t kMostLines = 500;

// Identifiers that were replaced and must not return.
const std::set<std::string> kRetiredNames{"Rate",
                                          "Moving",
                                          "RateLanes",
                                          "MovingLanes",
                                          "MovingCircle",
                                          "RisingVertex",
                                          "TurningEdge",
                                          "SwellingVertex",
                                          "unborn",
                                          "LightTouch",
                                          "placesOf",
                                          "Rows",
                                          "RowsOf",
                                          "makeRoom",
                                          "resizeOnAll",
                                          "FileStamp",
                                          "watchOverWorkers",
                                          "FrameNotes",
                                          "slideWithParticles",
                                          "keepApart",
                                          "BodyCheck",
                                          "LeftOfWays",
                                          "Together",
                                          "rowsWhere",
                                          "kNone",
                                          "kUnused",
                                          "kAbsent",
                                          "kHidden"};

struct SourceFile {
    std::string name;  // relative to lib or, in cmd and tests, to the repository
    std::vector<std::string> lines;
};

std::vector<SourceFile> sourcesIn(const std::vector<std::string>& folders) {
    const fs::path repository(BETAMESH_SOURCE);
    std::vector<SourceFile> files;
    for (const std::string& folder : folders) {
        const fs::path base = folder == "lib" ? repository / "lib" : repository;
        for (const auto& entry : fs::recursive_directory_iterator(repository / folder)) {
            if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
            SourceFile& file = files.emplace_back();
            file.name = entry.path().lexically_relative(base).generic_string();
            std::ifstream in(entry.path());
            for (std::string line; std::getline(in, line);) file.lines.push_back(line);
        }
    }
    return files;
}

std::string folderOf(const std::string& file) { return file.substr(0, file.find('/')); }

std::string withoutExtension(const std::string& file) { return file.substr(0, file.rfind('.')); }

/// The file that a header in quotes stands for, relative to lib (or cmd/NAME).
std::string includedFile(const std::string& file, const std::string& header) {
    if (header.starts_with("betamesh/")) return "include/" + header;
    return header.find('/') == std::string::npos ? folderOf(file) + "/" + header : header;
}

/// What is wrong with a file, relative to lib or as cmd/NAME, that includes a header of the project; empty if nothing.
std::string faultOfOwn(const std::string& file, const std::string& header) {
    if (header.starts_with("betamesh/")) return kPublicHeaders.contains(header) ? "" : "is not a public header";
    const std::string from = folderOf(file);
    if (from == "include") return "is included by a public header, but is not public";
    const std::string to = folderOf(includedFile(file, header));
    if (!kLevels.contains(from)) return "is included from an unknown folder";
    if (!kLevels.contains(to)) return "is in an unknown folder";
    return from == to || kLevels.at(to) < kLevels.at(from) ? "" : "is not at a lower level";
}

/// The same for a header in angle brackets.
std::string faultOfThirdParty(const std::string& file, const std::string& header) {
    const auto begins = [&](const std::string& start) { return header.starts_with(start); };
    for (const auto& [start, wrappers] : kThirdParty)
        if (begins(start))
            return std::count(wrappers.begin(), wrappers.end(), file) > 0 ? "" : "may be included only by its wrapper";
    const bool standard = header.find_first_of("/.") == std::string::npos;
    return standard || std::any_of(kSystem.begin(), kSystem.end(), begins) ? ""
                                                                           : "belongs to a library without a wrapper";
}

std::string faultOf(const std::string& file, const std::string& line) {
    const std::size_t begin = line.find_first_of("<\"");
    const std::size_t end = line.find_last_of(">\"");
    if (begin == std::string::npos || begin == end) return "has no name";
    const std::string header = line.substr(begin + 1, end - begin - 1);
    return line[begin] == '<' ? faultOfThirdParty(file, header) : faultOfOwn(file, header);
}

TEST(Architecture, IncludesFollowTheLevelsAndWrappers) {
    int includes = 0;
    for (const SourceFile& file : sourcesIn({"lib", "cmd"}))
        for (const std::string& line : file.lines) {
            if (!line.starts_with("#include")) continue;
            ++includes;
            EXPECT_EQ(faultOf(file.name, line), "") << file.name << ": " << line;
        }
    EXPECT_GT(includes, 300);
}

// The umbrella header and the table in lib/README.md name all public headers.
TEST(Architecture, PublicHeadersAreDocumented) {
    const fs::path lib = fs::path(BETAMESH_SOURCE) / "lib";
    std::set<std::string> files, included{kUmbrella, kFiles}, documented;
    for (const auto& entry : fs::recursive_directory_iterator(lib / "include")) {
        if (!entry.is_regular_file()) continue;
        const fs::path file = entry.path().extension() == ".in" ? entry.path().stem() : entry.path().filename();
        files.insert("betamesh/" + file.generic_string());
    }
    EXPECT_EQ(files, kPublicHeaders);

    const auto betweenQuotes = [](const std::string& line, char quote, const auto& visit) {
        for (std::size_t begin = line.find(quote); begin != std::string::npos; begin = line.find(quote, begin + 1)) {
            const std::size_t end = line.find(quote, begin + 1);
            if (end == std::string::npos) return;
            visit(line.substr(begin + 1, end - begin - 1));
            begin = end;
        }
    };
    std::ifstream umbrella(lib / "include" / kUmbrella);
    for (std::string line; std::getline(umbrella, line);)
        if (line.starts_with("#include"))
            betweenQuotes(line, '"', [&](const std::string& name) { included.insert(name); });
    EXPECT_EQ(included, kPublicHeaders);

    std::ifstream readme(lib / "README.md");
    for (std::string line; std::getline(readme, line);)
        if (line.starts_with("| `betamesh/"))
            betweenQuotes(line, '`', [&](const std::string& name) {
                if (name.starts_with("betamesh/")) documented.insert(name);
            });
    EXPECT_EQ(documented, kPublicHeaders);
}

TEST(Architecture, EveryWrapperIncludesItsLibrary) {
    std::map<std::string, std::vector<std::string>> lines;
    for (SourceFile& file : sourcesIn({"lib", "cmd"})) lines[file.name] = std::move(file.lines);
    for (const auto& [start, wrappers] : kThirdParty)
        for (const std::string& wrapper : wrappers)
            EXPECT_TRUE(std::any_of(lines[wrapper].begin(), lines[wrapper].end(),
                                    [&](const std::string& line) { return line.starts_with("#include <" + start); }))
                << wrapper << " does not include " << start;
}

// A header and the source of the same name count as one unit, whose includes are those of both files.
TEST(Architecture, HasNoIncludeCycles) {
    std::map<std::string, std::set<std::string>> includes;
    for (const SourceFile& file : sourcesIn({"lib", "cmd"})) {
        const std::string unit = withoutExtension(file.name);
        for (const std::string& line : file.lines) {
            if (!line.starts_with("#include \"")) continue;
            const std::size_t begin = line.find('"') + 1;
            const std::string header = line.substr(begin, line.rfind('"') - begin);
            const std::string other = withoutExtension(includedFile(file.name, header));
            if (other != unit) includes[unit].insert(other);
        }
    }
    std::set<std::string> finished, open;
    std::string cycle;
    const std::function<bool(const std::string&)> hasCycle = [&](const std::string& unit) {
        if (finished.contains(unit)) return false;
        if (!open.insert(unit).second) return true;
        const std::set<std::string> others = includes[unit];
        for (const std::string& other : others)
            if (hasCycle(other)) {
                cycle += unit + " includes " + other + "; ";
                return true;
            }
        open.erase(unit);
        finished.insert(unit);
        return false;
    };
    std::vector<std::string> units;
    for (const auto& [unit, others] : includes) units.push_back(unit);
    for (const std::string& unit : units) ASSERT_FALSE(hasCycle(unit)) << cycle;
    EXPECT_GT(units.size(), 100u);
}

TEST(Architecture, NoFileOfTheLibraryIsTooLong) {
    for (const SourceFile& file : sourcesIn({"lib"})) EXPECT_LE(file.lines.size(), kMostLines) << file.name;
}

// Two definitions of one name are undefined behaviour that no compiler reports: the linker takes one of two functions.
TEST(Architecture, TypesHaveDifferentNames) {
    const std::regex definition("(struct|class|enum|enum class|union) (\\w+)( final)?( :.*)? \\{.*");
    std::map<std::string, std::string> file_of;
    for (const SourceFile& file : sourcesIn({"lib", "cmd"})) {
        bool is_private = false;  // in an anonymous namespace
        for (const std::string& line : file.lines) {
            if (line == "namespace {") is_private = true;
            if (line == "}  // namespace") is_private = false;
            std::smatch match;
            if (is_private || !std::regex_match(line, match, definition)) continue;
            const auto [first, is_new] = file_of.emplace(match[2], file.name);
            EXPECT_TRUE(is_new) << match[2] << " is defined in " << first->second << " and in " << file.name;
        }
    }
    EXPECT_GT(file_of.size(), 100u);
}

/// A line without its comment and string literals.
std::string codeOf(const std::string& line) {
    std::string code;
    bool in_string = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (in_string && line[i] == '\\') {
            ++i;
        } else if (line[i] == '"') {
            in_string = !in_string;
        } else if (!in_string && line.compare(i, 2, "//") == 0) {
            break;
        } else if (!in_string) {
            code += line[i];
        }
    }
    return code;
}

TEST(Architecture, RetiredNamesDoNotReturn) {
    const std::string self = "tests/unit/architecture_test.cpp";  // names them itself
    const auto isWordCharacter = [](char c) { return c == '_' || std::isalnum(static_cast<unsigned char>(c)) != 0; };
    for (const SourceFile& file : sourcesIn({"lib", "cmd", "tests"})) {
        if (file.name == self) continue;
        for (std::size_t i = 0; i < file.lines.size(); ++i) {
            const std::string line = codeOf(file.lines[i]);
            for (auto at = line.begin(); at != line.end();) {
                const auto begin = std::find_if(at, line.end(), isWordCharacter);
                at = std::find_if_not(begin, line.end(), isWordCharacter);
                const std::string word(begin, at);
                EXPECT_FALSE(kRetiredNames.contains(word)) << file.name << ':' << i + 1 << ": " << word;
            }
        }
    }
}

TEST(Architecture, RulesAcceptAndReject) {
    const auto accepts = [](const std::string& file, const std::string& header) {
        EXPECT_EQ(faultOf(file, "#include " + header), "") << file << ' ' << header;
    };
    const auto rejects = [](const std::string& file, const std::string& header) {
        EXPECT_NE(faultOf(file, "#include " + header), "") << file << ' ' << header;
    };
    accepts("cmd/mesh.cpp", "\"command.h\"");
    accepts("cmd/info.cpp", "\"skin/spacing.h\"");
    accepts("skin/stage.cpp", "\"skin/stage.h\"");
    accepts("skin/stage.cpp", "\"mesh/mesh_measure.h\"");
    accepts("skin/stage.cpp", "\"betamesh/mesh.h\"");
    accepts("cmd/main.cpp", "\"betamesh/version.h\"");
    accepts("planar/skin_plane.cpp", "\"skin/attributes.h\"");
    accepts("mesh/mesh_check.cpp", "\"exact/orientation.h\"");
    accepts("io/ply.cpp", "\"io/bytes.h\"");
    accepts("batch/job/job.cpp", "\"batch/report/log.h\"");
    accepts("include/betamesh/mesh.h", "\"betamesh/particles.h\"");
    accepts("base/parallel.h", "<tbb/parallel_for.h>");
    accepts("io/bytes.cpp", "<sys/stat.h>");
    accepts("base/random.h", "<vector>");
    accepts("python/objects.cpp", "\"batch/config/surface_params.h\"");

    rejects("base/box.h", "\"exact/predicates.h\"");
    rejects("exact/predicates.cpp", "\"skin/stage.h\"");
    rejects("mesh/mesh_check.cpp", "\"skin/stage.h\"");
    rejects("skin/stage.cpp", "\"planar/retract.h\"");
    rejects("io/ply.cpp", "\"batch/report/log.h\"");
    rejects("io/ply.cpp", "\"skin/spacing.h\"");
    rejects("render/shade.cpp", "\"io/ply.h\"");
    rejects("batch/job/job.cpp", "\"cmd/command.h\"");
    rejects("batch/job/job.cpp", "\"python/objects.h\"");
    rejects("include/betamesh/mesh.h", "\"base/box.h\"");
    rejects("base/box.h", "\"betamesh/no_such_header.h\"");
    rejects("attic/a.cpp", "\"base/box.h\"");
    rejects("base/box.h", "\"attic/a.h\"");
    rejects("io/ply.cpp", "<openvdb/openvdb.h>");
    rejects("skin/stage.cpp", "<tbb/parallel_for.h>");
    rejects("cmd/info.cpp", "<nlohmann/json.hpp>");
    rejects("skin/stage.cpp", "<boost/container/small_vector.hpp>");
    rejects("skin/stage.cpp", "<Eigen/Dense>");
}

}  // namespace
}  // namespace betamesh
