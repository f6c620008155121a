// Names are text wherever they are written, and what users have in a folder stays.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "core/json.hpp"
#include "support/cases.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;
namespace fs = std::filesystem;

// What is a command, markup or the end of a text in one of the languages that names are written into. Each would make the file `made`.
const std::vector<std::string> hostile = {"`touch made`",
                                          "'; system('touch made') #",
                                          "\"; system(\"touch made\") #",
                                          "a\nsystem(\"touch made\")\n#",
                                          "$(touch made)",
                                          "< touch made; cat f",
                                          "| touch made",
                                          "../../made",
                                          "\" onerror=\"made()\"><script>made()</script>",
                                          "]](x) <img src=x onerror=made()> | cell",
                                          std::string("nul\x01 bell\x07 escape\x1b[31m"),
                                          "right to left \u202e made",
                                          "@made &made {/Symbol made}"};

std::string toml(const std::string& text) {
    return Json(text).dump();
}

void expect_nothing_made(const Path& folder, const std::string& what) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) EXPECT_NE(entry.path().filename(), "made") << what;
    EXPECT_FALSE(fs::exists(folder.parent_path() / "made")) << what;
}

// No attribute, element or direction of a stranger.
void expect_plain_page(const Path& page, const std::string& what) {
    const std::string text = read_text(page);
    for (const char* markup : {"<img src=x", "\u202e", "\x1b"}) EXPECT_FALSE(has(text, markup)) << what << markup;
    // The page has one script, its own.
    std::size_t scripts = 0;
    for (std::size_t at = 0; (at = text.find("<script", at)) != std::string::npos; ++at, ++scripts)
        EXPECT_TRUE(text.substr(at).starts_with("<script>\"use strict\";")) << what;
    EXPECT_LE(scripts, 1U) << what;
    // In the text of an element it is text; within a tag, it is an attribute.
    for (std::size_t at = 0; (at = text.find("\" onerror", at)) != std::string::npos; ++at)
        EXPECT_EQ(text.find_last_of("<>", at), text.rfind('>', at)) << what;
}

std::string row(const std::string& point, double x, double y) {
    return fmt::format("{},no,old,{},{}\n", point, x, y);
}

TEST(Names, OfAStudyAreText) {
    for (const std::string& text : hostile) {
        const test::Folder folder;
        folder.write("case.toml", test::small_case);
        folder.write("study.csv", "point,current,digest,porosity,permeability_m2\n" + row("1", 0.4, 1e-8) + row("2", 0.5, 2e-8));
        const std::string axis = "[[axis]]\nkey = \"packing.seed\"\nvalues = [1, 2]\n", t = toml(text);
        folder.write("study.toml", axis + "[[column]]\nname = " + t + "\nformula = \"2*porosity\"\n[[fit]]\nname = " + t +
                                       "\nx = \"porosity\"\ny = \"permeability_m2\"\nform = \"given\"\nformula = \"x\"\n" +
                                       "[[figure]]\nname = \"plain\"\nx = \"porosity\"\ny = \"permeability_m2\"\nfits = [" + t +
                                       "]\ncurves = [{ title = " + t + ", formula = \"1e-7*x\" }]\nmarks = [{ title = " + t +
                                       ", x = 0.45, y = 2e-8 }]\n");
        const auto output = porepack("study plot --stale " + quoted(folder.path()));
        EXPECT_EQ(output.exit_code, 0) << text << output.err;
        expect_nothing_made(folder.path(), text);
        expect_plain_page(folder.path() / "study.html", text);
        EXPECT_TRUE(fs::exists(folder.path() / "figures" / "plain.svg"));
        EXPECT_FALSE(has(read_text(folder.path() / "figures" / "plain.svg"), "<script")) << text;
        // The name of a figure is that of a file.
        folder.write("study.toml", axis + "[[figure]]\nname = " + t + "\nx = \"porosity\"\ny = \"permeability_m2\"\n");
        const auto refused = porepack("study plot --stale " + quoted(folder.path()));
        EXPECT_EQ(refused.exit_code, 2) << text;
        EXPECT_TRUE(has(refused.err, "not a plain file name")) << refused.err;
        EXPECT_FALSE(has(refused.err, "\x1b")) << text;
        expect_nothing_made(folder.path(), text);
    }
}

TEST(Names, OfQuantitiesAndPlacesAreText) {
    for (const std::string& text : hostile) {
        const test::Folder folder;
        const Json result = {{"quantities",
                              {{{"name", text}, {"unit", text}, {"value", 1.0}, {"uncertainty", {{"interval", {0.9, 1.1}}}}},
                               {{"name", "b"}, {"unit", "1"}, {"value", 2.0}, {"uncertainty", {{"interval", nullptr}}}}}}};
        folder.write("r/result.json", result.dump());
        const auto output = porepack("compare " + quoted(folder.path() / "r") + " --output " + quoted(folder.path() / "o"));
        EXPECT_EQ(output.exit_code, 0) << text << output.err;
        EXPECT_FALSE(has(output.out, "\x1b")) << text;
        EXPECT_TRUE(fs::exists(folder.path() / "o" / "compare.svg")) << text;
        EXPECT_FALSE(has(read_text(folder.path() / "o" / "compare.svg"), "<script")) << text;
        expect_nothing_made(folder.path(), text);
    }
}

