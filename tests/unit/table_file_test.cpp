// Tables of text, PRT and STL.

#include "io/file_info.h"
#include "io/output_file.h"
#include "io/prt.h"
#include "io/stl.h"
#include "io/table.h"
#include "support/file_checks.h"

#include <cstring>
#include <limits>

namespace betamesh {
namespace {

FileContents table(const std::string& text, const ReadOptions& options = {}) {
    const Bytes bytes = bytesOf(text);
    return parseTable({bytes, "a.csv"}, options);
}

Bytes tableOf(const Particles& particles) {
    return bytesOf([&](ByteWriter& out) { encodeTable(out, particles, "a.csv"); });
}

std::vector<std::string> namesOf(const FileContents& contents) {
    std::vector<std::string> names;
    for (const Attribute& a : contents.attributes) names.push_back(a.name + "/" + std::to_string(a.components));
    return names;
}

TEST(TableFile, NamedColumnsOfEveryUsualSpelling) {
    using Names = std::vector<std::string>;
    const std::vector<std::pair<std::string, Names>> tables{
        {"x,y,z,density\n1,2,3,0.5\n4,5,6,1.5\n", {"density/1"}},
        {"\xef\xbb\xbfX;Y;Z;density\r\n1;2;3;0.5\r\n\r\n4;5;6;1.5\r\n", {"density/1"}},
        {"# comment\nx y z\tdensity\n1 2 3 .5\n4\t5 6 1.5", {"density/1"}},
        {"\"Points:0\",\"Points:1\",\"Points:2\",\"v:0\",\"v:1\",\"v:2\"\n1,2,3,0,0,1\n4,5,6,0,1,0\n", {"v/3"}},
        {"id,P.x,P.y,P.z,vel_x,vel_y,vel_z\n7,1,2,3,0,0,1\n8,4,5,6,0,1,0\n", {"vel/3"}},
        {"x,y,z,vx,vy,vz,\"type\"\n1,2,3,0,0,1,2\n4,5,6,0,1,0,1\n", {"v/3", "type/1"}},
        {"z,y,x,a[0],a[1],b.y\n3,2,1,0,0,1\n6,5,4,0,1,0\n", {"a/2", "b.y/1"}},
        {"1 2 3 9\n4 5 6 8\n", {"column4/1"}},
        {"2\nwater\nO 1 2 3\nH 4 5 6\n", {}},
    };
    for (const auto& [text, names] : tables) {
        SCOPED_TRACE(text);
        const FileContents contents = table(text);
        EXPECT_EQ(contents.position, (std::vector<Vec3f>{{1, 2, 3}, {4, 5, 6}}));
        EXPECT_EQ(namesOf(contents), names);
    }
    EXPECT_EQ(table(tables[4].first).id, (std::vector<std::uint64_t>{7, 8}));
    EXPECT_EQ(table(tables[5].first).attributes[1].integer, (std::vector<std::int32_t>{2, 1}));
    for (const char* empty : {"x,y,z\n", "# x y z\n", "0\nnothing\n", "0"})
        EXPECT_TRUE(table(empty).position.empty()) << empty;
}

TEST(TableFile, TypesDoNotDependOnTheNumbers) {
    const auto typesOf = [](const std::string& header, const std::string& row, const ReadOptions& options = {}) {
        std::string types;
        const FileContents contents = table(header + '\n' + row + '\n', options);
        for (const Attribute& a : contents.attributes) types += a.hasIntegers() ? 'i' : 'f';
        return types + (contents.id.empty() ? "" : " id") + (contents.has_double_positions ? " double" : "");
    };
    ReadOptions by_key;
    by_key.id = "key";
    for (const char* row : {"1,2,3,4,5,6,7", "1.5,2.5,3.5,4.0,5.5,6.5,7.0", "1e3,2,3,4e0,5e-1,nan,7e0"}) {
        SCOPED_TRACE(row);
        EXPECT_EQ(typesOf("x,y,z,id,temp,a,\"key\"", row), "ffi id double");
        EXPECT_EQ(typesOf("\"x\",\"y\",\"z\",\"id\",\"temp\",\"a\",\"key\"", row), "fff id double");
        EXPECT_EQ(typesOf("x,y,z,state,a.x,a.y,key", row, by_key), "ff id double");
        EXPECT_EQ(typesOf("x,y,z,group:foam,\"vx\",\"vy\",key", row), "iff double");
    }
}

TEST(TableFile, IdsAreExactWholeNumbers) {
    for (const std::int64_t id : {0LL, -1LL, 16777217LL, (1LL << 53) + 1, std::numeric_limits<long long>::max()}) {
        const FileContents contents = table("x,y,z,id\n1,2,3," + std::to_string(id) + '\n');
        EXPECT_EQ(contents.id, std::vector<std::uint64_t>{static_cast<std::uint64_t>(id)});
    }
    EXPECT_EQ(table("x,y,z,id\n1,2,3,7.0\n4,5,6,8e3\n").id, (std::vector<std::uint64_t>{7, 8000}));
    for (const char* id : {"1.5", "nan", "1e17", "9007199254740993.0"})
        expectError([&] { table("x,y,z,id\n1,2,3,4\n1,2,3," + std::string(id) + '\n'); },
                    {"a.csv: line 3: ", id, "in column 'id' is not an exact whole number"});
    const FileContents left_out = table("x,y,z,\"count\"\n1,2,3,1.5\n");
    EXPECT_TRUE(left_out.attributes.empty());
    EXPECT_EQ(left_out.warnings, std::vector<std::string>{"attribute 'count' is left out: line 2: 1.5 in column "
                                                          "'count' is not an exact whole number"});
}

TEST(TableFile, RenamedColumnsAreNamedOnce) {
    const FileContents contents = table("x,y,z,,a b,c\td,e\n1,2,3,4,5,6,7\n");
    EXPECT_EQ(namesOf(contents), (std::vector<std::string>{"unnamed/1", "a_b/1", "c_d/1", "e/1"}));
    EXPECT_EQ(contents.warnings,
              std::vector<std::string>{"columns without a name, or with white space in it, "
                                       "are renamed: '' to 'unnamed', 'a b' to 'a_b', 'c\td' to 'c_d'"});
    EXPECT_TRUE(table("x,y,z,a,b.x,b.y,vx,vy,vz\n1,2,3,4,5,6,7,8,9\n").warnings.empty());
}

TEST(TableFile, QuotesAreThoseOfRfc4180) {
    const FileContents contents =
        table("x,y,z,\"a,b\",\"say \"\"hi\"\"\",  \"two\nlines\" ,5\" pipe\n\"1\",2,3,\"4\",5,6,7\n");
    EXPECT_EQ(namesOf(contents), (std::vector<std::string>{"a,b/1", "say_\"hi\"/1", "two_lines/1", "5\"_pipe/1"}));
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{1, 2, 3}}));
    EXPECT_EQ(contents.attributes[3].real, std::vector<float>{7});
    EXPECT_EQ(namesOf(table("x;y;z;\"a,b\"\n1;2;3;4\n")), (std::vector<std::string>{"a,b/1"}));
    expectError([] { table("x,y,z,\"a\n1,2,3,4\n"); }, {"a.csv", "a quote is not closed"});
    Particles particles = sampleParticles(2, false, false, false);
    particles.attributes = {{"say\"hi\"", 1, {1, 2}, {}}, {"a,b", 1, {7, -7}, {}}};
    const Bytes bytes = tableOf(particles);
    expectSame(particlesFrom(parseTable({bytes, "a.csv"}), {}, "a.csv").attributes, particles.attributes);
}

