// Thinkbox PRT particles, in.

#pragma once

#include "io/file_contents.h"

namespace betamesh {

/// PRT files of versions 1 and 2 that begin with ".PRT": every channel of numbers, of any type and arity. `Position` is
/// the position, `ID` the id where `id` is asked for. Metadata are passed over.
///
/// errors  PRT2, the chunked successor, which is named; damaged headers, by byte; fewer particles than declared
/// source  "PRT file format", Thinkbox's documentation of Krakatoa
FileContents parsePrt(Cursor in, const ReadOptions& options = {});

}  // namespace betamesh
