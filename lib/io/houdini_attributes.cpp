#include "io/houdini_attributes.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace betamesh {

namespace {

// source  files of Houdini 13.0 to 21.0. An attribute is an array of its definition and its values. The values of all
//         rows are stored in one of three ways:
//   tuples       an array for each row
//   arrays       an array for each component
//   rawpagedata  one array of numbers. Rows are grouped into pages of `pagesize` rows, the components of a row into
//                subvectors whose sizes `packing` lists (default: all in one). Page after page, inside a page
//                subvector after subvector, the rows follow each other; where `constantpageflags` has a true for the
//                subvector and page, one row stands for all rows of the page.
constexpr std::uint32_t kMaxSize = 1000;      // wider attributes are declared, but not read
constexpr std::uint64_t kMaxPageRows = 4096;  // Houdini's pages have 1024; a damaged size must not ask for memory
constexpr std::uint64_t kDefaultPageRows = 1024;

struct Pages {
    std::uint64_t rows = 0;  // of all pages together
    std::uint64_t page_rows = kDefaultPageRows;
    std::vector<std::uint32_t> packing;       // components of each subvector
    std::vector<std::vector<bool>> constant;  // of each subvector: of each page, or none

    std::uint64_t count() const { return (rows + page_rows - 1) / page_rows; }
    std::uint64_t rowsOf(std::uint64_t page) const { return std::min(page_rows, rows - page * page_rows); }
    bool isConstant(std::size_t subvector, std::uint64_t page) const {
        return subvector < constant.size() && !constant[subvector].empty() && constant[subvector][page];
    }
    bool isPlain() const {
        return packing.size() == 1 &&
               std::all_of(constant.begin(), constant.end(), [](const auto& c) { return c.empty(); });
    }
    /// Numbers that are stored for a page.
    std::uint64_t stored(std::uint64_t page) const {
        std::uint64_t numbers = 0;
        for (std::size_t s = 0; s < packing.size(); ++s)
            numbers += packing[s] * (isConstant(s, page) ? 1 : rowsOf(page));
        return numbers;
    }
};

std::string inQuotes(const std::string& name) {
    std::string shown = "'";
    for (const char c : name.substr(0, 60)) shown += c >= ' ' && c <= '~' ? c : '?';
    return shown + "'";
}

/// Expands pages as their numbers arrive. Numbers of a page are collected before room is made for its rows.
template <typename T>
class PageReader {
public:
    PageReader(const Pages& pages, std::uint32_t size, std::vector<T>& column)
        : pages_(pages), size_(size), column_(column) {}

    /// False: more than all pages need.
    bool add(std::span<const T> numbers) {
        while (!numbers.empty()) {
            if (page_ == pages_.count()) return false;
            const std::uint64_t missing = pages_.stored(page_) - page_numbers_.size();
            const auto some = numbers.first(static_cast<std::size_t>(std::min<std::uint64_t>(missing, numbers.size())));
            page_numbers_.insert(page_numbers_.end(), some.begin(), some.end());
            numbers = numbers.subspan(some.size());
            if (some.size() == missing) expand();
        }
        return true;
    }

private:
    void expand() {
        const auto rows = static_cast<std::size_t>(pages_.rowsOf(page_));
        expanded_.resize(rows * size_);
        const T* from = page_numbers_.data();
        std::size_t first = 0;  // component
        for (std::size_t s = 0; s < pages_.packing.size(); ++s) {
            const std::size_t width = pages_.packing[s];
            const bool constant = pages_.isConstant(s, page_);
            for (std::size_t row = 0; row < rows; ++row) {
                std::copy_n(from, width, expanded_.data() + row * size_ + first);
                if (!constant) from += width;
            }
            if (constant) from += width;
            first += width;
        }
        appendToColumn(std::span<const T>(expanded_), pages_.rows * size_, column_);
        page_numbers_.clear();
        ++page_;
    }

    const Pages& pages_;
    std::uint32_t size_;
    std::vector<T>& column_;
    std::vector<T> page_numbers_, expanded_;
    std::uint64_t page_ = 0;
};

class AttributeReader {
public:
    AttributeReader(HoudiniJsonReader& json, std::uint64_t rows,
                    const std::function<bool(const HoudiniAttribute&)>& isWanted)
        : json_(json), rows_(rows), isWanted_(isWanted) {}

    HoudiniAttribute read() {
        int part = 0;
        json_.forElements("attribute", [&] {
            switch (part++) {
                case 0:
                    return readDefinition();
                case 1:
                    return readBody();
                default:
                    return json_.skip();
            }
        });
        if (part < 2) fail("has no values");
        if (has_numbers_ && (attribute_.size != read_size_ || attribute_.storage != read_storage_))
            fail("has its size or storage after its numbers, expected them before");
        return std::move(attribute_);
    }

private:
    [[noreturn]] void fail(const std::string& text) const {
        json_.fail("attribute " + inQuotes(attribute_.name) + " " + text);
    }

