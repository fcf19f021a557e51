// Expressions over the attributes of particles: `type == 1 && P.y > 0.5`.

#pragma once

#include "io/file_contents.h"

#include <memory>
#include <string>

namespace betamesh {

/// A condition that holds or fails for each particle.
///
/// Names are attributes, `id`, and `P` for the position. Components of vectors are P.x, P.y, P.z (also .r .g .b .a and
/// [0], [1] …), and length(v) is the length of a vector. Operators and their precedence are those of C: + - * / ^
/// (power), < <= > >= == != && || ! and a ? b : c; functions are those of muParser (abs, min, max, sqrt, sin, …). All
/// numbers are double precision. A comparison with NaN fails.
class AttributeExpression {
public:
    /// errors  text that is no expression: the column, what was found there
    explicit AttributeExpression(const std::string& text);
    ~AttributeExpression();
    AttributeExpression(AttributeExpression&&) noexcept;
    AttributeExpression& operator=(AttributeExpression&&) noexcept;

    const std::string& text() const { return text_; }

    /// The rows, ascending, for which the expression is true: not zero, and not NaN.
    ///
    /// in      points with all their attributes; origin: was subtracted from their positions in the file
    /// errors  a name that is none of the attributes, with the nearest one and all there are; a vector without
    /// component,
    ///         a component that it does not have. Not for several threads at once
    /// cost    about 50 ns a particle
    std::vector<std::uint32_t> rowsWhereTrue(const FileContents& points, const std::string& file,
                                             const Vec3& origin = {0, 0, 0});

    /// Whether the expression names an attribute, or one of its components.
    bool uses(const std::string& attribute) const;

private:
    struct Compiled;
    std::string text_;
    std::unique_ptr<Compiled> compiled_;
};

}  // namespace betamesh