TEST(TableFile, ColumnsWithTheSameNameAreNamedInAWarning) {
    const FileContents contents = table("x,y,z,a,b,a,P.x,X,b c,b_c\n1,2,3,4,5,6,7,8,9,10\n");
    EXPECT_EQ(namesOf(contents), (std::vector<std::string>{"a/1", "b/1", "b_c/1"}));
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{1, 2, 3}}));
    EXPECT_EQ(contents.attributes[0].real, std::vector<float>{4});
    ASSERT_EQ(contents.warnings.size(), 5U);  // the last one tells of `b c`
    for (const auto& [i, name] : {std::pair(0, "column 6 ('a')"), std::pair(1, "column 7 ('P.x')"),
                                  std::pair(2, "column 8 ('X')"), std::pair(3, "column 'b_c'")})
        EXPECT_NE(contents.warnings[static_cast<std::size_t>(i)].find(name), std::string::npos);
}

TEST(TableFile, ColumnsThatAreNotNumbersAreLeftOutWithAWarning) {
    const FileContents contents = table("name,x,y,z,mass\ndrop,1,2,3,4,\nspray,4,5,6,\n");
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_TRUE(contents.attributes.empty());
    EXPECT_EQ(contents.warnings,
              (std::vector<std::string>{"attribute 'name' is left out: line 2: 'drop' in column 'name' is no number",
                                        "attribute 'mass' is left out: line 3: '' in column 'mass' is no number"}));
}

