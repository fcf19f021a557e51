// The layer beside a sequence of .usda files that plays them.

#pragma once

#include "batch/job/frames.h"
#include "betamesh/io.h"

#include <string>
#include <vector>

namespace betamesh {

/// The path of the layer: shot.usda for shot.####.usda, mesh/shot.usda for mesh/####/shot.usda, and sequence.usda if
/// nothing else is in the name. Empty if the files are not a sequence of .usda.
std::string sequenceLayer(const FramePattern& files);

/// errors  the layer exists already, and was not written by writeSequenceLayer(). One that was changed afterwards is no
///         error: writeSequenceLayer() keeps it
void requireOwnSequenceLayer(const FramePattern& files);

/// Writes the layer for the frames that are on disk, whoever wrote them, if it changes. A layer that somebody has
/// edited stays, with a warning in the log. Does nothing for files that are not a sequence of .usda.
///
/// same    the same bytes for the same files, so that tasks of a farm, each of which does some of the frames, agree in
///         the end. Tasks that end at the same time: the last one to write has seen the files of all
/// errors  a file that cannot be written; those of requireOwnSequenceLayer()
void writeSequenceLayer(const FramePattern& files, const WriteOptions& options);

/// The files without layers that play a sequence, which the log names. A single file stays, whatever it is.
std::vector<std::string> withoutSequenceLayers(std::vector<std::string> files);

}  // namespace betamesh
