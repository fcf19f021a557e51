// Text from files and paths made safe for terminals and logs.

#pragma once

#include <string>
#include <string_view>

namespace betamesh {

/// The text with everything escaped that a terminal may act on: control characters, line breaks included, as \n, \t or
/// \x1b; control and direction characters of Unicode as \u009b; bytes that are not UTF-8 as \xff. A terminal would
/// otherwise carry out the escape sequences that a file or its name may contain, and a line break could forge a line.
std::string printable(std::string_view text);

/// JSON with the characters that printable() escapes, but JSON does not require to, written as \u009b. The values stay
/// the same. in: valid JSON in UTF-8 on one line.
std::string printableJson(std::string_view json);

/// From now on printable() and withoutHiddenFolder() leave out the path of a folder, with its '/' at the end, wherever
/// it occurs, so that logs, reports and manifests name temporary files without it. Has to be called before the process
/// has a second thread.
void hideFolder(const std::string& folder);

/// The text without the folder that is hidden, if one is.
std::string withoutHiddenFolder(std::string_view text);

/// Whether the text is valid UTF-8.
bool isUtf8(std::string_view text);

/// Any bytes as UTF-8: '%' and bytes that are not part of a UTF-8 character become %25 and the like.
std::string percentEncoded(std::string_view bytes);

/// The bytes that percentEncoded() has encoded.
std::string percentDecoded(std::string_view text);

}  // namespace betamesh