TEST(TableFile, ColumnsThatTheInputNamesMustBeNumbers) {
    const TemporaryFolder folder;
    writeFile(folder / "a.csv", "x,y,z,mass,a,b,c\n1,2,3,4,5,6,7\n4,5,6,,8,?,9\n");
    EXPECT_EQ(readParticles(folder / "a.csv").size(), 2U);
    ParticleInput input;
    input.where = "mass > 0";
    expectError([&] { readParticles(folder / "a.csv", input); }, {"a.csv: line 3: '' in column 'mass'"});
    for (const char* velocity : {"a,b,c", "a, b, c", "b"}) {
        input = {};
        input.velocity = velocity;
        expectError([&] { readParticles(folder / "a.csv", input); }, {"a.csv: line 3: '?' in column 'b'"});
    }
}

TEST(TableFile, NegativeIdsStayNegative) {
    Particles particles = sampleParticles(1, false, true, false);
    particles.id = {static_cast<std::uint64_t>(-3)};
    const Bytes bytes = tableOf(particles);
    EXPECT_NE(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find(",-3\n"), std::string::npos);
    EXPECT_EQ(parseTable({bytes, "a.csv"}).id, particles.id);
}

TEST(TableFile, ParticlesComeBackBitForBit) {
    for (const std::size_t n : {0U, 1U, 2U, 1000U})
        for (int mask = 0; mask < 8; ++mask) {
            SCOPED_TRACE(std::to_string(n) + " particles, mask " + std::to_string(mask));
            Particles particles = sampleParticles(n, mask & 1, mask & 2, mask & 4);
            if (!particles.id.empty()) particles.id.back() = 0xfedcba9876543210U;
            if (n > 1) particles.position[1] = {-0.0F, 1e-42F, 3e38F};
            const Bytes bytes = tableOf(particles);
            if (n == 0) particles.attributes.clear();
            expectSame(particlesFrom(parseTable({bytes, "a.csv"}), {}, "a.csv"), particles);
        }
}

TEST(TableFile, FloatsThatAreWholeNumbersStayFloats) {
    Particles particles = sampleParticles(2, false, false, false);
    particles.attributes = {{"whole", 1, {1, -3}, {}}, {"count", 1, {}, {7, -7}}};
    const Bytes bytes = tableOf(particles);
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_EQ(text.substr(0, text.find('\n')), "x,y,z,whole,\"count\"");
    EXPECT_NE(text.find(",-3.0,-7\n"), std::string::npos) << text;
    expectSame(particlesFrom(parseTable({bytes, "a.csv"}), {}, "a.csv").attributes, particles.attributes);
    particles.attributes = {{"vx", 1, {1, 2}, {}}};
    expectError([&] { tableOf(particles); }, {"a.csv", "'vx'", "in use"});
}

