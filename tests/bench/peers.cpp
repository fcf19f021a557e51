// Times whole processes, betamesh and other methods, in turn on the same particle file, in several rounds.
//
//     betamesh_peers [rounds] [particles | cloud=particles]…        prints Markdown tables

#include "peers.h"
#include "bench_clouds.h"
#include "io/file_info.h"
#include "io/mesh_file.h"
#include "io/particle_file.h"
#include "support/temporary_folder.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>

namespace betamesh {

namespace {

constexpr double kRadius = 1.5;  // of balls; the spacing of the clouds is 1
constexpr double kVoxel = 0.5, kSphere = 1, kSearch = 2;
constexpr std::size_t kMaxForAlgorithmOne = 20000;  // particles

const std::map<std::string, std::function<Mesh(const Particles&)>>& peers() {
    static const std::map<std::string, std::function<Mesh(const Particles&)>> all{
        {"cgal-delaunay", [](const Particles& p) { return cgalDelaunay(p, kRadius); }},
        {"cgal-fixed-alpha-shape", [](const Particles& p) { return cgalFixedAlphaShape(p, kRadius); }},
        {"algorithm-1", [](const Particles& p) { return algorithmOne(p, kRadius); }},
        {"openvdb-spheres", [](const Particles& p) { return openvdbSpheres(p, kSphere, kVoxel); }},
        {"openvdb-zhu-bridson", [](const Particles& p) { return openvdbZhuBridson(p, kSphere, kSearch, kVoxel); }},
    };
    return all;
}

struct Run {
    double seconds = 0;
    long kib = 0;  // peak memory
};

const std::map<std::string, Particles (*)(std::size_t)>& clouds() {
    static const std::map<std::string, Particles (*)(std::size_t)> all{
        {"splash", splash}, {"calm", calm}, {"clumped", clumped}};
    return all;
}

Run timed(const std::vector<std::string>& words) {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const auto begin = std::chrono::steady_clock::now();
    const pid_t process = fork();
    if (process == 0) {
        execv(arguments[0], arguments.data());
        _exit(127);
    }
    int status = 0;
    rusage usage{};
    wait4(process, &status, 0, &usage);
    if (status != 0) {
        std::fprintf(stderr, "%s %s failed\n", words[0].c_str(), words[1].c_str());
        std::exit(1);
    }
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), usage.ru_maxrss};
}

// Calls make() in a child process, because the memory that this process has used would count for the processes that it
// starts.
std::size_t inChild(const std::function<std::size_t()>& make) {
    std::array<int, 2> ends{};
    std::size_t made = 0;
    if (pipe(ends.data()) != 0) std::exit(1);
    const pid_t process = fork();
    if (process == 0) {
        made = make();
        _exit(::write(ends[1], &made, sizeof made) == sizeof made ? 0 : 1);
    }
    close(ends[1]);
    const bool read_all = read(ends[0], &made, sizeof made) == sizeof made;
    int status = 0;
    waitpid(process, &status, 0);
    close(ends[0]);
    if (!read_all || status != 0) std::exit(1);
    return made;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

void compare(const std::string& kind, std::size_t particles, int rounds) {
    const TemporaryFolder folder;
    const std::string in = folder / "in.ply";
    const std::size_t made = inChild([&] {
        const Particles cloud = clouds().at(kind)(particles);
        writeParticles(in, cloud);
        return cloud.size();
    });

    struct Tool {
        std::string name;
        std::vector<std::string> words;
        bool alpha_mesh = false;
        std::vector<double> seconds{};
        long kib = 0;
        std::size_t triangles = 0;
    };
    std::vector<Tool> tools;
    const auto addOurs = [&](const std::string& name, const std::vector<std::string>& more, bool alpha_mesh) {
        std::vector<std::string> words{BETAMESH_PROGRAM, "mesh", in, "", "--spacing", "1", "-q", "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        tools.push_back({name, words, alpha_mesh});
    };
    addOurs("betamesh, alpha mesh", {"--surface", "alpha"}, true);
    addOurs("betamesh", {}, false);
    addOurs("betamesh, one segment per arc", {"--arc-subdivisions", "1"}, false);
    for (const auto& [name, make] : peers())
        if (name != "algorithm-1" || particles <= kMaxForAlgorithmOne)
            tools.push_back({name, {"/proc/self/exe", "--as", name, in, ""}, !name.starts_with("openvdb")});

    for (int round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < tools.size(); ++i) {
            const std::size_t t =
                (i + static_cast<std::size_t>(round)) % tools.size();  // so that no tool is always the first
            const std::string out = folder / (std::to_string(t) + ".ply");
            for (std::string& word : tools[t].words)
                if (word.empty() || word == out) word = out;
            const Run run = timed(tools[t].words);
            tools[t].seconds.push_back(run.seconds);
            tools[t].kib = std::max(tools[t].kib, run.kib);
            tools[t].triangles = inChild([&] { return inspectFile(out).triangles; });
        }
    std::printf("\n%s: %zu particles, median of %d rounds\n\n", kind.c_str(), made, rounds);
    std::printf("| | seconds | ns per particle | MiB | triangles | betamesh / this | one segment / this |\n");
    std::printf("|---|---|---|---|---|---|---|\n");
    for (const Tool& tool : tools) {
        const double seconds = median(tool.seconds), ours = median(tools[tool.alpha_mesh ? 0 : 1].seconds);
        std::printf("| %s | %.3f | %.0f | %ld | %zu | %.2f | ", tool.name.c_str(), seconds,
                    seconds / static_cast<double>(made) * 1e9, tool.kib / 1024, tool.triangles, ours / seconds);
        if (!tool.alpha_mesh) std::printf("%.2f ", median(tools[2].seconds) / seconds);
        std::printf("|\n");
        std::fflush(stdout);
    }
}

}  // namespace

}  // namespace betamesh

int main(int count, char** words) {
    using namespace betamesh;
    const std::vector<std::string> arguments(words + 1, words + count);
    if (arguments.size() == 4 && arguments[0] == "--as") {
        writeMesh(arguments[3], peers().at(arguments[1])(readParticles(arguments[2])));
        return 0;
    }
    const int rounds = arguments.empty() ? 5 : std::stoi(arguments[0]);
    std::vector<std::string> chosen(arguments.begin() + (arguments.empty() ? 0 : 1), arguments.end());
    if (chosen.empty()) chosen = {"10000", "110000", "1000000", "calm=110000", "calm=1000000", "clumped=170000"};
    for (const std::string& cloud : chosen) {
        const std::size_t equals = cloud.find('=');
        const bool named = equals != std::string::npos;
        compare(named ? cloud.substr(0, equals) : "splash", std::stoul(named ? cloud.substr(equals + 1) : cloud),
                rounds);
    }
}
