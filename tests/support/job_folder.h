// Fixtures of batch tests: a folder with frames, running the program on it, and reading its output.

#pragma once

#include "io/particle_file.h"
#include "sample/sample.h"
#include "support/program.h"
#include "support/sanitized.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <functional>
#include <map>
#include <thread>

namespace betamesh {

namespace fs = std::filesystem;
using Json = nlohmann::json;

inline std::string numbered(const std::string& stem, int frame, const std::string& extension) {
    std::string digits = std::to_string(frame);
    digits.insert(0, 4 - digits.size(), '0');
    return stem + '.' + digits + extension;
}

/// Frames in in/, meshes in out/.
class JobFolder : public ::testing::Test {
protected:
    void writeFrame(int frame, const Particles& particles) {
        fs::create_directories(folder_ / "in");
        writeParticles(folder_ / numbered("in/a", frame, ".ply"), particles);
    }

    void writeFrames(int first, int last, std::size_t particles = 400) {
        Sample sample({"jitter", particles, 1, 24});
        for (int frame = first; frame <= last; ++frame) writeFrame(frame, sample.frame(frame));
    }

    /// Writes a frame of 20 particles whose particle 17 has a position that is not finite.
    void writeFrameWithNaN(int frame) {
        std::string text =
            "ply\nformat ascii 1.0\nelement vertex 20\n"
            "property float x\nproperty float y\nproperty float z\nend_header\n";
        for (int i = 0; i < 20; ++i) text += std::to_string(i) + (i == 17 ? " nan 0\n" : " 0 0\n");
        write(folder_ / numbered("in/a", frame, ".ply"), text);
    }

    /// Runs `mesh` from in/ to out/ with further arguments.
    Outcome mesh(const std::vector<std::string>& further = {}, const std::string& output = "out/a.####.ply") {
        std::vector<std::string> words{"mesh", "in/a.####.ply", output};
        words.insert(words.end(), further.begin(), further.end());
        return runProgram(words, folder_.path());
    }

    bool exists(const std::string& name) { return fs::exists(folder_ / name); }
    bool written(int frame) {
        return exists(numbered("out/a", frame, ".ply")) && exists(numbered("out/a", frame, ".ply.json"));
    }
    bool absent(int frame) {
        return !exists(numbered("out/a", frame, ".ply")) && !exists(numbered("out/a", frame, ".ply.json"));
    }

    Json manifest(int frame) { return Json::parse(contentsOf(folder_ / numbered("out/a", frame, ".ply.json"))); }

    /// Names and contents of all files in a folder except manifests, which contain times.
    std::map<std::string, std::string> meshesIn(const std::string& name) {
        std::map<std::string, std::string> files;
        for (const auto& entry : fs::directory_iterator(folder_ / name)) {
            if (entry.path().extension() != ".json") files[entry.path().filename().string()] = contentsOf(entry.path());
        }
        return files;
    }

    std::size_t hiddenFiles(const std::string& name) {
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(folder_ / name)) {
            if (entry.path().filename().string().front() == '.') ++count;
        }
        return count;
    }

    TemporaryFolder folder_;
};

inline std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
}

inline constexpr int kSecondsToStart = 300;  // generous, for a busy machine

/// Waits until the condition is true, or for that many seconds. Returns whether it became true.
inline bool within(int seconds, const std::function<bool()>& isTrue) {
    const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    while (!isTrue()) {
        if (std::chrono::steady_clock::now() > latest) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
}

}  // namespace betamesh
