// Trying again what network storage refuses for a moment.

#pragma once

#include "batch/platform/interrupt.h"
#include "batch/report/log.h"
#include "betamesh/error.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

namespace betamesh {

inline constexpr auto kFirstWait = std::chrono::milliseconds(200);  ///< before the second attempt; doubles each time
inline constexpr auto kLongestWait = std::chrono::milliseconds(5000);

/// Calls attempt(), and again after an Error, up to `retries` times with growing waits. Rethrows the last Error, and
/// MemoryError at once.
template <typename Attempt>
void retrying(int retries, const Attempt& attempt) {
    auto wait = kFirstWait;
    for (int failures = 0;; ++failures) {
        try {
            return attempt();
        } catch (const MemoryError&) {
            throw;
        } catch (const Error& error) {
            if (failures == retries) throw;
            logDetail(std::string(error.what()) + "; trying again");
        }
        std::this_thread::sleep_for(wait);
        wait = std::min<std::chrono::milliseconds>(2 * wait, kLongestWait);
        leaveIfInterrupted();
    }
}

}  // namespace betamesh
