// Pictures one after the other, as a movie that ffmpeg makes.

#pragma once

#include "io/output_file.h"
#include "render/picture.h"

#include <string>

#include <sys/types.h>

namespace betamesh {

/// An .mp4 (H.264) that appears under its name once it is finished, and not at all otherwise.
class Movie {
public:
    /// fps: pictures per second, > 0.
    ///
    /// errors  there is no ffmpeg on the PATH
    Movie(const std::string& path, int width, int height, double fps);
    ~Movie();
    Movie(const Movie&) = delete;
    Movie& operator=(const Movie&) = delete;

    /// in      pictures of the size that was told
    /// errors  ffmpeg has ended
    void add(const Image& image);
    void finish();

    /// errors  there is no ffmpeg on the PATH
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
