#include "batch/job/empty_frames.h"

#include "base/attribute_names.h"
#include "batch/job/input_frames.h"
#include "betamesh/error.h"
#include "io/particle_file.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace betamesh {
namespace {

bool isAcceleration(const Attribute& a) { return isAccelerationName(a.name) && a.components == 3 && !a.hasIntegers(); }

const Attribute* find(const std::vector<Attribute>& attributes, std::string_view name) {
    const auto found =
        std::find_if(attributes.begin(), attributes.end(), [&](const Attribute& a) { return a.name == name; });
    return found == attributes.end() ? nullptr : &*found;
}

}  // namespace

std::vector<Attribute> attributesOfEmptyFrames(const Config& config) {
    for (const auto& [frame, file] : inputFrames(config.input).files) {
        try {
            const auto found = attributesWithoutRows(file, inputOf(config, frame));
            if (!found) continue;
            std::vector<Attribute> columns;
            for (const std::string& name : config.output.attributes)
                if (const Attribute* a = find(*found, name)) columns.push_back(*a);
            for (const Attribute& a : *found)
                if (isAcceleration(a) && find(columns, a.name) == nullptr) columns.push_back(a);
            return columns;
        } catch (const Error&) {  // reported when this frame is meshed
        }
    }
    return {};
}

void putFirst(const std::vector<Attribute>& columns, std::vector<Attribute>& attributes) {
    std::vector<Attribute> all = columns;
    for (Attribute& a : attributes)
        if (find(columns, a.name) == nullptr) all.push_back(std::move(a));
    attributes = std::move(all);
}

}  // namespace betamesh
