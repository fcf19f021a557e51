// SIGTERM and SIGINT: farms and people ask a job to end.

#pragma once

namespace betamesh {

/// From here on the first SIGTERM or SIGINT is only remembered; the second one ends the process at once.
void rememberSignals();

/// SIGTERM, SIGINT, or 0 when none has come.
int caughtSignal();

}  // namespace betamesh
