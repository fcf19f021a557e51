// Signals: farms and people ask a job to end; those who read what it says go away.

#pragma once

namespace betamesh {

/// From here on the first SIGTERM or SIGINT is only remembered; the second one ends the process at once.
/// A pipe whose reader is gone no longer ends the process: frames matter more than who watches them.
void rememberSignals();

/// SIGTERM, SIGINT, or 0 when none has come.
int caughtSignal();

}  // namespace betamesh
