// Keys of configuration files and flags; digests.
#include <string>
#include <vector>

#include "core/context.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "record/config.hpp"
#include "record/digest.hpp"
#include "record/toml_file.hpp"
#include "support/basics.hpp"

namespace porepack {
using namespace record;
namespace {

using test::has;
using test::message_of;

struct Sample {
    double voxel_size_m = 1.0;
    long count = 3;
    std::string kind = "a";
    std::vector<double> pair;
};

void describe(ConfigVisitor& v, Sample& s) {
    v.number("voxel_size_m", s.voxel_size_m, positive(), "a length");
    v.integer("count", s.count, between(1, 10), "a number");
    v.word("kind", s.kind, {"tetrapod", "sphere"}, "a choice");
    v.numbers("pair", s.pair, {2, 2}, not_negative(), "two numbers");
}

Sample read(const std::string& toml, const Flags& flags = {}) {
    const test::Folder folder;
    const TomlFile file(folder.write("case.toml", toml));
    file.require_known_tables({"sample"});
    Sample sample;
    file.read(
        "sample", [&](ConfigVisitor& v) { describe(v, sample); }, flags);
    return sample;
}

TEST(Config, ReadsValuesAndKeepsDefaults) {
    const Sample sample = read("[sample]\nvoxel_size_m = 2e-4\npair = [0, 1.5]\n");
    EXPECT_EQ(sample.voxel_size_m, 2e-4);
    EXPECT_EQ(sample.count, 3);
    EXPECT_EQ(sample.pair, (std::vector<double>{0.0, 1.5}));
}

TEST(Config, FlagsWinOverTheFile) {
    const Sample sample = read("[sample]\nvoxel_size_m = 2e-4\n", {{"voxel_size_m", "3e-4"}, {"kind", "sphere"}, {"pair", "1,2"}});
    EXPECT_EQ(sample.voxel_size_m, 3e-4);
    EXPECT_EQ(sample.kind, "sphere");
    EXPECT_EQ(sample.pair, (std::vector<double>{1.0, 2.0}));
}

TEST(Config, NamesLineAndNearestKey) {
    const auto text = message_of<UserError>([] { (void)read("[sample]\n\nvoxel_sise_m = 1\n"); });
    EXPECT_TRUE(has(text, "unknown key `sample.voxel_sise_m`"));
    EXPECT_TRUE(has(text, "line 3"));
    EXPECT_TRUE(has(text, "perhaps `voxel_size_m`"));
}

TEST(Config, NamesTheMissingUnit) {
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\nvoxel_size = 1\n"); }), "the unit is missing: write `voxel_size_m`"));
}

TEST(Config, RefusesBadValues) {
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\nvoxel_size_m = -1\n"); }), "out of range: -1"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\nvoxel_size_m = 0\n"); }), "> 0"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\nvoxel_size_m = nan\n"); }), "out of range: nan"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\nvoxel_size_m = inf\n"); }), "out of range"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\nvoxel_size_m = \"x\"\n"); }), "is not a number"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\ncount = 2.5\n"); }), "not a whole number"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\nkind = \"tetrapot\"\n"); }), "perhaps \"tetrapod\""));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample]\npair = [1]\n"); }), "has 1 entries"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[simple]\n"); }), "perhaps [sample]"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("[sample\n"); }), "not valid TOML"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)read("", {{"voxel_size_m", "-2"}}); }), "--voxel-size"));
}

TEST(Toml, ValuesOnOneLine) {
    const Json value = {{"radius_m", 1e-3}, {"a_m", {0, 0.5, 1}}, {"name", "a \"b\"\n"}, {"open", true}};
    EXPECT_EQ(toml_text(value), R"({ "radius_m" = 0.001, "a_m" = [0, 0.5, 1], "name" = "a \"b\"\n", "open" = true })");
    const test::Folder folder;
    const Path file = folder.write("a.toml", "value = " + toml_text(value) + "\n");
    Json read;
    TomlFile(file).read("", [&](ConfigVisitor& v) { v.any("value", read, "", ""); });
    EXPECT_EQ(read["name"], value["name"]);
    EXPECT_EQ(read["a_m"][1], 0.5);
}

TEST(Files, DigestIsTheOneOfSha256sum) {
    EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

struct Renamed {
    double wire_m = 1.0;
    core::Axis axis = core::Axis::x;
};
void describe(ConfigVisitor& v, Renamed& c) {
    v.renamed("mesh_wire_m", "wire_m");
    v.number("wire_m", c.wire_m, positive(), "a wire");
    v.renamed_word("axis", "vertical", "z");
    v.choice("axis", c.axis, "an axis");
}

TEST(Config, ReadsAKeysOldNameWithAWarning) {
    const test::Folder folder;
    std::vector<std::string> lines;
    const Context run{.log = [&](LogLevel, std::string_view line) { lines.emplace_back(line); }, .progress = {}, .interrupted = {}};
    const ContextScope scope(run);
    const auto read = [&](const std::string& text) {
        Renamed config;
        TomlFile(folder.write("case.toml", text)).read("screen", [&](ConfigVisitor& v) { describe(v, config); });
        EXPECT_EQ(config.axis, text.find("vertical") == std::string::npos ? core::Axis::x : core::Axis::z);
        return config.wire_m;
    };
    EXPECT_EQ(read("[screen]\nmesh_wire_m = 0.5\n"), 0.5);
    EXPECT_TRUE(has(lines.at(0), "line 2: `screen.mesh_wire_m` is now called `wire_m`"));
    EXPECT_THROW((void)read("[screen]\nmesh_wire_m = 0.5\nwire_m = 0.4\n"), UserError);
    lines.clear();
    EXPECT_EQ(read("[screen]\naxis = \"vertical\"\n"), 1.0);
    EXPECT_TRUE(has(lines.at(0), "line 2: \"vertical\" of `screen.axis` is now called \"z\""));
}

}  // namespace
}  // namespace porepack
