#include "io/attribute_expression.h"

#include "base/nearest_word.h"
#include "betamesh/error.h"

#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <regex>
#include <utility>
#include <vector>

namespace betamesh {

namespace {

/// One number of one attribute, as an expression names it.
struct Variable {
    std::string name;       ///< as it was written, such as "P.x"
    std::string attribute;  ///< "P"
    std::string component;  ///< "x", "length"; empty: the attribute has one number
    double value = 0;
};

/// The index of a component by its letter or number; -1 where it is none.
int componentIndex(const std::string& component) {
    for (const std::string letters : {"xyzw", "rgba", "0123456789"})
        if (component.size() == 1 && letters.find(component) != std::string::npos)
            return static_cast<int>(letters.find(component));
    return -1;
}

Variable variableOf(const std::string& name) {
    const std::size_t dot = name.rfind('.'), bracket = name.find('[');
    if (bracket != std::string::npos && name.back() == ']')
        return {name, name.substr(0, bracket), name.substr(bracket + 1, name.size() - bracket - 2)};
    if (dot != std::string::npos) return {name, name.substr(0, dot), name.substr(dot + 1)};
    return {name, name, ""};
}

/// Where the numbers of a variable are in some points: one pointer is set, or none where all points have the value 0.
struct Column {
    const float* real = nullptr;
    const std::int32_t* integer = nullptr;
    const std::uint64_t* id = nullptr;
    std::size_t stride = 1;
    bool length = false;    ///< of the vector that begins there
    Vec3 offset{0, 0, 0};   ///< is added to the components of the vector
    std::size_t first = 0;  ///< component

