#include "io/usda_parser.h"

#include "betamesh/error.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace betamesh {

namespace {

constexpr std::size_t kDeepestPrim = 100, kDeepestBracket = 100;
constexpr std::size_t kMostAttributes = 1000;  // of a prim; a name is looked up among them
constexpr std::size_t kLongestName = 1000;

bool isWordCharacter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':' ||
           c == '.' || static_cast<unsigned char>(c) >= 0x80;
}

bool isOneOf(std::string_view word, std::initializer_list<std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

/// How to get a file without composition.
constexpr const char* kFlatten = "Only the file itself is read. Flatten it first: usdcat --flatten IN.usda -o OUT.usda";

class Parser {
public:
    Parser(std::string_view text, const std::string& file) : text_(text), file_(file) {}

    UsdaStage parse() {
        if (!text_.starts_with("#usda 1.")) fail("the file does not begin with #usda 1.0");
        skipSpace();
        if (take('(')) parseLayerMetadata();
        for (skipSpace(); !atEnd(); skipSpace()) {
            const std::string_view word = takeWord("def, over or class");
            if (word == "reorder")
                skipAssignment();
            else
                parsePrim(word, kNoPrim, true, 0);
        }
        return std::move(stage_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const { failAt(at_, what); }
    [[noreturn]] void failAt(std::size_t at, const std::string& what) const {
        const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at), '\n');
        throw Error(file_ + ": line " + std::to_string(line) + ": " + what);
    }
    [[noreturn]] void failComposition(const std::string& what) const { fail(what + ". " + kFlatten + "."); }

    bool atEnd() const { return at_ >= text_.size(); }
    char here() const { return atEnd() ? '\0' : text_[at_]; }

    /// Skips white space, semicolons and comments.
    void skipSpace() {
        for (; !atEnd(); ++at_) {
            const char c = text_[at_];
            if (c == '#')
                at_ = std::min(text_.find('\n', at_), text_.size() - 1);
            else if (c != ' ' && c != '\n' && c != '\t' && c != '\r' && c != ';')
                return;
        }
    }

    /// Steps over a character, if it is the next one after white space.
    bool take(char c) {
        skipSpace();
        if (here() != c || atEnd()) return false;
        ++at_;
        return true;
    }
    void expect(char c, const char* where) {
        if (!take(c)) fail(std::string("'") + c + "' is missing " + where);
    }

    std::string_view takeWord(const char* expected) {
        skipSpace();
        const std::size_t begin = at_;
        while (!atEnd() && isWordCharacter(text_[at_])) ++at_;
        if (at_ == begin) fail(std::string("there is no ") + expected);
        return text_.substr(begin, at_ - begin);
    }

    void skipString() {
        const char quote = here();
        const std::string three(3, quote);
        const std::size_t begin = at_;
        const bool is_long = text_.substr(at_, 3) == three;
        for (at_ += is_long ? 3 : 1; !atEnd(); ++at_) {
            if (text_[at_] == '\\') {
                ++at_;
            } else if (!is_long && text_[at_] == '\n') {
                break;
            } else if (is_long ? text_.substr(at_, 3) == three : text_[at_] == quote) {
                at_ += is_long ? 3 : 1;
                return;
            }
        }
        failAt(begin, "a string does not end");
    }

    void skipUntil(std::string_view mark, const char* what) {
        const std::size_t begin = at_, end = text_.find(mark, at_ + mark.size());
        if (end == std::string_view::npos) failAt(begin, std::string(what) + " does not end");
        at_ = end + mark.size();
    }

    /// Skips a string, an asset path or a path; false: there is none here.
    bool skipQuoted() {
        switch (here()) {
            case '"':
            case '\'':
                skipString();
                return true;
            case '@':
                skipUntil(text_.substr(at_, 3) == "@@@" ? "@@@" : "@", "an asset path");
                return true;
            case '<':
                at_ = std::min(text_.find('>', at_), text_.size());
                if (atEnd()) fail("a path does not end");
                ++at_;
                return true;
            default:
                return false;
        }
    }

    void skipBrackets() {
        const std::size_t begin = at_;
        std::array<char, kDeepestBracket> closing{};
        std::size_t depth = 0;
        do {
            if (atEnd()) failAt(begin, "a bracket is not closed");
            switch (const char c = text_[at_]) {
                case '(':
                case '[':
                case '{':
                    if (depth == kDeepestBracket) fail("brackets are nested more than 100 deep");
                    closing[depth++] = c == '(' ? ')' : c == '[' ? ']' : '}';
                    break;
                case ')':
                case ']':
                case '}':
                    if (closing[--depth] != c)
                        fail(std::string("'") + closing[depth] + "' is missing before '" + c + "'");
                    break;
                case '#':
                    at_ = std::min(text_.find('\n', at_), text_.size() - 1);
                    break;
                default:
                    if (skipQuoted()) continue;
            }
            ++at_;
        } while (depth > 0);
    }

    /// The text of a value.
    std::string_view takeValue() {
        skipSpace();
        const std::size_t begin = at_;
        if (here() == '(' || here() == '[' || here() == '{') {
            skipBrackets();
        } else if (!skipQuoted()) {
            while (!atEnd() && (isWordCharacter(text_[at_]) || text_[at_] == '-' || text_[at_] == '+')) ++at_;
            if (at_ == begin) fail("there is no value");
        }
        return text_.substr(begin, at_ - begin);
    }

    /// Skips `name = value`, of which the value and the name may be absent.
    void skipAssignment() {
        takeWord("name");
        if (take('=')) takeValue();
    }

    /// Calls found(key, value) for the entries of metadata, behind the opening bracket.
    template <typename Found>
    void parseMetadata(const Found& found) {
        while (!take(')')) {
            if (atEnd()) fail("')' is missing at the end of metadata");
            if (skipQuoted()) continue;  // a comment
            std::string_view key = takeWord("name or ')'");
            if (isOneOf(key, {"prepend", "append", "add", "delete", "reorder"})) key = takeWord("name");
            if (take('=')) found(key, takeValue());
        }
    }

    static bool isEmpty(std::string_view value) { return value == "None" || value == "[]"; }

    void parseLayerMetadata() {
        parseMetadata([&](std::string_view key, std::string_view value) {
            if (key == "subLayers" && !isEmpty(value)) failComposition("the file has sublayers, which are not read");
            if (key == "upAxis") stage_.up_axis = value;
            if (key == "metersPerUnit") stage_.meters_per_unit = value;
            if (key == "timeCodesPerSecond" || (key == "framesPerSecond" && stage_.frame_rate.empty()))
                stage_.frame_rate = value;
        });
    }

    /// Returns whether the prim is active.
    bool parsePrimMetadata(bool is_read) {
        bool active = true;
        parseMetadata([&](std::string_view key, std::string_view value) {
            if (key == "active" && (value == "false" || value == "0")) active = false;
            if (!is_read || isEmpty(value)) return;
            if (key == "clips")
                fail(
                    "the prim takes its values from other files by value clips. Read these files, one per frame, "
                    "instead: they are listed as assetPaths or templateAssetPath");
            if (isOneOf(key, {"references", "payload", "inherits", "specializes", "variantSets", "variants"}))
                failComposition("the prim has " + std::string(key) + ", which are not read");
        });
        return active;
    }

    void parsePrim(std::string_view specifier, std::size_t parent, bool is_read, std::size_t depth) {
        if (!isOneOf(specifier, {"def", "over", "class"}))
            fail("'" + std::string(specifier.substr(0, 40)) + "' is not def, over or class");
        if (depth > kDeepestPrim) fail("prims are nested more than 100 deep");
        is_read = is_read && specifier == "def";
        UsdaPrim prim;
        prim.parent = parent;
        skipSpace();
        if (here() != '"' && here() != '\'') prim.type = takeWord("type or name of a prim");
        skipSpace();
        if (here() != '"' && here() != '\'') fail("the prim has no name in quotes");
        const std::size_t begin = at_;
        skipString();
        prim.name = text_.substr(begin + 1, at_ - begin - 2);
        if (prim.name.size() > kLongestName) fail("the prim has a name of more than 1000 characters");
        if (take('(')) is_read = parsePrimMetadata(is_read) && is_read;
        expect('{', "after the name or the metadata of a prim");
        std::size_t index = kNoPrim;
        if (is_read) {
            index = stage_.prims.size();
            stage_.prims.push_back(std::move(prim));
        }
        while (!take('}')) {
            if (atEnd()) fail("'}' is missing at the end of a prim");
            parseStatement(index, is_read, depth);
        }
    }

    void parseStatement(std::size_t prim, bool is_read, std::size_t depth) {
        std::string_view word = takeWord("attribute, prim or '}'");
        if (isOneOf(word, {"def", "over", "class"})) return parsePrim(word, prim, is_read, depth + 1);
        if (word == "variantSet") {
            if (is_read) failComposition("the prim has variants, which are not read");
            takeValue();
            expect('=', "after the name of a variant set");
            takeValue();
            return;
        }
        bool is_list = false;
        while (isOneOf(word,
                       {"custom", "uniform", "varying", "config", "prepend", "append", "add", "delete", "reorder"})) {
            is_list |= !isOneOf(word, {"custom", "uniform", "varying", "config"});
            word = takeWord("type");
        }
        if (word == "rel" || (is_list && isOneOf(word, {"nameChildren", "properties", "rootPrims"}))) {
            if (word == "rel") takeWord("name");
            if (take('=')) takeValue();
            if (take('(')) parseMetadata([](std::string_view, std::string_view) {});
            return;
        }
        parseAttribute(word, prim);
    }

    void parseAttribute(std::string_view type, std::size_t prim) {
        if (here() == '[') {
            if (text_.substr(at_, 2) != "[]") fail("']' is missing after '['");
            at_ += 2;
            type = text_.substr(static_cast<std::size_t>(type.data() - text_.data()), type.size() + 2);
        }
        std::string_view name = takeWord("name of an attribute");
        if (name.size() > kLongestName) fail("the attribute has a name of more than 1000 characters");
        const std::size_t dot = name.find('.');
        const std::string_view field = dot == std::string_view::npos ? std::string_view() : name.substr(dot);
        name = name.substr(0, dot);
        UsdaAttribute unused;
        UsdaAttribute& attribute = prim == kNoPrim ? unused : attributeOf(prim, type, name);
        if (take('=')) {
            if (field == ".timeSamples") {
                parseSamples(attribute);
            } else {
                const std::string_view value = takeValue();
                if (field.empty()) attribute.value = value == "None" ? std::string_view() : value;
            }
        }
        if (!take('(')) return;
        parseMetadata([&](std::string_view key, std::string_view value) {
            if (key == "interpolation") attribute.interpolation = value;
            if (key == "displayName") attribute.display_name = value;
            if (key == "elementSize") attribute.element_size = value;
        });
    }

    UsdaAttribute& attributeOf(std::size_t prim, std::string_view type, std::string_view name) {
        std::vector<UsdaAttribute>& all = stage_.prims[prim].attributes;
        const auto found = std::find_if(all.begin(), all.end(), [&](const auto& a) { return a.name == name; });
        if (found != all.end()) {
            if (found->type != type) fail("the attribute '" + std::string(name) + "' is declared with two types");
            return *found;
        }
        if (all.size() == kMostAttributes) fail("the prim has more than 1000 attributes");
        all.emplace_back();
        all.back().type = type;
        all.back().name = name;
        return all.back();
    }

    void parseSamples(UsdaAttribute& attribute) {
        expect('{', "before time samples");
        while (!take('}')) {
            if (atEnd()) fail("'}' is missing after time samples");
            double time = 0;
            const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), time);
            if (error != std::errc()) fail("the time of a sample is not a number");
            at_ = static_cast<std::size_t>(end - text_.data());
            expect(':', "after the time of a sample");
            const std::string_view value = takeValue();
            attribute.samples.push_back({time, value == "None" ? std::string_view() : value});
            take(',');
        }
    }

    std::string_view text_;
    const std::string& file_;
    std::size_t at_ = 0;
    UsdaStage stage_;
};

}  // namespace

