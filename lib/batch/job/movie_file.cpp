
#include "batch/job/movie_file.h"

#include "betamesh/error.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <vector>

namespace betamesh {
namespace {

constexpr const char* kEncoder = "ffmpeg";

/// Replaces the child process by a program that reads from the pipe.
[[noreturn]] void executeProgram(const std::vector<std::string>& words, int input) {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    ::dup2(input, STDIN_FILENO);
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
}

}  // namespace

void Movie::requireMaker() {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');)
        if (::access((folder + '/' + kEncoder).c_str(), X_OK) == 0) return;
    throw Error("a movie needs ffmpeg, which is not on the PATH. Install the package ffmpeg, or write pictures only");
}

Movie::Movie(const std::string& path, int width, int height, double fps) : path_(path), file_(path) {
    requireMaker();
    const std::vector<std::string> words{
        kEncoder, "-y", "-loglevel", "error",
        // input
        "-f", "rawvideo", "-pix_fmt", "rgb24", "-video_size", std::to_string(width) + 'x' + std::to_string(height),
        "-framerate", std::to_string(fps), "-i", "-",
        // output that every player shows, which needs even sizes
        "-vf", "scale=out_color_matrix=bt709:out_range=tv,pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-c:v", "libx264",
        "-crf", "17", "-pix_fmt", "yuv420p", "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709",
        "-movflags", "+faststart", "-f", "mp4", file_.temporaryPath().string()};
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw Error(path + ": cannot be written: no pipe to ffmpeg");
    process_ = ::fork();
    if (process_ == 0) executeProgram(words, ends[0]);
    ::close(ends[0]);
    pipe_ = ends[1];
    if (process_ < 0) throw Error(path + ": cannot be written: ffmpeg cannot be started");
}

Movie::~Movie() { end(); }

void Movie::end() {
    if (pipe_ >= 0) ::close(pipe_);
    if (process_ > 0)
        while (::waitpid(process_, &status_, 0) < 0 && errno == EINTR) {
        }
    pipe_ = -1;
    process_ = -1;
}

void Movie::add(const Image& image) {
    const auto* at = reinterpret_cast<const char*>(image.pixel.data());
    for (std::size_t left = image.pixel.size() * sizeof(Colour); left > 0;) {
        const ssize_t count = ::write(pipe_, at, left);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) throw Error(path_ + ": cannot be written: ffmpeg has ended");
        at += count;
        left -= static_cast<std::size_t>(count);
    }
}

void Movie::finish() {
    end();
    if (!WIFEXITED(status_) || WEXITSTATUS(status_) != 0) throw Error(path_ + ": cannot be written: ffmpeg failed");
    file_.commit();
}

}  // namespace betamesh
