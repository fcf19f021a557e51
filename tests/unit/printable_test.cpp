// Text from files made safe for terminals, and paths of any bytes kept in JSON.

#include "batch/report/printable.h"

#include "base/nearest_word.h"
#include "base/random.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace betamesh {
namespace {

/// Strings of bytes and characters that matter: controls, UTF-8 whole and broken, the escape character itself.
std::string randomBytes(std::uint64_t seed) {
    const std::vector<std::string> pieces{"a",    "\x1b[31m", "\n",           "\t",           "\x7f", "\xff",
                                          "\xc3", "\xc3\xa4", "\xc2\x9b",     "\xe2\x80\xae", "%",    "%41",
                                          "\\",   "\"",       "\xf0\x9f\x98", "\xed\xa0\x80", " ",    "\xc0\xaf"};
    Random random(seed);
    std::string bytes;
    for (std::size_t i = random.below(12); i > 0; --i)
        bytes += random.below(4) == 0 ? std::string(1, static_cast<char>(random.below(256)))
                                      : pieces[random.below(pieces.size())];
    return bytes;
}

TEST(Printable, LeavesTextAndEscapesWhatATerminalActsOn) {
    EXPECT_EQ(printable("Wasser \xc3\xa4 \xe6\xb0\xb4 \\ \"%\""), "Wasser \xc3\xa4 \xe6\xb0\xb4 \\ \"%\"");
    EXPECT_EQ(printable("a\x1b[31mb\nc\td\re\x7f"), "a\\x1b[31mb\\nc\\td\\re\\x7f");
    EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
    EXPECT_EQ(printable("\xff\xc3"), "\\xff\\xc3");                             // not UTF-8
    EXPECT_EQ(printable("\xc0\xaf\xed\xa0\x80"), "\\xc0\\xaf\\xed\\xa0\\x80");  // overlong; a surrogate
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m\xe2\x80\xae"),
              "\\u009b31m\\u202e");  // 8-bit CSI; right-to-left override
}

TEST(Printable, HasNoControlCharactersForAnyBytesAndIsUtf8) {
    for (std::uint64_t seed = 0; seed < 5000; ++seed) {
        const std::string text = printable(randomBytes(seed));
        EXPECT_TRUE(isUtf8(text)) << seed;
        for (const char c : text) EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) << seed;
        EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos) << seed;
        EXPECT_EQ(printable(text), text) << seed;
    }
}

TEST(Printable, PercentEncodingKeepsAnyBytes) {
    for (std::uint64_t seed = 0; seed < 5000; ++seed) {
        const std::string bytes = randomBytes(seed);
        EXPECT_TRUE(isUtf8(percentEncoded(bytes))) << seed;
        EXPECT_EQ(percentDecoded(percentEncoded(bytes)), bytes) << seed;
    }
    EXPECT_EQ(percentDecoded("%4 %zz %"), "%4 %zz %");
}

TEST(Printable, JsonKeepsItsValues) {
    for (std::uint64_t seed = 0; seed < 5000; ++seed) {
        const nlohmann::json json{{"name", randomBytes(seed)}};
        const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
        EXPECT_EQ(nlohmann::json::parse(printableJson(text)), nlohmann::json::parse(text)) << seed;
        EXPECT_EQ(printable(printableJson(text)), printableJson(text)) << seed;
    }
}

TEST(NearestWord, IsTheOneThatWasMeantOrNone) {
    const std::vector<std::string> words{"mesh", "run", "render", "report", "--radius", "--radius-scale"};
    EXPECT_EQ(nearestWord("mehs", words), "mesh");
    EXPECT_EQ(nearestWord("rendr", words), "render");
    EXPECT_EQ(nearestWord("rep", words), "report");
    EXPECT_EQ(nearestWord("--radus", words), "--radius");
    EXPECT_EQ(nearestWord("--radius-s", words), "--radius-scale");
    EXPECT_EQ(nearestWord("-x", words), "");
    EXPECT_EQ(nearestWord("simulate", words), "");
    EXPECT_EQ(didYouMean("mehs", words), " Did you mean 'mesh'?");
    EXPECT_EQ(didYouMean("simulate", words), "");
}

}  // namespace
}  // namespace betamesh
