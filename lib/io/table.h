// Tables of numbers in text: .csv with named columns, in and out; .xyz without names, in.

#pragma once

#include "io/file_contents.h"

namespace betamesh {

/// Rows of numbers, separated by white space, commas or semicolons; lines that begin with # are passed over. A first
/// line of words names the columns: x y z (or P.x P.y P.z, P:0 …, Points:0 …, Position X …, in any case) are the
/// position, columns a.x a.y a.z, a_x …, a:0 a:1 …, a[0] … of one name a vector, vx vy vz the velocity `v`, others
/// attributes of one number. The numbers of options.id, `id` and groups are whole, and so are those of columns whose
/// names are in quotes while other names are not, as in x,y,z,"count"; all others are floats, whatever they are in this
/// file, so that all frames of a sequence have the same types. Without names the first three columns are the position,
/// the next ones attributes column4, column5 …. An .xyz file of chemistry, with a count, a comment and lines that begin
/// with an element's name, is read likewise, without the names.
///
/// errors  by line: a row with too few columns, what is no number; no columns x, y and z, with the names there are; an
///         id that is not whole
FileContents parseTable(Cursor in, const ReadOptions& options = {});

/// A .csv with the columns x y z, vx vy vz, id, and those of the attributes: a, or a.x a.y … up to four components,
/// a[0] a[1] … beyond. The names of integers are in quotes. Numbers have as many digits as needed to read the same
/// floats.
///
/// errors  an attribute whose name is that of another column
void encodeTable(ByteWriter& out, const Particles& particles, const std::string& file);

}  // namespace betamesh