TEST(TableFile, NumbersThatAreTooLargeAreNamedWithTheirLine) {
    const FileContents contents = table("x,y,z,id,a.x,a.y,\"n\"\n\n1,2,3,-1,1,-1e39,1\n4,5,6,7,1e400,inf,9999999999\n");
    ASSERT_EQ(contents.lost_numbers.size(), 1U);
    EXPECT_EQ(contents.lost_numbers[0].attribute, "a");
    EXPECT_EQ(contents.lost_numbers[0].particle, 0U);
    EXPECT_EQ(describe(contents.lost_numbers[0]), "-1e+39 (line 3), which is too large for single precision");
    EXPECT_EQ(contents.declared.back().type, "int64");  // more than the 32 bits that are kept
    const FileContents huge = table("x,y,z,a\n1,2,3,-1e400\n");
    EXPECT_EQ(describe(huge.lost_numbers.at(0)), "beyond 1.8e308 (line 2), which is too large for single precision");
    const TemporaryFolder folder;
    write(folder / "a.csv", "x,y,z\n1,2,3\n4,1e39,6\n");
    for (const auto& read : {std::function([&] { readParticles(folder / "a.csv"); }),
                             std::function([&] { visitPositions(folder / "a.csv", [](auto) {}); })})
        expectError(read, {"a.csv: particle 1: position", "'y' is 1e+39 (line 3), which is too large", "drop"});
    ParticleInput dropping;
    dropping.on_bad_particle = OnBadParticle::drop;
    EXPECT_EQ(readParticles(folder / "a.csv", dropping).size(), 1U);
    for (const char* id : {"9223372036854775808", "-9223372036854775809", "99999999999999999999999"})
        expectError([&] { table("x,y,z,id\n1,2,3,4\n1,2,3," + std::string(id) + "\n1,2,3,4\n"); },
                    {"a.csv: line 3: ", id, "in column 'id'", "2^63 - 1"});
    EXPECT_EQ(table("x,y,z,key\n1,2,3,9223372036854775808\n").attributes.at(0).real, std::vector<float>{0x1p63F});
}

TEST(TableFile, IntegersThatBecomeFloatsBecauseTheyAreTooLargeAreNamedInAWarning) {
    const std::string large = "99999999999999999999999", first = std::to_string(UINT64_MAX);
    const FileContents contents =
        table("x,y,z,key,a.x,a.y\n1,2,3,4,5,6\n1,2,3," + first + ",7,8\n1,2,3," + large + ",9,-" + large + "\n");
    EXPECT_EQ(namesOf(contents), (std::vector<std::string>{"key/1", "a/2"}));
    EXPECT_EQ(contents.attributes.at(0).real, (std::vector<float>{4, 0x1p64F, 1e23F}));
    const std::string advice = ". Names in quotes, as in x,y,z,\"key\", mark columns of whole numbers";
    EXPECT_EQ(contents.warnings,
              (std::vector<std::string>{"attribute 'key' becomes floats of single precision: line 3: " + first +
                                            " in column 'key' needs more than 24 bits" + advice,
                                        "attribute 'a' becomes floats of single precision: line 4: -" + large +
                                            " in column 'a.y' needs more than 24 bits" + advice}));
    const TemporaryFolder folder;
    write(folder / "a.csv", "x,y,z,key\n1,2,3," + large + "\n");
    EXPECT_EQ(readSummarised(folder / "a.csv", {}).summary.warnings.size(), 1U);
    // Other columns are floats anyway.
    for (const char* row :
         {"{},2,3,4,5,6,7,8", "1,2,3,{},5,6,7,8", "1,2,3,4,5,6,{},0.5", "1,2,3,4,5,6,7,9223372036854775807"}) {
        std::string text = row;
        if (const std::size_t at = text.find("{}"); at != std::string::npos) text.replace(at, 2, large);
        for (const std::string& rows : {text + "\n1,2,3,4,5,6,1.5,8\n", "1,2,3,4,5,6,1.5,8\n" + text + '\n'})
            EXPECT_EQ(table("x,y,z,vx,vy,vz,b.x,b.y\n" + rows).warnings, std::vector<std::string>{}) << rows;
    }
}

