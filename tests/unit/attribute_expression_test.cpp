// Conditions over attributes: they choose the rows that the same condition in C++ chooses.

#include "io/attribute_expression.h"

#include "base/random.h"
#include "betamesh/error.h"
#include "support/file_checks.h"

#include <cmath>
#include <functional>
#include <limits>

namespace betamesh {
namespace {

constexpr std::size_t kPoints = 1000;

FileContents somePoints() {
    FileContents points;
    Attribute type{"type", 1, {}, {}}, density{"density", 1, {}, {}}, v{"v", 3, {}, {}}, cd{"Cd", 4, {}, {}};
    Random random(7);
    const auto number = [&] { return static_cast<float>(random.between(-2, 2)); };
    for (std::size_t i = 0; i < kPoints; ++i) {
        points.position.emplace_back(number(), number(), number());
        points.id.push_back(i * 3 + (std::uint64_t{1} << 40));
        type.integer.push_back(static_cast<std::int32_t>(i % 4) - 1);
        density.real.push_back(i % 17 == 0 ? std::numeric_limits<float>::quiet_NaN() : number());
        for (int k = 0; k < 3; ++k) v.real.push_back(number());
        for (int k = 0; k < 4; ++k) cd.real.push_back(number());
    }
    points.attributes = {type, density, v, cd};
    return points;
}

TEST(AttributeExpression, ChoosesTheRowsThatTheSameConditionInCppChooses) {
    const FileContents points = somePoints();
    const auto& type = points.attributes[0].integer;
    const auto& density = points.attributes[1].real;
    const auto& v = points.attributes[2].real;
    const auto& cd = points.attributes[3].real;
    const auto& p = points.position;
    const auto speed = [&](std::size_t i) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) sum += double{v[3 * i + k]} * double{v[3 * i + k]};
        return std::sqrt(sum);
    };
    const std::vector<std::pair<std::string, std::function<bool(std::size_t)>>> conditions{
        {"1", [&](std::size_t) { return true; }},
        {"type", [&](std::size_t i) { return type[i] != 0; }},
        {"type==1", [&](std::size_t i) { return type[i] == 1; }},
        {"!type", [&](std::size_t i) { return type[i] == 0; }},
        {"!(type == 1 || type == 2)", [&](std::size_t i) { return type[i] != 1 && type[i] != 2; }},
        {"type == 1 && density > 0", [&](std::size_t i) { return type[i] == 1 && density[i] > 0; }},
        {"type == 1 || density > 0 && P.y < 0.5",
         [&](std::size_t i) { return type[i] == 1 || (density[i] > 0 && p[i].y < 0.5f); }},
        {"density", [&](std::size_t i) { return !std::isnan(density[i]); }},
        {"P.x < P.y", [&](std::size_t i) { return p[i].x < p[i].y; }},
        {"P[0]+P[1]*2 <= -P[2]", [&](std::size_t i) { return double{p[i].x} + double{p[i].y} * 2 <= -double{p[i].z}; }},
        {"length( v ) > 2", [&](std::size_t i) { return speed(i) > 2; }},
        {"abs(v.z) >= 1", [&](std::size_t i) { return std::abs(v[3 * i + 2]) >= 1; }},
        {"Cd.a > Cd.r", [&](std::size_t i) { return cd[4 * i + 3] > cd[4 * i]; }},
        {"id < 1099511628776", [&](std::size_t i) { return points.id[i] < 1099511628776; }},
        {"(P.x < 0) == (P.y < 0)", [&](std::size_t i) { return (p[i].x < 0) == (p[i].y < 0); }},
        {"type > 0 ? P.x < 0 : P.y < 0", [&](std::size_t i) { return type[i] > 0 ? p[i].x < 0 : p[i].y < 0; }},
        {"(type == 1 ? P.x : P.y) > 0", [&](std::size_t i) { return (type[i] == 1 ? p[i].x : p[i].y) > 0; }},
    };
    for (const auto& [text, is] : conditions) {
        SCOPED_TRACE(text);
        std::vector<std::uint32_t> expected;
        for (std::uint32_t i = 0; i < kPoints; ++i)
            if (is(i)) expected.push_back(i);
        AttributeExpression expression(text);
        EXPECT_EQ(expression.rowsWhereTrue(points, "a.ply"), expected);
        EXPECT_EQ(expression.rowsWhereTrue(points, "a.ply"), expected);  // nothing is remembered
        EXPECT_TRUE(expression.rowsWhereTrue({}, "empty.ply").empty());
    }
}

TEST(AttributeExpression, SaysWhatIsWrong) {
    const FileContents points = somePoints();
    const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
        expectError([&] { AttributeExpression(text).rowsWhereTrue(points, "a.ply"); }, words);
    };
    refused("typ == 1", {"a.ply", "'typ'", "Did you mean 'type'?", "density"});
    refused("v > 1", {"a.ply", "'v' has 3 components", "v.x", "length(v)"});
    refused("v.w > 1", {"no component 'w'", "it has 3"});
    refused("v[3] > 1", {"no component '3'"});
    refused("type.y", {"no component 'y'", "it has 1"});
    refused("", {"is not a condition"});
    refused("type ==", {"type ==", "is not a condition"});
    refused("(type", {"is not a condition"});
    refused("type = 1", {"is not a condition"});
    for (const char* chain : {"0 < type < 2", "P.x > 0 && (1 <= type <= 2)", "type == 1 == density", "0<type!=2"})
        refused(chain, {chain, "compares a comparison", "2 < P.x && P.x < 6"});
    refused("type, 1", {"is not a condition"});
    refused("type; 1", {"is not a condition"});
    refused("nosuch(type)", {"is not a condition"});
}

}  // namespace
}  // namespace betamesh
