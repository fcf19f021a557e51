// Reads and prints pipeline files. The only file that uses yaml-cpp.

#include "batch/config/config.h"

#include "batch/config/presets.h"
#include "batch/job/frames.h"
#include "betamesh/error.h"
#include "io/bytes.h"
#include "io/extension.h"
#include "io/format_table.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <utility>

namespace betamesh {
namespace {

namespace fs = std::filesystem;

constexpr int kVersion = 1;  // of the pipeline file format
constexpr std::size_t kMaxIncludeDepth = 32;
constexpr std::size_t kCommentColumns = 116;

std::string located(const fs::path& file, const YAML::Mark& mark) {
    if (mark.line < 0) return file.string();
    return file.string() + ':' + std::to_string(mark.line + 1) + ':' + std::to_string(mark.column + 1);
}

const char* typeName(const YAML::Node& node) {
    if (node.IsMap()) return "a map";
    if (node.IsSequence()) return "a list";
    if (node.IsNull()) return "nothing";
    return node.Tag() == "!" ? "text in quotes" : "a value";
}

bool isSection(const std::string& path) {
    return std::any_of(configKeys().begin(), configKeys().end(),
                       [&](const ConfigKey& key) { return key.path.starts_with(path + '.'); });
}

const ConfigKey* keyAt(const std::string& path) {
    const auto& keys = configKeys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const ConfigKey& k) { return k.path == path; });
    return key == keys.end() ? nullptr : &*key;
}

/// The name of an entry of a map. `seen` collects the names of the map, to refuse a second entry of the same name.
std::string nameOf(const YAML::Node& name, std::set<std::string>& seen, const fs::path& file) {
    if (!name.IsScalar()) {
        throw Error(located(file, name.Mark()) + ": a key is " + typeName(name) + ". Use a plain name such as radius.");
    }
    if (!seen.insert(name.Scalar()).second) {
        throw Error(located(file, name.Mark()) + ": the key '" + name.Scalar() +
                    "' is set a second time. Remove one of the two.");
    }
    return name.Scalar();
}

void set(Config& config, const KeyValue& key_value) {
    setConfigKey(config, key_value.path, key_value.value, key_value.where);
}

KeyValue keyValueOf(const YAML::Node& name, const std::string& path, const YAML::Node& value, const fs::path& file) {
    const ConfigKey* key = keyAt(path);
    if (key == nullptr) return {path, "", located(file, name.Mark())};  // setConfigKey() refuses it
    if (key->kind == ConfigKey::Kind::list && value.IsSequence()) {
        std::string names;
        for (const auto& one : value) {
            if (!one.IsScalar())
                throw Error(located(file, one.Mark()) + ": " + path + ": an entry of the list is " + typeName(one) +
                            ". Use a name.");
            names += (names.empty() ? "" : ",") + one.Scalar();
        }
        return {path, names, located(file, value.Mark())};
    }
    const bool takes_text = key->kind == ConfigKey::Kind::text || key->kind == ConfigKey::Kind::list ||
                            key->kind == ConfigKey::Kind::choice;
    const bool quoted_number = value.IsScalar() && value.Tag() == "!" && !takes_text;
    if (!value.IsScalar() || quoted_number) {
        const bool may_be_comment = value.IsNull() && path.ends_with("path");
        throw Error(located(file, value.IsNull() ? name.Mark() : value.Mark()) + ": " + path + ": the value is " +
                    typeName(value) + ". Use " + key->accepts + '.' +
                    (may_be_comment ? " A path that begins with # needs quotes, because # begins a comment." : ""));
    }
    return {path, value.Scalar(), located(file, value.Mark())};
}

void requireSectionMap(const YAML::Node& name, const std::string& section, const YAML::Node& rows,
                       const fs::path& file) {
    if (rows.IsMap()) return;
    const auto first = std::find_if(configKeys().begin(), configKeys().end(),
                                    [&](const ConfigKey& key) { return key.path.starts_with(section + '.'); });
    std::string example = first->path.substr(section.size() + 1) + ": " + first->get(Config{});
    if (keyAt(section + ".path") != nullptr)
        example =
            "path: " + (rows.IsScalar() ? rows.Scalar() : section + ".####." + (section == "preview" ? "png" : "ply"));
    throw Error(
        located(file, rows.IsNull() ? name.Mark() : rows.Mark()) + ": " + section + ": " +
        (rows.IsScalar() ? '\'' + rows.Scalar() + "' is no map" : std::string("the value is ") + typeName(rows)) +
        ". Use a map of keys, as in " + section + ": {" + example + "}.");
}