TEST(TableFile, ErrorsNameTheLine) {
    expectError([] { table("x,y,z\n1,2,3\n4,5\n"); }, {"a.csv: line 3", "2 columns, expected 3"});
    expectError([] { table("x,y,z\n1,2,a\n"); }, {"line 2", "'a'", "column 'z'"});
    expectError([] { table("id,x,y,z\nfirst,1,2,3\n"); }, {"line 2", "'first'", "column 'id'"});
    expectError([] { table("x,y,z,v.x,v.y,v.z\n1,2,3,4,,6\n"); }, {"line 2", "''", "column 'v.y'"});
    expectError([] { table("1 2 3\n4 5 6 7\n"); }, {"a.csv: line 2", "4 columns, expected 3"});
    for (const char* rows : {"", "1,2\n", "1,2\n3,4\n\n5,6\n"}) {
        expectError([&] { table("# a comment\nx,y\n" + std::string(rows)); },
                    {"a.csv: line 2: no columns x, y and z", "'x', 'y'"});
        expectError([&] { table("\"a\nb\",y\n" + std::string(rows)); }, {"a.csv: line 1: no columns x, y and z"});
    }
    expectError([] { table("\n1,2\n3,4\n"); }, {"a.csv: line 2: no columns x, y and z"});
    expectError([] { table("# a comment\nx,y,z\n1,2,3\n4,5\n"); }, {"a.csv: line 4", "expected 3 as in line 2"});
    expectError([] { table("1,2\n1,2\n"); }, {"no columns x, y and z"});
    expectError([] { table("1.5\n2.5\n"); }, {"no columns x, y and z"});
    expectError([] { table(""); }, {"a.csv: 0 bytes", "expected"});
    expectError([] { table("3\nwater\nO 1 2 3\nH 4 5 6\n"); }, {"a.csv: has 2 rows", "expected 3"});
    expectError([] { table("3\n"); }, {"a.csv: has 0 rows", "expected 3"});
}

// A zlib stream that stores its bytes as they are.
std::string stored(const std::string& bytes) {
    std::uint32_t a = 1, b = 0;
    for (const char c : bytes) {
        a = (a + static_cast<unsigned char>(c)) % 65521;
        b = (b + a) % 65521;
    }
    const auto size = static_cast<std::uint16_t>(bytes.size());
    std::string stream = raw("\x78\x01\x01");
    for (const std::uint16_t number : {size, static_cast<std::uint16_t>(~size)})
        stream += {static_cast<char>(number & 0xff), static_cast<char>(number >> 8)};
    stream += bytes;
    for (const std::uint32_t number : {b >> 8, b & 0xff, a >> 8, a & 0xff}) stream += static_cast<char>(number);
    return stream;
}

struct Channel {
    std::string name;
    std::uint32_t type, arity, offset;
};

std::string prt(std::int64_t count, const std::vector<Channel>& channels, const std::string& rows) {
    std::string file = raw("\xc0PRT\r\n\x1a\n");
    const auto number = [&](auto value) { file.append(reinterpret_cast<const char*>(&value), sizeof value); };
    number(std::uint32_t{56});
    file += std::string("Extensible Particle Format") + std::string(6, '\0');
    number(std::uint32_t{1});
    number(count);
    number(std::uint32_t{4});
    number(static_cast<std::uint32_t>(channels.size()));
    number(std::uint32_t{44});
    for (const Channel& c : channels) {
        std::string name = c.name;
        name.resize(32);
        file += name;
        number(c.type);
        number(c.arity);
        number(c.offset);
    }
    return file + stored(rows);
}