    double operator[](std::size_t row) const {
        if (id) return static_cast<double>(id[row]);
        if (!length) return number(row, first);
        double sum = 0;
        for (std::size_t k = 0; k < stride; ++k) sum += number(row, k) * number(row, k);
        return std::sqrt(sum);
    }

private:
    double number(std::size_t row, std::size_t k) const {
        const std::size_t i = row * stride + k;
        const double stored = real ? static_cast<double>(real[i]) : static_cast<double>(integer[i]);
        return k < 3 ? stored + offset[static_cast<int>(k)] : stored;
    }
};

/// Sets where the column begins for the variable's component of an attribute with so many of them.
void chooseComponent(const Variable& variable, std::size_t components, const std::string& where, Column& column) {
    column.stride = components;
    column.length = variable.component == "length";
    if (column.length) return;
    if (variable.component.empty()) {
        if (components == 1) return;
        throw Error(where + "'" + variable.name + "' has " + std::to_string(components) + " components. Write " +
                    variable.name + ".x, " + variable.name + "[0] or length(" + variable.name + ")");
    }
    const int index = componentIndex(variable.component);
    if (index < 0 || static_cast<std::size_t>(index) >= components)
        throw Error(where + "'" + variable.attribute + "' has no component '" + variable.component + "': it has " +
                    std::to_string(components));
    column.first = static_cast<std::size_t>(index);
}

Column columnOf(const Variable& variable, const FileContents& points, const Vec3& origin, const std::string& where) {
    Column column;
    if (variable.attribute == "P") {
        column.offset = origin;
        column.real = points.position.empty() ? nullptr : &points.position[0].x;
        chooseComponent(variable, 3, where, column);
        return column;
    }
    const auto found = std::find_if(points.attributes.begin(), points.attributes.end(),
                                    [&](const Attribute& a) { return a.name == variable.attribute; });
    if (found != points.attributes.end()) {
        column.real = found->real.empty() ? nullptr : found->real.data();
        column.integer = found->integer.empty() ? nullptr : found->integer.data();
        chooseComponent(variable, found->components, where, column);
        return column;
    }
    if (variable.attribute == "id" && variable.component.empty() && points.id.size() == points.position.size()) {
        column.id = points.id.data();
        return column;
    }
    std::vector<std::string> known{"P"};
    if (!points.id.empty()) known.emplace_back("id");
    for (const Attribute& a : points.attributes) known.push_back(a.name);
    std::string all;
    for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
    throw Error(where + "there is no attribute '" + variable.attribute + "'. The file has " + all + '.' +
                didYouMean(variable.attribute, known));
}

/// Whether a comparison is compared with something, as in 2 < P.x < 6, which does not mean what it seems to.
bool hasChainedComparison(const std::string& text) {
    static const std::regex sign(R"(&&|\|\||[<>=!]=|[<>(),?:])");
    std::vector<char> compared{0};  // since the last &&, || or bracket, in each pair of parentheses
    for (std::sregex_iterator at(text.begin(), text.end(), sign), end; at != end; ++at) {
        const std::string found = at->str();
        if (found == "(") {
            compared.push_back(0);
        } else if (found == ")") {
            if (compared.size() > 1) compared.pop_back();
        } else if (found == "&&" || found == "||" || found == "," || found == "?" || found == ":") {
            compared.back() = 0;
        } else if (std::exchange(compared.back(), 1) != 0) {
            return true;
        }
    }
    return false;
}

}  // namespace

struct AttributeExpression::Compiled {
    std::deque<Variable> variables;  // the parser holds pointers to their values
    mu::Parser parser;
};

AttributeExpression::AttributeExpression(const std::string& text)
    : text_(text), compiled_(std::make_unique<Compiled>()) {
    mu::Parser& parser = compiled_->parser;
    parser.DefineNameChars("0123456789_.[]abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ:");
    parser.DefineInfixOprt("!", [](double x) { return x == 0 ? 1.0 : 0.0; });
    parser.SetVarFactory(
        [](const char* name, void* compiled) {
            auto& variables = static_cast<Compiled*>(compiled)->variables;
            return &variables.emplace_back(variableOf(name)).value;
        },
        compiled_.get());
    static const std::regex assignment(R"((^|[^=!<>])=([^=]|$))");
    if (std::regex_search(text, assignment))
        throw Error("'" + text + "' is not a condition: a single '=' assigns. Use '==' to compare");
    if (hasChainedComparison(text))
        throw Error("'" + text +
                    "' is not a condition: it compares a comparison. Write 2 < P.x && P.x < 6 for a range");
    static const std::regex length(R"(\blength\(\s*([A-Za-z_][\w:]*)\s*\))");
    try {
        parser.SetExpr(std::regex_replace(text, length, "$1.length"));
        int results = 0;
        parser.Eval(results);  // compiles it, and finds the names in it
        if (results != 1) throw Error("'" + text + "' is not a condition: it has several results, separated by commas");
    } catch (const mu::ParserError& error) {
        std::string why = error.GetMsg();
        if (why.ends_with('.')) why.pop_back();
        throw Error("'" + text + "' is not a condition: " + why + ". Use something like type == 1 && P.y > 0.5");
    }
}

AttributeExpression::~AttributeExpression() = default;
AttributeExpression::AttributeExpression(AttributeExpression&&) noexcept = default;
AttributeExpression& AttributeExpression::operator=(AttributeExpression&&) noexcept = default;

bool AttributeExpression::uses(const std::string& attribute) const {
    const auto part = componentName(attribute);
    return std::any_of(compiled_->variables.begin(), compiled_->variables.end(), [&](const Variable& variable) {
        return variable.attribute == attribute || (part && variable.attribute == part->vector);
    });
}

std::vector<std::uint32_t> AttributeExpression::rowsWhereTrue(const FileContents& points, const std::string& file,
                                                              const Vec3& origin) {
    if (points.position.empty()) return {};  // which attributes an empty file declares means nothing
    std::vector<Column> column;
    for (const Variable& variable : compiled_->variables)
        column.push_back(columnOf(variable, points, origin, file + ": '" + text_ + "': "));
    std::vector<std::uint32_t> rows;
    for (std::size_t row = 0; row < points.position.size(); ++row) {
        for (std::size_t k = 0; k < column.size(); ++k) compiled_->variables[k].value = column[k][row];
        const double value = compiled_->parser.Eval();
        if (value != 0 && !std::isnan(value)) rows.push_back(static_cast<std::uint32_t>(row));
    }
    return rows;
}

}  // namespace betamesh