    void readDefinition() {
        json_.forKeys("definition of an attribute", [&](const std::string& key) {
            if (key == "name")
                attribute_.name = json_.text("name of an attribute");
            else if (key == "type")
                attribute_.type = json_.text("type of an attribute");
            else
                json_.skip();
        });
    }

    void readBody() {
        json_.forKeys("values of an attribute", [&](const std::string& key) {
            if (key == "size")
                attribute_.size = readSize();
            else if (key == "storage")
                attribute_.storage = json_.text("storage of an attribute");
            else if (key == "values" && attribute_.type == "numeric")
                readValues();
            else
                json_.skip();
        });
    }

    std::uint32_t readSize() {
        const std::int64_t size = json_.integer("size of an attribute");
        if (size < 0 || size > std::numeric_limits<std::int32_t>::max())
            fail("has " + std::to_string(size) + " components, expected 0 or more");
        return static_cast<std::uint32_t>(size);
    }

    void readValues() {
        json_.forKeys("values of an attribute", [&](const std::string& key) {
            if (key == "size")
                attribute_.size = readSize();
            else if (key == "storage")
                attribute_.storage = json_.text("storage of an attribute");
            else if (key == "pagesize")
                readPageSize();
            else if (key == "packing")
                readPacking();
            else if (key == "constantpageflags")
                readConstantFlags();
            else if (key == "rawpagedata" || key == "tuples" || key == "arrays")
                readNumbers(key);
            else
                json_.skip();
        });
    }

    void readPageSize() {
        const std::int64_t size = json_.integer("pagesize");
        if (size < 1 || size > static_cast<std::int64_t>(kMaxPageRows))
            fail("has pages of " + std::to_string(size) + " rows, expected 1 to " + std::to_string(kMaxPageRows));
        pages_.page_rows = static_cast<std::uint64_t>(size);
    }

    void readPacking() {
        pages_.packing.clear();
        json_.forElements("packing", [&] {
            const std::int64_t width = json_.integer("packing");
            if (width < 1 || width > kMaxSize || pages_.packing.size() == kMaxSize)
                fail("has a packing of " + std::to_string(width) + ", expected parts of its size");
            pages_.packing.push_back(static_cast<std::uint32_t>(width));
        });
    }

    void readConstantFlags() {
        pages_.constant.clear();
        json_.forElements("constantpageflags", [&] {
            if (pages_.constant.size() == kMaxSize) fail("has constantpageflags of more than 1000 subvectors");
            std::vector<bool>& flags = pages_.constant.emplace_back();
            json_.forElements("constantpageflags", [&] { flags.push_back(json_.boolean("constantpageflags")); });
        });
    }

    void readNumbers(const std::string& layout) {
        HoudiniAttribute& a = attribute_;
        a.real.clear();
        a.real64.clear();
        a.integer.clear();
        a.integer64.clear();
        has_numbers_ = true;
        read_size_ = a.size;
        read_storage_ = a.storage;
        const bool readable = (a.isReal() || a.isInteger()) && a.size > 0 && a.size <= kMaxSize;
        if (!readable || !isWanted_(a)) return json_.skip();
        if (a.storage == "fpreal64" && a.name == "P")
            readColumn(layout, a.real64);
        else if (a.isReal())
            readColumn(layout, a.real);
        else if (a.storage == "int64")
            readColumn(layout, a.integer64);
        else
            readColumn(layout, a.integer);
    }

    template <typename T>
    void readColumn(const std::string& layout, std::vector<T>& column) {
        if (layout == "rawpagedata")
            readPages(column);
        else if (layout == "tuples")
            readTuples(column);
        else
            readArrays(column);
        if (column.size() != rows_ * attribute_.size)
            fail("has " + std::to_string(column.size()) + " numbers, expected " + std::to_string(attribute_.size) +
                 " in each of " + std::to_string(rows_) + " rows");
    }

    template <typename T>
    void readPages(std::vector<T>& column) {
        pages_.rows = rows_;
        if (pages_.packing.empty()) pages_.packing = {attribute_.size};
        if (std::accumulate(pages_.packing.begin(), pages_.packing.end(), std::uint64_t{0}) != attribute_.size)
            fail("has a packing whose sum is not its size " + std::to_string(attribute_.size));
        for (const auto& flags : pages_.constant)
            if (!flags.empty() && flags.size() != pages_.count())
                fail("has constantpageflags of " + std::to_string(flags.size()) + " pages, expected " +
                     std::to_string(pages_.count()));
        PageReader<T> reader(pages_, attribute_.size, column);
        const bool plain = pages_.isPlain();
        json_.forNumbers<T>("rawpagedata", [&](std::span<const T> numbers) {
            if (plain)
                append(numbers, attribute_.size, column);
            else if (!reader.add(numbers))
                fail("has more numbers than its pages have room for");
        });
    }

    template <typename T>
    void readTuples(std::vector<T>& column) {
        json_.forElements("tuples", [&] {
            const std::size_t before = column.size();
            json_.forNumbers<T>("tuple", [&](std::span<const T> numbers) { append(numbers, attribute_.size, column); });
            if (column.size() - before != attribute_.size)
                fail("has a tuple of " + std::to_string(column.size() - before) + " numbers, expected " +
                     std::to_string(attribute_.size));
        });
    }