template <typename T>
std::string numbers(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

TEST(PrtFile, ChannelsOfEveryType) {
    // A row: Position float32 x 3, ID int64, Density float16, Flags uint8 x 2, Mass float64.
    const std::vector<Channel> channels{
        {"Position", 4, 3, 0}, {"ID", 2, 1, 12}, {"Density", 3, 1, 20}, {"Flags", 10, 2, 22}, {"Mass", 5, 1, 24}};
    const auto row = [](float x, std::int64_t id, std::uint16_t half, double mass) {
        return numbers<float>({x, 2, 3}) + numbers<std::int64_t>({id}) + numbers<std::uint16_t>({half}) +
               numbers<std::uint8_t>({1, 200}) + numbers<double>({mass});
    };
    const Bytes bytes = bytesOf(prt(2, channels, row(1, 5000000000, 0x3e00, 2.5) + row(4, 6, 0xc000, -1)));
    const FileContents contents = parsePrt({bytes, "a.prt"});
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{1, 2, 3}, {4, 2, 3}}));
    EXPECT_EQ(contents.id, (std::vector<std::uint64_t>{5000000000, 6}));
    EXPECT_EQ(namesOf(contents), (std::vector<std::string>{"Density/1", "Flags/2", "Mass/1"}));
    EXPECT_EQ(contents.attributes[0].real, (std::vector<float>{1.5F, -2}));
    EXPECT_EQ(contents.attributes[1].integer, (std::vector<std::int32_t>{1, 200, 1, 200}));
    EXPECT_EQ(contents.attributes[2].real, (std::vector<float>{2.5F, -1}));
    EXPECT_TRUE(parsePrt({bytesOf(prt(0, channels, "")), "b.prt"}).position.empty());
}

TEST(PrtFile, ChannelsThatAreReadAreNotNamedAsUnused) {
    const TemporaryFolder folder;
    for (const std::string velocity : {"Velocity", "velocity", "VELOCITY"})
        for (const std::string id : {"ID", "id", "Id"}) {
            const std::vector<Channel> channels{
                {"Position", 4, 3, 0}, {velocity, 4, 3, 12}, {id, 1, 1, 24}, {"Density", 4, 1, 28}};
            writeFile(folder / "a.prt",
                      prt(1, channels,
                          numbers<float>({1, 2, 3, 4, 5, 6}) + numbers<std::int32_t>({7}) + numbers<float>({8})));
            const SummarisedParticles read = readSummarised(folder / "a.prt", {});
            EXPECT_EQ(read.particles.velocity, std::vector<Vec3f>{Vec3f(4, 5, 6)});
            EXPECT_EQ(read.particles.id, std::vector<std::uint64_t>{7});
            std::string uses;
            for (const InputPart& part : read.summary.parts) uses += part.name + ":" + part.use + " ";
            EXPECT_EQ(uses, "P:position velocity:velocity id:id Density: ");
        }
}

/// A PRT2 file of two particles with the channels Position and ID.
std::string prt2(const std::string& filter = "transpose-zlib", std::uint32_t particles = 2) {
    const auto text = [](const std::string& words) { return static_cast<char>(words.size()) + words; };
    const auto chunk = [](const std::string& kind, const std::string& data) {
        return kind + numbers<std::uint64_t>({data.size()}) + data;
    };
    const std::string rows[] = {numbers<float>({1, 2, 3}) + numbers<std::int64_t>({1LL << 40}),
                                numbers<float>({4, 5, 6}) + numbers<std::int64_t>({7})};
    std::string columns;
    for (std::size_t byte = 0; byte < rows[0].size(); ++byte)
        for (const std::string& row : rows) columns += row[byte];
    const std::string block = stored(columns);
    return raw("\xc0PRT2\r\n\x1a\3\0\0\0") +
           chunk("Chan", raw("\2") + text("Position") + text("3 * float32") + raw("\14") + text("ID") + text("int64") +
                             raw("\10")) +
           chunk("Meta", text("Unit") + text("float64") + std::string(8, '\1')) +
           chunk("Part", text("") + text(filter) + numbers<std::uint64_t>({2, 1}) +
                             numbers<std::uint32_t>({static_cast<std::uint32_t>(block.size()), particles}) + block);
}

