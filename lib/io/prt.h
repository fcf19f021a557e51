// Thinkbox PRT particles, in.

#pragma once

#include "io/file_contents.h"

namespace betamesh {

/// PRT files, and PRT2, which stores the same in chunks: every channel of numbers, of any type and arity. `Position` is
/// the position, `Velocity` the attribute `velocity`, `ID` the id where `id` is asked for. Metadata are passed over.
///
/// errors  damaged headers and chunks, by byte; fewer particles than declared; filters of PRT2 other than
///         transpose-zlib
/// source  "PRT file format", Thinkbox's documentation of Krakatoa; files of Thinkbox's library for PRT2
FileContents parsePrt(Cursor in, const ReadOptions& options = {});

}  // namespace betamesh