TEST(Names, OfPointsArePlainFolders) {
    const test::Folder folder;
    folder.write("case.toml", test::small_case);
    std::string values;
    for (const std::string& text : hostile) values += toml(text + std::to_string(values.size())) + ", ";
    folder.write("study.toml",
                 "[[axis]]\nkey = \"report.title\"\nvalues = [" + values + "]\n[[axis]]\nkey = \"packing.seed\"\nvalues = [1]\n");
    const auto output = porepack("study status " + quoted(folder.path()) + " --json");
    ASSERT_EQ(output.exit_code, 0) << output.err;
    for (const Json& point : Json::parse(output.out)) {
        const auto name = point.at("point").get<std::string>();
        EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+."), std::string::npos) << name;
        EXPECT_FALSE(name.starts_with('.') || name.starts_with('-')) << name;
    }
}

// What a user has in the folder of the results: refused before anything runs, in the dry run too.
TEST(FilesOfUsers, StayInTheFolderOfResults) {
    for (const char* name : {"shape/mine.txt", "shape", "pack.failed/mine.txt", "report.html", "result.json", "report/mine.txt"}) {
        const test::Folder folder;
        folder.write("c/case.toml", test::small_case);
        folder.write(std::string("o/") + name, "mine");
        for (const char* dry : {" --dry-run", ""}) {
            const auto output = porepack("run " + quoted(folder.path() / "c") + " --output " + quoted(folder.path() / "o") + dry);
            EXPECT_EQ(output.exit_code, 2) << name << output.err;
            EXPECT_TRUE(has(output.err, "is in the way and was not written by porepack")) << output.err;
            EXPECT_EQ(read_text(folder.path() / "o" / name), "mine");
        }
    }
}

TEST(FilesOfUsers, StayBesideLooseResults) {
    const test::Folder folder;
    folder.write("case.toml", test::small_case);
    const std::string shape = "shape tetrapod --sphericity 0.53 --volume 7.33e-7 --output " + quoted(folder.path() / "o");
    ASSERT_EQ(porepack(shape).exit_code, 0);
    ASSERT_EQ(porepack(shape).exit_code, 0) << "its own files are replaced";
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder.path() / "o"))
        if (entry.is_regular_file() && entry.path().filename() != ".porepack") names.push_back(entry.path().filename().string());
    ASSERT_GE(names.size(), 2U);
    for (const std::string& name : names) {
        fs::remove_all(folder.path() / "o");
        folder.write("o/" + name, "mine");
        const auto output = porepack(shape);
        EXPECT_EQ(output.exit_code, 2) << name;
        EXPECT_TRUE(has(output.err, "in the way")) << output.err;
        EXPECT_EQ(read_text(folder.path() / "o" / name), "mine") << name;
    }
}

TEST(FilesOfUsers, StayInStudiesAndComparisons) {
    const test::Folder folder;
    folder.write("case.toml", test::small_case);
    folder.write("study.csv", "point,current,digest,porosity,permeability_m2\n" + row("1", 0.4, 1e-8) + row("2", 0.5, 2e-8));
    folder.write(
        "study.toml",
        "[[axis]]\nkey = \"packing.seed\"\nvalues = [1, 2]\n[[figure]]\nname = \"f\"\nx = \"porosity\"\ny = \"permeability_m2\"\n");
    const auto stays = [&](const std::string& name, const std::string& call) {
        folder.write(name, "mine");
        const auto output = porepack(call);
        EXPECT_EQ(output.exit_code, 2) << name << output.err;
        EXPECT_EQ(read_text(folder.path() / name), "mine") << name;
        fs::remove(folder.path() / name);
        EXPECT_EQ(porepack(call).exit_code, 0) << name;
    };
    const std::string study = quoted(folder.path());
    stays("figures/f.png", "study plot --stale " + study);
    fs::remove_all(folder.path() / "figures");
    stays("Snakefile", "study export --snakemake " + study);
    folder.write("r/result.json", R"({"quantities": [{"name": "a", "unit": "1", "value": 1.0, "uncertainty": {"interval": [0.9, 1.1]}}]})");
    stays("o/compare.csv", "compare " + quoted(folder.path() / "r") + " --output " + quoted(folder.path() / "o"));
}

// The points of a study lie deeper than the case, whose image is named relative to it; CLI11 alone lets NaN pass.
TEST(Numbers, WithoutMeaningAreRefused) {
    const test::Folder folder;
    folder.write("case.toml", test::small_case);
    folder.write("study.toml", "[[axis]]\nkey = \"packing.seed\"\nvalues = [1, 2]\n");
    const std::string study = quoted(folder.path()), design = "design --container cylinder:0.1,0.4 --dry-run --permeability ";
    for (const std::string number : {"nan", "inf", "-inf"}) {
        for (const std::string& call :
             {"study run " + study + " --max-time " + number, design + number, design + "1e-7 --porosity 0.3," + number,
              design + "1e-7 --thinnest " + number, "run " + study + " --until-sure " + number + " --dry-run"}) {
            const auto output = porepack(call);
            EXPECT_EQ(output.exit_code, 2) << call << output.out;
            EXPECT_TRUE(has(output.err, number)) << call << output.err;
        }
    }
}

}  // namespace
}  // namespace porepack
