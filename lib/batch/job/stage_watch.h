// Measures how long the stages of a frame take.

#pragma once

#include "batch/platform/interrupt.h"
#include "batch/report/report.h"

#include <chrono>

namespace betamesh {

/// Seconds since construction or the last call of lap().
class Stopwatch {
public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const std::chrono::duration<double> seconds = now - begin_;
        begin_ = now;
        return seconds.count();
    }

private:
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Adds up the seconds of each stage. Throws Interrupted between stages once a signal has come.
class StageWatch {
public:
    explicit StageWatch(StageSeconds& seconds) : seconds_(seconds) {}
    void operator()(Stage stage) {
        seconds_[stage] += stopwatch_.lap();
        if (stage != Stage::write) leaveIfInterrupted();
    }

private:
    StageSeconds& seconds_;
    Stopwatch stopwatch_;
};

}  // namespace betamesh
