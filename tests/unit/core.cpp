#include <cmath>

#include "core/escape.hpp"
#include "core/owned_names.hpp"
#include "core/pages.hpp"
#include "core/table.hpp"
#include "pipeline/manifest.hpp"
#include "record/digest.hpp"
#include "record/toml_file.hpp"
#include "support/helpers.hpp"

namespace porepack {
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

TEST(Pages, AreZeroUntilWrittenAndAgainWhenReleased) {
    for (const std::size_t size : {std::size_t{10}, std::size_t{3000000}}) {
        core::Pages<double> pages(size);
        ASSERT_EQ(pages.size(), size);
        for (std::size_t i = 0; i < size; ++i) {
            ASSERT_EQ(pages[i], 0.0);
            pages[i] = 1.0;
        }
        pages.release(size / 3, 2 * size / 3);
        double kept = 0.0;
        for (std::size_t i = 0; i < size; ++i) {
            if (i < size / 3 || i >= 2 * size / 3) ASSERT_EQ(pages[i], 1.0) << "outside of what was released";
            kept += pages[i];
        }
        EXPECT_LE(kept, 2.0 * static_cast<double>(size) / 3.0 + 2.0 * 512.0 + 1.0) << "whole pages are given back";
        core::Pages<double> other = std::move(pages);
        EXPECT_EQ(other[0], 1.0);
        EXPECT_EQ(pages.data(), nullptr);  // NOLINT(bugprone-use-after-move)
    }
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

TEST(Escape, TextIsTextInEachLanguage) {
    const std::string text = "a'b\n\x1b[0m \u202e<\"&|";
    EXPECT_EQ(for_terminal(text), "a'b\n\\x1b[0m \\u202e<\"&|");
    EXPECT_EQ(for_gnuplot(text), "'a’b \\x1b[0m \\u202e<\"&|'");
    EXPECT_EQ(for_html(text), "a&#39;b\n\\x1b[0m \\u202e&lt;&quot;&amp;|");
    EXPECT_EQ(for_markdown("a|<b>\n[c](d)"), "a\\|\\<b> \\[c\\](d)");
    EXPECT_EQ(for_shell("plain/name-1.txt"), "plain/name-1.txt");
    EXPECT_EQ(for_shell("it's $(x)"), "'it'\\''s $(x)'");
    EXPECT_EQ(for_terminal("porosité, 10⁻⁶ m², ε"), "porosité, 10⁻⁶ m², ε");
    for (const char* name : {"a", "_1", "tetrapod_0.53", "a-b+c"}) {
        EXPECT_TRUE(is_plain_name(name)) << name;
    }
    for (const char* name : {"", ".", "..", ".a", "-e", "a/b", "a b", "a\n", "é"}) EXPECT_FALSE(is_plain_name(name)) << name;
    for (const char* name : {"", "..", "-5", "a/../b", "é"}) EXPECT_TRUE(is_plain_name(as_plain_name(name))) << name;
}

TEST(OwnedNames, OnlyWhatPorepackHasWrittenIsReplaced) {
    const test::Folder folder;
    folder.write("mine.csv", "mine");
    folder.write("their.manifest.json", R"({"format": "another", "outputs_sha256": {"mine.csv": ""}})");
    EXPECT_TRUE(has(message_of<UserError>([&] { OwnedNames(folder.path()).require("mine.csv"); }), "is in the way"));
    OwnedNames(folder.path()).require("new.csv");
    OwnedNames(folder.path()).add({"new.csv"});
    folder.write("new.csv", "own");
    OwnedNames(folder.path()).require("new.csv");
    EXPECT_TRUE(has(message_of<UserError>([&] { OwnedNames(folder.path()).require("mine.csv"); }), "is in the way"));
    folder.write("lbm.manifest.json", R"({"format": "porepack-manifest", "outputs_sha256": {"flow.vti": ""}})");
    folder.write("flow.vti", "own, of a version without the list");
    OwnedNames(folder.path()).require("flow.vti");

    EXPECT_FALSE(is_own(folder.path()));
    folder.write("a/b.txt", "mine");
    EXPECT_TRUE(has(message_of<UserError>([&] { require_own(folder.path() / "a"); }), "is in the way"));
    mark_as_own(folder.path() / "a");
    require_own(folder.path() / "a");
    require_own(folder.path() / "none");

    write_own_text(folder.path() / "t", "# Written by `x`: one\n");
    write_own_text(folder.path() / "t", "# Written by `x`: two\n");
    EXPECT_TRUE(has(message_of<UserError>([&] { write_own_text(folder.path() / "mine.csv", "# Written by `x`: one\n"); }), "in the way"));
}

TEST(Files, AKeyTwiceInJsonIsRefused) {
    EXPECT_EQ(parse_json(R"({"a": {"b": 1}, "c": [{"b": 2}]})", "x")["c"][0]["b"], 2);
    EXPECT_TRUE(
        has(message_of<UserError>([] { (void)parse_json(R"({"a": 1, "b": {"c": 1, "c": 2}})", "x.json"); }), "\"c\" is there twice"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)parse_json("{\n\"a\" 1}", "x.json"); }), "line 2"));
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

TEST(Files, AFailedWriteLeavesNothing) {
    const test::Folder folder;
    const Path file = folder.path() / "out.txt";
    EXPECT_ANY_THROW(write_whole(file, [](const Path& name) {
        std::ofstream(name) << "half";
        throw MachineError("disk full");
    }));
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Manifest, KnowsDoneStaleAndOfAnotherResultVersion) {
    const test::Folder folder;
    Manifest manifest{.stage = "lbm", .configuration = {{"a", 1}}, .inputs = {{"packing.json", "x"}}};
    EXPECT_EQ(state_of(folder.path(), manifest), StageState::missing);
    folder.write("k.txt", "1");
    folder.write("result.json", "{}");
    manifest.outputs["k.txt"] = sha256("1");
    write_json(folder.path() / "manifest.json", to_json(manifest));
    EXPECT_EQ(state_of(folder.path(), manifest), StageState::stale);  // the result beside it could be forged
    manifest.outputs["result.json"] = sha256("{}");
    write_json(folder.path() / "manifest.json", to_json(manifest));
    EXPECT_EQ(state_of(folder.path(), manifest), StageState::done);
    std::string why;
    Manifest changed = manifest;
    changed.inputs["packing.json"] = "y";
    EXPECT_EQ(state_of(folder.path(), changed, &why), StageState::stale);
    EXPECT_EQ(why, "input changed: packing.json");
    folder.write("k.txt", "2");
    EXPECT_EQ(state_of(folder.path(), manifest, &why), StageState::stale);
    EXPECT_EQ(why, "output changed or missing: k.txt");
    Json old = to_json(manifest);
    folder.write("k.txt", "1");
    old["program_version"] = "0.0.1";  // a new version alone does not make a stage stale
    write_json(folder.path() / "manifest.json", old);
    EXPECT_EQ(state_of(folder.path(), manifest, &why), StageState::done);
    Manifest newer = manifest;
    newer.result_version = 2;
    EXPECT_EQ(state_of(folder.path(), newer, &why), StageState::stale);
    EXPECT_TRUE(has(why, "result version 1, this porepack computes version 2"));
}

}  // namespace
}  // namespace porepack
