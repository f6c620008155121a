// What the documents state is what the program gives: the keys of case.toml, and the numbers in the READMEs of the cases (expected.json
// beside a case.toml lists them, with their place in result.json).
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/json.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::quoted;

std::vector<Path> cases_with_expected_numbers() {
    std::vector<Path> folders;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(Path(POREPACK_SOURCE_FOLDER) / "cases"))
        if (entry.path().filename() == "expected.json") folders.push_back(entry.path().parent_path());
    return folders;
}

TEST(Documents, StateKeysAndNumbers) {
    const std::string keys = test::porepack("keys").out, page = read_text(Path(POREPACK_SOURCE_FOLDER) / "docs/case-keys.md");
    EXPECT_GT(keys.size(), 10000U);
    EXPECT_TRUE(page.ends_with(keys)) << "docs/case-keys.md is old: porepack keys writes its tables";
    const auto folders = cases_with_expected_numbers();
    EXPECT_GE(folders.size(), 3U);
    for (const Path& folder : folders) {
        const Json expected = read_json(folder / "expected.json");
        std::string text;
        for (const Json& file : expected.at("text_in")) text += read_text(folder / file.get<std::string>());
        for (const Json& number : expected.at("numbers"))
            EXPECT_NE(text.find(number.at("text").get<std::string>()), std::string::npos) << folder << " " << number.dump();
    }
}

TEST(DocumentsLong, NumbersComeOut) {
    REQUIRE_PROGRAM("simpleFoam");
    for (const Path& source : cases_with_expected_numbers()) {
        const test::Folder folder;
        const auto run = test::porepack("run --json " + quoted(source) + " --output " + quoted(folder.path() / "results"));
        ASSERT_EQ(run.exit_code, 0) << run.err;
        const Json result = run.json();
        const Json expected = read_json(source / "expected.json");
        for (const Json& number : expected.at("numbers")) {
            const double stated = std::stod(number.at("text").get<std::string>());
            const double found =
                number.value("scale", 1.0) * result.at(Json::json_pointer(number.at("at").get<std::string>())).get<double>();
            EXPECT_LT(std::abs(found / stated - 1.0), number.at("tolerance").get<double>())
                << source << " " << number.dump() << ": " << found;
        }
    }
}

}  // namespace
}  // namespace porepack
