// Houdini's JSON: values read one after the other from its binary or its text encoding.

#pragma once

#include "io/bytes.h"

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// Do the next bytes begin a document, binary (of either byte order) or text?
bool isHoudiniJson(Cursor& in);

/// Reads one document from front to back. Nothing is kept but what the caller keeps, so memory grows with the bytes
/// that are there and never with a count in the file. The binary encoding stores arrays of one type without a token
/// for each element ("uniform arrays"); they are read like any other array.
///
/// errors  a damaged document, with the byte and what was expected there; containers nested more than kMaxDepth deep
class HoudiniJsonReader {
public:
    enum class Kind { null, boolean, integer, real, text, array, map };
    static constexpr std::size_t kMaxDepth = 200;

    explicit HoudiniJsonReader(Cursor in);

    bool isBinary() const { return binary_; }

    /// Kind of the next value.
    Kind kind();

    // Each reads the next value. what: named in the error if the value is of another kind.
    bool boolean(const char* what);  ///< also from the integers 0 and 1
    std::int64_t integer(const char* what);
    std::string text(const char* what);
    void skip();  ///< of any kind, containers with all they contain

    /// The next value is an array. element() must read or skip one value.
    void forElements(const char* what, const std::function<void()>& element);

    /// The next value is a map, or an array that lists keys and values in turn, as Houdini writes most of its maps.
    /// value(key) must read or skip one value.
    void forKeys(const char* what, const std::function<void(const std::string& key)>& value);

    /// The next value is an array of numbers: visit() takes them a few thousand at a time. T: float, std::int32_t or
    /// std::int64_t. Numbers are rounded to float; an integer that T cannot represent is an error.
    template <typename T>
    void forNumbers(const char* what, const std::function<void(std::span<const T>)>& visit);

    /// Reads the bytes after the document, so that the checks at the end of a compressed file are made.
    void readToEnd();

    [[noreturn]] void fail(const std::string& text) const { in_.fail(text); }
    const std::string& file() const { return in_.file(); }

private:
    enum class Token { null, boolean, integer, real, text, array_begin, map_begin, array_end, map_end };
    struct Level {
        bool is_map = false;
        bool uniform = false;         // elements of one type without tokens
        std::uint8_t type = 0;        // of a uniform array
        std::uint64_t left = 0;       // elements of a uniform array that were not read yet
        std::uint32_t bool_bits = 0;  // the word that the next elements of a uniform array of booleans are in
        int bool_bits_left = 0;
    };

    Token peekToken();
    void dropToken() { has_token_ = false; }
    [[noreturn]] void failKind(const char* what, const char* expected);
    void enter(bool is_map);
    void leave(bool is_map);

    Token scanBinary();
    Token scanElement(Level& level);
    Token scanNumber(std::uint8_t type);
    template <typename T>
    T number(const char* what);
    std::uint64_t length(const char* what);
    std::string characters(std::uint64_t count);

    Token scanText();
    Token scanWord();
    std::string quotedText();
    void appendEscaped(std::string& text);
    std::uint32_t hexDigits();

    template <typename T, typename Stored>
    void forUniform(Level& level, const char* what, const std::function<void(std::span<const T>)>& visit);
    template <typename T, typename Number>
    T converted(Number number, const char* what) const;

    Cursor in_;
    bool binary_ = false;
    bool swapped_ = false;                          // the numbers have the byte order that this machine does not use
    std::map<std::uint64_t, std::string> strings_;  // that the binary encoding refers to by number
    std::vector<Level> levels_;
    Level next_level_;  // of the array whose begin was scanned

    bool has_token_ = false;  // the next token was scanned
    Token token_ = Token::null;
    std::int64_t integer_ = 0;  // value of an integer or a boolean
    double real_ = 0;
    std::string_view text_;  // of text, until the next token is scanned
    std::string own_text_;   // what text_ refers to, where that is no string defined before
};

}  // namespace betamesh