std::string_view UsdaAttribute::valueAt(double time) const {
    const Sample *latest = nullptr, *earliest = nullptr;
    for (const Sample& sample : samples) {
        if (sample.time <= time && (latest == nullptr || sample.time > latest->time)) latest = &sample;
        if (earliest == nullptr || sample.time < earliest->time) earliest = &sample;
    }
    if (latest == nullptr) latest = earliest;
    return latest == nullptr ? value : latest->value;
}

const UsdaAttribute* UsdaPrim::find(std::string_view attribute) const {
    const auto found =
        std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.name == attribute; });
    return found == attributes.end() ? nullptr : &*found;
}

std::string UsdaStage::pathOf(std::size_t prim) const {
    std::string path;
    for (; prim != kNoPrim; prim = prims[prim].parent) path = "/" + std::string(prims[prim].name) + path;
    return path;
}

UsdaStage parseUsdaStage(std::string_view text, const std::string& file) { return Parser(text, file).parse(); }

std::string unquoted(std::string_view text) {
    const std::size_t quotes = text.size() >= 6 && text[1] == text[0] && text[2] == text[0] ? 3 : 1;
    if (text.size() < 2 * quotes) return {};
    std::string plain;
    text = text.substr(quotes, text.size() - 2 * quotes);
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\\' && i + 1 < text.size()) ++i;
        plain += text[i];
    }
    return plain;
}

}  // namespace betamesh
