// The prims and attributes in the text of a .usda file, whose values are found but not parsed yet.

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// All views are parts of the text.
struct UsdaAttribute {
    std::string_view type;           ///< "point3f[]"
    std::string_view name;           ///< with its namespaces: "primvars:Cd"
    std::string_view interpolation;  ///< in quotes; empty: not given
    std::string_view display_name;   ///< in quotes; empty: not given
    std::string_view element_size;   ///< empty: not given
    std::string_view value;          ///< default value; empty: none
    struct Sample {
        double time = 0;  ///< in time codes, which are frames
        std::string_view value;
    };
    std::vector<Sample> samples;

    /// The value at a time: that of the latest sample until then, or else of the earliest one; without samples the
    /// default value. Empty: none.
    std::string_view valueAt(double time) const;
};

inline constexpr std::size_t kNoPrim = static_cast<std::size_t>(-1);

struct UsdaPrim {
    std::string_view type, name;
    std::size_t parent = kNoPrim;  ///< index of the prim around it
    std::vector<UsdaAttribute> attributes;

    const UsdaAttribute* find(std::string_view attribute) const;
};

/// The prims that are defined and active, parents before children. Prims that are over, class or inactive are left out
/// with everything in them. Relationships are left out.
struct UsdaStage {
    std::vector<UsdaPrim> prims;
    std::string_view up_axis;          ///< in quotes; empty: not given
    std::string_view meters_per_unit;  ///< empty: not given
    std::string_view frame_rate;       ///< timeCodesPerSecond, or else framesPerSecond; empty: not given

    std::string pathOf(std::size_t prim) const;
};

/// in      text: of the whole file; has to outlive the result
/// cost    a pass over the text
/// errors  by line: what is not the syntax of a .usda; prims nested more than 100 deep; more than 1000 attributes of a
///         prim; composition, which would need other files or other prims
UsdaStage parseUsdaStage(std::string_view text, const std::string& file);

/// The text between the quotes, with its escapes resolved.
std::string unquoted(std::string_view text);

}  // namespace betamesh
