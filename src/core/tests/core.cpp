// Memory, text for other programs, names and files, tables.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/json.hpp"
#include "core/owned_names.hpp"
#include "core/pages.hpp"
#include "core/table.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

using test::has;
using test::message_of;

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

TEST(Files, AFailedWriteLeavesNothing) {
    const test::Folder folder;
    const Path file = folder.path() / "out.txt";
    EXPECT_ANY_THROW(write_whole(file, [](const Path& name) {
        std::ofstream(name) << "half";
        throw MachineError("disk full");
    }));
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Table, WritesNumbersTextAndWhatIsNotKnown) {
    Table table({"name", "value_m", "count"});
    table.digits = 4;
    table.add("a, \"b\"", 1.23456, 123456);
    table.add("c", std::nan(""), 0);
    EXPECT_EQ(table.csv(), "name,value_m,count\n\"a, \"\"b\"\"\",1.235,123456\nc,,0\n");
    EXPECT_THROW(table.add("too few"), std::logic_error);
}

TEST(Table, IsReadBack) {
    const test::Folder folder;
    core::Table table({"a_m", "b"});
    table.add(1.5, std::optional<double>());
    table.add(-2e-7, 3);
    table.write(folder.path() / "t.csv");
    const auto rows = core::read_table(folder.path() / "t.csv");
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0][0], 1.5);
    EXPECT_TRUE(std::isnan(rows[0][1]));
    EXPECT_EQ(rows[1], (std::vector{-2e-7, 3.0}));
    EXPECT_THROW((void)core::read_table(folder.write("bad.csv", "a,b\n1,two\n")), core::UserError);
}

}  // namespace
}  // namespace porepack