void applySection(Config& config, const YAML::Node& name, const std::string& section, const YAML::Node& rows,
                  const fs::path& file) {
    requireSectionMap(name, section, rows, file);
    std::set<std::string> seen;
    for (const auto& row : rows) {
        set(config, keyValueOf(row.first, section + '.' + nameOf(row.first, seen, file), row.second, file));
    }
}

/// Whether all outputs of a job have the same value for a key, since they are made together, frame by frame.
bool isOfWholeJob(const std::string& path) {
    return path == "frames" || path == "input.path" || path.starts_with("run.");
}

/// The keys of one entry of `outputs`, `preset` first: sections as in a pipeline file, and keys of the section output
/// by their own names.
std::vector<KeyValue> outputKeys(const YAML::Node& output, const fs::path& file) {
    if (!output.IsMap())
        throw Error(located(file, output.Mark()) + ": outputs: an output is " + typeName(output) +
                    ". Use a map such as {path: mesh/splash.####.ply}.");
    std::vector<KeyValue> keys;
    std::set<std::string> seen, seen_paths;
    const auto add = [&](const YAML::Node& name, const std::string& path, const YAML::Node& value) {
        if (isOfWholeJob(path))
            throw Error(located(file, name.Mark()) + ": " + path +
                        " is the same for all outputs. Set it outside of the list.");
        if (!seen_paths.insert(path).second)
            throw Error(located(file, name.Mark()) + ": " + path + " is set a second time. Remove one of the two.");
        keys.push_back(keyValueOf(name, path, value, file));
    };
    for (const auto& row : output) {
        const std::string name = nameOf(row.first, seen, file);
        if (isSection(name)) {
            requireSectionMap(row.first, name, row.second, file);
            std::set<std::string> seen_inside;
            for (const auto& inside : row.second)
                add(inside.first, name + '.' + nameOf(inside.first, seen_inside, file), inside.second);
        } else {
            add(row.first, keyAt("output." + name) != nullptr ? "output." + name : name, row.second);
        }
    }
    std::stable_partition(keys.begin(), keys.end(), [](const KeyValue& key) { return key.path == "preset"; });
    return keys;
}

constexpr const char* kOutputsExpected =
    ". Use a list such as [{path: mesh/hero.####.bgeo}, {path: mesh/proxy.####.ply, preset: preview}].";

void applyOutputs(Config& config, const YAML::Node& name, const YAML::Node& list, const fs::path& file) {
    if (!list.IsSequence())
        throw Error(located(file, list.IsNull() ? name.Mark() : list.Mark()) + ": outputs: the value is " +
                    typeName(list) + kOutputsExpected);
    config.outputs.clear();
    for (const auto& output : list) {
        config.outputs.push_back(outputKeys(output, file));
        Config unused = config;
        for (const KeyValue& key : config.outputs.back()) set(unused, key);
    }
}

/// Applies all entries of a file except `version`, `include` and `preset`. Returns the value of `preset`.
std::optional<KeyValue> applyRows(Config& config, const YAML::Node& root, const fs::path& file) {
    std::optional<KeyValue> preset;
    std::set<std::string> seen;
    for (const auto& row : root) {
        const std::string name = nameOf(row.first, seen, file);
        if (name == "version" || name == "include") continue;
        if (isSection(name)) {
            applySection(config, row.first, name, row.second, file);
        } else if (name == "outputs") {
            applyOutputs(config, row.first, row.second, file);
        } else if (name == "preset") {
            preset = keyValueOf(row.first, name, row.second, file);
        } else {
            set(config, keyValueOf(row.first, name, row.second, file));
        }
    }
    if (const YAML::Node list = root["outputs"]; list && list.size() == 0 && config.output.path.empty())
        throw Error(located(file, list.Mark()) + ": outputs: the list is empty" + kOutputsExpected);
    return preset;
}

void checkVersion(const YAML::Node& root, const fs::path& file) {
    const YAML::Node version = root["version"];
    if (!version) throw Error(file.string() + ":1:1: the version is missing. Add the line 'version: 1'.");
    if (!version.IsScalar() || version.Scalar() != std::to_string(kVersion)) {
        throw Error(located(file, version.Mark()) +
                    ": version: " + (version.IsScalar() ? "'" + version.Scalar() + "'" : typeName(version)) +
                    " is not supported. Use 'version: 1'.");
    }
}