    template <typename T>
    void readArrays(std::vector<T>& column) {
        std::vector<std::vector<T>> components;
        json_.forElements("arrays", [&] {
            if (components.size() == attribute_.size) fail("has more arrays than components");
            std::vector<T>& component = components.emplace_back();
            json_.forNumbers<T>("array", [&](std::span<const T> numbers) { append(numbers, 1, component); });
            if (component.size() != rows_)
                fail("has " + std::to_string(component.size()) + " numbers in an array, expected " +
                     std::to_string(rows_));
        });
        if (components.size() != attribute_.size) fail("has fewer arrays than components");
        column.reserve(rows_ * components.size());
        for (std::size_t row = 0; row < rows_; ++row)
            for (const std::vector<T>& component : components) column.push_back(component[row]);
    }

    template <typename T>
    void append(std::span<const T> numbers, std::uint64_t size, std::vector<T>& column) const {
        if (column.size() + numbers.size() > rows_ * size)
            fail("has more numbers than " + std::to_string(size) + " in each of " + std::to_string(rows_) + " rows");
        appendToColumn(numbers, rows_ * size, column);
    }

    HoudiniJsonReader& json_;
    std::uint64_t rows_;
    const std::function<bool(const HoudiniAttribute&)>& isWanted_;
    HoudiniAttribute attribute_;
    Pages pages_;
    bool has_numbers_ = false;
    std::uint32_t read_size_ = 0;  // size and storage when the numbers were read
    std::string read_storage_;
};

class GroupReader {
public:
    GroupReader(HoudiniJsonReader& json, std::uint64_t n) : json_(json), n_(n) {}

    HoudiniGroup read() {
        int part = 0;
        json_.forElements("group", [&] {
            if (part++ > 1) return json_.skip();
            json_.forKeys("group", [&](const std::string& key) {
                if (key == "name")
                    group_.name = json_.text("name of a group");
                else if (key == "selection")
                    readSelection();
                else
                    json_.skip();
            });
        });
        if (group_.member.size() != n_)
            fail("has " + std::to_string(group_.member.size()) + " rows, expected " + std::to_string(n_));
        return std::move(group_);
    }

private:
    [[noreturn]] void fail(const std::string& text) const { json_.fail("group " + inQuotes(group_.name) + " " + text); }

    void readSelection() {
        json_.forKeys("selection of a group", [&](const std::string& key) {
            group_.member.clear();
            if (key == "unordered")
                readUnordered();
            else if (key == "ordered")
                readOrdered();
            else
                json_.skip();
        });
    }

    void readUnordered() {
        json_.forKeys("members of a group", [&](const std::string& key) {
            group_.member.clear();
            if (key == "i8")
                json_.forNumbers<std::int32_t>("members of a group", [&](std::span<const std::int32_t> flags) {
                    for (const std::int32_t flag : flags) append(1, flag != 0);
                });
            else if (key == "boolRLE")
                readRuns();
            else
                json_.skip();
        });
    }

    /// Pairs of a length and a boolean.
    void readRuns() {
        bool is_length = true;
        std::int64_t length = 0;
        json_.forElements("members of a group", [&] {
            if (is_length)
                length = json_.integer("length of a run of members");
            else
                append(length, json_.boolean("members of a group"));
            is_length = !is_length;
        });
    }

    void readOrdered() {
        group_.member.assign(static_cast<std::size_t>(n_), 0);
        json_.forNumbers<std::int64_t>("members of a group", [&](std::span<const std::int64_t> rows) {
            for (const std::int64_t row : rows) {
                if (row < 0 || static_cast<std::uint64_t>(row) >= n_)
                    fail("has member " + std::to_string(row) + ", expected less than " + std::to_string(n_));
                group_.member[static_cast<std::size_t>(row)] = 1;
            }
        });
    }

    void append(std::int64_t count, bool is_member) {
        const std::uint64_t left = n_ - group_.member.size();
        if (count < 0 || static_cast<std::uint64_t>(count) > left)
            fail("has a run of " + std::to_string(count) + " members, expected at most " + std::to_string(left));
        group_.member.insert(group_.member.end(), static_cast<std::size_t>(count), is_member);
    }

    HoudiniJsonReader& json_;
    std::uint64_t n_;
    HoudiniGroup group_;
};

}  // namespace

bool HoudiniAttribute::isInteger() const {
    static constexpr std::array<std::string_view, 6> kStorages{"int8", "int16", "int32", "int64", "uint8", "uint16"};
    return std::find(kStorages.begin(), kStorages.end(), storage) != kStorages.end();
}

HoudiniAttribute readHoudiniAttribute(HoudiniJsonReader& json, std::uint64_t rows,
                                      const std::function<bool(const HoudiniAttribute&)>& isWanted) {
    return AttributeReader(json, rows, isWanted).read();
}

HoudiniGroup readHoudiniGroup(HoudiniJsonReader& json, std::uint64_t n) { return GroupReader(json, n).read(); }

}  // namespace betamesh
