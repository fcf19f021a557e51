// Encodes pictures as a movie with ffmpeg.

#pragma once

#include "io/output_file.h"
#include "render/picture.h"

#include <string>

#include <sys/types.h>

namespace betamesh {

/// Writes an .mp4 file (H.264), which appears under its name only when finish() has succeeded.
class Movie {
public:
    /// Starts ffmpeg.
    ///
    /// in      size of the pictures in pixels; fps: pictures per second, > 0
    /// errors  no ffmpeg on the PATH; the system refuses a process
    Movie(const std::string& path, int width, int height, double fps);
    ~Movie();
    Movie(const Movie&) = delete;
    Movie& operator=(const Movie&) = delete;

    /// Appends a picture of the size given to the constructor.
    ///
    /// errors  ffmpeg has ended
    void add(const Image& image);
    /// Waits for ffmpeg and moves the file to its name.
    ///
    /// errors  ffmpeg failed
    void finish();

    /// errors  no ffmpeg on the PATH
    static void requireMaker();

private:
    void end();

    std::string path_;
    OutputFile file_;
    pid_t process_ = -1;
    int pipe_ = -1;
    int status_ = 0;
};

}  // namespace betamesh