/// The file that an include names, relative to the including file or else to the current folder.
fs::path includedFile(const YAML::Node& include, const fs::path& file) {
    if (!include.IsScalar() || include.Scalar().empty()) {
        throw Error(located(file, include.Mark()) + ": include: the value is " + typeName(include) +
                    ". Use a path or a list of paths.");
    }
    const fs::path name(withVariables(include.Scalar()));
    const fs::path beside = file.parent_path() / name;
    for (const fs::path& candidate : {beside, name}) {
        std::error_code ignored;
        if (fs::is_regular_file(candidate, ignored)) return candidate;
    }
    throw Error(located(file, include.Mark()) + ": include: '" + name.string() + "' does not exist. Looked for " +
                beside.lexically_normal().string() + " and " + fs::absolute(name).lexically_normal().string() + '.');
}

/// errors  particles or a mesh where a pipeline file is expected. Braces may be those of a pipeline file in JSON
void requireNoGeometry(const fs::path& file) {
    std::string begin(kSignatureBytes, '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
    begin.resize(static_cast<std::size_t>(in.gcount()));
    const std::string extension = extensionOfContents(begin);
    if (!extension.empty() && !begin.starts_with('{'))
        throw Error(file.string() + ": this is a file of particles or meshes (" + extension +
                    "), not a pipeline file (.yaml). `betamesh mesh IN OUT` needs no pipeline file.");
}

template <typename Load>
YAML::Node readYaml(const fs::path& file, const Load& load) {
    try {
        const std::vector<YAML::Node> documents = load();
        if (documents.size() > 1) {
            throw Error(located(file, documents[1].Mark()) +
                        ": a second YAML document begins here. Use one document per file.");
        }
        const YAML::Node root = documents.empty() ? YAML::Node() : documents.front();
        if (!root.IsMap()) {
            requireNoGeometry(file);
            throw Error(file.string() + ":1:1: the file contains " + typeName(root) +
                        ". A pipeline file begins with 'version: 1'.");
        }
        return root;
    } catch (const YAML::BadFile&) {
        throw Error(file.string() + ": cannot be read. Give the path of a pipeline file (.yaml).");
    } catch (const YAML::Exception& error) {
        requireNoGeometry(file);
        throw Error(located(file, error.mark) + ": this is not valid YAML: " + error.msg);
    }
}

/// Applies a file and those it includes, except `preset`, whose value is returned. `chain` lists the including files.
std::optional<KeyValue> applyFile(Config& config, const fs::path& file, std::vector<fs::path>& chain) {
    std::error_code error;
    const fs::path identity = fs::canonical(file, error);
    if (error) throw Error(file.string() + ": " + error.message() + ". Give the path of a pipeline file (.yaml).");
    if (fs::is_directory(identity))
        throw Error(file.string() + ": this is a folder. Give the path of a pipeline file (.yaml).");
    requireRegularFile(file);
    const bool is_circle = std::find(chain.begin(), chain.end(), identity) != chain.end();
    if (is_circle || chain.size() >= kMaxIncludeDepth) {
        std::string links;
        for (const fs::path& link : chain) links += link.filename().string() + " -> ";
        throw Error(file.string() + ": include: these files include each other " +
                    (is_circle ? "in a circle: " : "in more than " + std::to_string(kMaxIncludeDepth) + " levels: ") +
                    links + identity.filename().string());
    }
    chain.push_back(identity);
    config.files.push_back(file);

    const YAML::Node root = readYaml(file, [&] { return YAML::LoadAllFromFile(file.string()); });
    checkVersion(root, file);
    std::optional<KeyValue> preset;
    const auto applyIncluded = [&](const YAML::Node& include) {
        if (auto included = applyFile(config, includedFile(include, file), chain)) preset = std::move(included);
    };
    if (const YAML::Node include = root["include"]) {
        if (include.IsSequence()) {
            for (const auto& one : include) applyIncluded(one);
        } else {
            applyIncluded(include);
        }
    }
    if (auto own = applyRows(config, root, file)) preset = std::move(own);
    chain.pop_back();
    return preset;
}

/// Prints text as comment lines of at most kCommentColumns.
void printComment(std::ostream& out, const std::string& indent, const std::string& text) {
    std::istringstream words(text);
    std::string line = indent + '#';
    for (std::string word; words >> word;) {
        if (line.size() + 1 + word.size() > kCommentColumns) {
            out << line << '\n';
            line = indent + '#';
        }
        line += ' ' + word;
    }
    out << line << '\n';
}

std::string yamlScalar(const std::string& value) {
    YAML::Emitter emitter;
    if (value.empty()) return "\"\"";
    emitter << value;
    return emitter.c_str();
}

/// Prints an entry of `outputs`.
void printOutput(std::ostream& out, const std::vector<KeyValue>& keys) {
    std::map<std::string, std::map<std::string, std::string>> sections;
    for (const KeyValue& key : keys) {
        const std::size_t dot = key.path.find('.');
        const bool inside = dot != std::string::npos;
        sections[inside ? key.path.substr(0, dot) : ""][inside ? key.path.substr(dot + 1) : key.path] = key.value;
    }
    const char* indent = "  - ";
    for (const auto& [section, values] : sections) {
        if (!section.empty()) out << std::exchange(indent, "    ") << section << ":\n";
        for (const auto& [name, value] : values)
            out << (section.empty() ? std::exchange(indent, "    ") : "      ") << name << ": " << yamlScalar(value)
                << '\n';
    }
}

}  // namespace