TEST(PrtFile, ReadsTheChunksOfPrt2) {
    const Bytes bytes = bytesOf(prt2());
    const FileContents contents = parsePrt({bytes, "a.prt"});
    EXPECT_EQ(contents.position, (std::vector<Vec3f>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_EQ(contents.declared.size(), 2U);
    ReadOptions options;
    options.id = "ID";
    EXPECT_EQ(parsePrt({bytes, "a.prt"}, options).id, (std::vector<std::uint64_t>{1ULL << 40, 7}));
    const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
        const Bytes damaged = bytesOf(text);
        expectError([&] { parsePrt({damaged, "a.prt"}); }, words);
    };
    refused(prt2("lz4"), {"'lz4'", "transpose-zlib"});
    refused(prt2("transpose-zlib", 3), {"3 particles"});
    refused(prt2("transpose-zlib", 1), {"zlib"});
    refused(prt2().substr(0, 60), {"a.prt: byte", "ends"});
    refused(prt2().substr(0, prt2().find("Part")), {"a.prt", "chunk Part"});
}

TEST(PrtFile, ErrorsSayWhatIsWrong) {
    const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
        const Bytes bytes = bytesOf(text);
        expectError([&] { parsePrt({bytes, "a.prt"}); }, words);
    };
    const std::string row = numbers<float>({1, 2, 3});
    refused("ply", {"a.prt", "c0 PRT"});
    refused(prt(1, {{"Density", 4, 3, 0}}, row), {"no channel Position"});
    refused(prt(1, {{"Position", 99, 3, 0}}, row), {"'Position' has type 99"});
    refused(prt(1, {{"Position", 4, 3, 4}}, row), {"'Position' begins at byte 4"});
    refused(prt(2, {{"Position", 4, 3, 0}}, row), {"a.prt", "points"});
    refused(prt(-1, {{"Position", 4, 3, 0}}, row), {"-1", "not finished"});
}

TEST(PrtFile, RealFiles) {
    const std::filesystem::path folder = std::string(BETAMESH_SHARED) + "/data/formats";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real files beside the project";
    const FileContents fractal = parsePrt(openFile(folder / "thinkbox__prt_fractal_for_krscene.prt"));
    EXPECT_EQ(fractal.position.size(), 312U);
    EXPECT_EQ(namesOf(fractal), (std::vector<std::string>{"Color/3", "velocity/3", "Density/1"}));
    const FileContents transforms = parsePrt(openFile(folder / "thinkbox__transforms.prt"));
    EXPECT_EQ(transforms.format, "prt2 version 3");
    EXPECT_EQ(transforms.position.size(), 20U);
    EXPECT_EQ(namesOf(transforms), (std::vector<std::string>{"Color/3", "Normal/3", "Intensity/1", "ScannerIndex/1"}));
}

TEST(StlFile, HoldsEveryTriangleWithItsNormal) {
    Mesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 1}, {0, 3, 1}};
    const Bytes bytes = bytesOf([&](ByteWriter& out) { encodeStl(out, mesh, "a.stl"); });
    ASSERT_EQ(bytes.size(), 84 + 3 * 50U);
    std::uint32_t count = 0;
    std::memcpy(&count, &bytes[80], 4);
    EXPECT_EQ(count, 3U);
    std::array<float, 12> first{}, second{}, third{};
    std::memcpy(&first, &bytes[84], 48);
    std::memcpy(&second, &bytes[134], 48);
    std::memcpy(&third, &bytes[184], 48);
    EXPECT_EQ(first, (std::array<float, 12>{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}));
    EXPECT_EQ(second[2], -1);
    EXPECT_EQ(third[2], 0);  // without area
    EXPECT_NE(std::string(reinterpret_cast<const char*>(bytes.data()), 5), "solid");
}

TEST(TableFile, FileInfoNamesParticlesThatAreNotFinite) {
    const TemporaryFolder folder;
    writeFile(folder / "a.csv", "x,y,z,vx,vy,vz\n1,2,3,0,0,0\nnan,2,3,0,0,0\n3,4,5,0,inf,0\n5,6,7,0,0,0\n");
    std::vector<Vec3f> particles;
    const FileInfo info = inspectFile(folder / "a.csv", &particles);
    EXPECT_EQ(info.points, 4U);
    EXPECT_EQ(particles.size(), 2U);
    EXPECT_EQ(info.lower, Vec3f(1, 2, 3));
    EXPECT_EQ(info.upper, Vec3f(5, 6, 7));
    ASSERT_EQ(info.passed_over.size(), 1U);
    EXPECT_NE(info.passed_over[0].find("2 particles are left out"), std::string::npos) << info.passed_over[0];
}

}  // namespace
}  // namespace betamesh