void applyPreset(Config& config, std::string_view name) {
    const Preset& preset = presetNamed(name);
    const fs::path source = "preset '" + std::string(name) + "'";
    applyRows(config, readYaml(source, [&] { return YAML::LoadAll(std::string(preset.text)); }), source);
}

Config readConfig(const fs::path& file, const std::vector<KeyValue>& command_line, const Config& base) {
    const auto isPreset = [](const KeyValue& key_value) { return key_value.path == "preset"; };
    std::optional<KeyValue> preset;
    if (!file.empty()) {
        Config unused;
        std::vector<fs::path> chain;
        preset = applyFile(unused, file, chain);
    }
    for (const KeyValue& key_value : command_line)
        if (isPreset(key_value)) preset = key_value;

    Config config = base;
    if (preset) set(config, *preset);
    if (!file.empty()) {
        std::vector<fs::path> chain;
        applyFile(config, file, chain);
    }
    for (const KeyValue& key_value : command_line)
        if (!isPreset(key_value)) set(config, key_value);
    return config;
}

ParticleInput inputOf(const Config& config, int frame) {
    ParticleInput input = config.input;
    if (config.input.is_one_file) input.frame = frame;
    return input;
}

std::vector<Config> outputConfigs(const Config& config) {
    if (config.outputs.empty()) return {config};
    if (!config.output.path.empty())
        throw Error("output.path is '" + config.output.path +
                    "' beside a list of outputs. Make it an entry of that list");
    std::vector<Config> all;
    for (const std::vector<KeyValue>& keys : config.outputs) {
        Config& output = all.emplace_back(config);
        output.outputs.clear();
        for (const KeyValue& key : keys) set(output, key);
        if (output.output.path.empty())
            throw Error("output " + std::to_string(all.size()) +
                        " of the list of outputs has no path. Set path, as in path: mesh/splash.####.ply");
    }
    return all;
}

std::string printConfig(const Config& config) {
    std::ostringstream out;
    out << "version: " << kVersion << '\n';
    std::string section;
    const Config defaults;
    for (const ConfigKey& key : configKeys()) {
        if (!key.replaced_by.empty() && key.get(config) == key.get(defaults)) continue;
        const std::size_t dot = key.path.find('.');
        const bool inside = dot != std::string::npos;
        const std::string indent = inside ? "  " : "";
        if (inside && key.path.substr(0, dot) != section) {
            section = key.path.substr(0, dot);
            out << '\n' << section << ":\n";
        } else {
            out << '\n';
        }
        printComment(out, indent, key.help);
        printComment(out, indent,
                     "Values: " + key.accepts + '.' + (key.unit.empty() ? "" : " Unit: " + key.unit + '.'));
        out << indent << key.path.substr(inside ? dot + 1 : 0) << ": " << yamlScalar(key.get(config)) << '\n';
    }
    if (!config.outputs.empty()) {
        out << "\n# The meshes that the job writes for each frame, and the keys that they set themselves.\noutputs:\n";
        for (const std::vector<KeyValue>& keys : config.outputs) printOutput(out, keys);
    }
    return out.str();
}

}  // namespace betamesh
