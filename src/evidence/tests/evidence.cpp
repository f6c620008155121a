// Verdicts from stored rows, and tables that are refused.
#include "evidence/evidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "support/basics.hpp"

namespace porepack::evidence {
namespace {

using core::Path;
using test::Folder;
using test::has;
using test::message_of;

const char* const published_columns = "item,value,standard_uncertainty,unit,source\n";
const char* const ours_columns = "item,value,low,high,command,date,version\n";

class Evidence : public testing::Test {
protected:
    void write(const std::string& name, const std::string& text) {
        std::filesystem::create_directories(folder.path() / "beds");
        core::write_text(folder.path() / "beds" / name, text);
    }
    void write_subject(const std::string& published, const std::string& ours) {
        write("README.md", "# Beds of others\n");
        write("published.csv", published_columns + published);
        write("ours.csv", ours_columns + ours);
    }
    std::string refusal() {
        return message_of<core::UserError>([&] { (void)read_evidence(folder.path()); });
    }
    Folder folder;
};

TEST(EvidenceVerdict, NeedsBothUncertainties) {
    const Published published{.item = "porosity", .value = 0.4, .standard_uncertainty = 0.01, .unit = "1", .source = ""};
    const auto verdict = [&](double value, double half_width) {
        return verdict_of(published, Ours{.item = "porosity", .value = value, .interval = {value - half_width, value + half_width}});
    };
    EXPECT_EQ(verdict(0.419, 0.0), Verdict::agrees);
    EXPECT_EQ(verdict(0.421, 0.0), Verdict::disagrees);
    EXPECT_EQ(verdict(0.421, 0.02), Verdict::agrees);  // 2 sqrt(0.01^2 + 0.01^2)
    EXPECT_EQ(verdict(0.43, 0.02), Verdict::disagrees);
    EXPECT_EQ(verdict(0.372, 0.02), Verdict::agrees);
    EXPECT_EQ(verdict_of(published, std::nullopt), Verdict::none);
}

TEST(EvidenceVerdict, IsNoneForUncertainSources) {
    Published published{.item = "k", .value = 1.0, .standard_uncertainty = 0.151, .unit = "m2", .source = ""};
    const Ours ours{.item = "k", .value = 1.0, .interval = {0.9, 1.1}};
    EXPECT_EQ(verdict_of(published, ours), Verdict::none);
    published.standard_uncertainty = 0.15;
    EXPECT_EQ(verdict_of(published, ours), Verdict::agrees);
    published.standard_uncertainty = std::nullopt;
    EXPECT_EQ(verdict_of(published, ours), Verdict::none);
}

TEST_F(Evidence, IsReadWithItsControls) {
    write_subject("\"K, c 0.4\",2,0.1,1,somebody\nk,3,,m2,nobody\n", "\"K, c 0.4\",2.1,2.0,2.2,porepack lbm,2026-01-01,0.3\n");
    write("control.csv", std::string("change,") + ours_columns + "friction 0.1,\"K, c 0.4\",2.9,2.8,3.0,porepack lbm,2026-01-01,0.3\n");
    const std::vector<Subject> subjects = read_evidence(folder.path());
    ASSERT_EQ(subjects.size(), 1U);
    EXPECT_EQ(subjects[0].title, "Beds of others");
    EXPECT_EQ(subjects[0].count(Verdict::agrees), 1);
    EXPECT_EQ(subjects[0].count(Verdict::none), 1);
    EXPECT_NEAR(subjects[0].rows[0].difference().value_or(0.0), 0.05, 1e-12);
    EXPECT_TRUE(subjects[0].control_disagrees());
    const std::string table = table_of(subjects);
    EXPECT_TRUE(has(table, "| K, c 0.4 | 2 (u 5 %) | 2.1 (2 to 2.2) | +5.0 % | agrees |")) << table;
    EXPECT_TRUE(has(table, "| k | 3 m2 | not computed |  | no verdict |")) << table;
    EXPECT_TRUE(has(table, "*control, friction 0.1*: K, c 0.4")) << table;
}

TEST_F(Evidence, GivesNoVerdictWhereAControlAgrees) {
    write_subject("k,2,0.1,m2,somebody\n", "k,2.1,2.0,2.2,porepack lbm,2026-01-01,0.3\n");
    write("control.csv", std::string("change,") + ours_columns + "friction 0.1,k,2.15,2.0,2.3,porepack lbm,2026-01-01,0.3\n");
    const std::vector<Subject> subjects = read_evidence(folder.path());
    EXPECT_EQ(subjects[0].count(Verdict::none), 1);
    EXPECT_FALSE(subjects[0].control_disagrees());
}

TEST_F(Evidence, RefusesRowsThatNobodyPublished) {
    write_subject("k,3,0.1,m2,somebody\n", "K,2.1,2.0,2.2,porepack lbm,2026-01-01,0.3\n");
    EXPECT_TRUE(has(refusal(), "`K` is not in published.csv"));
}

TEST_F(Evidence, RefusesWhatIsWrong) {
    write_subject("k,3,0.1,m2,somebody\nk,3,0.1,m2,somebody\n", "");
    EXPECT_TRUE(has(refusal(), "`k` stands twice"));
    write_subject("k,3,0.1,m2,somebody\n", "k,2.1,2.2,2.4,porepack lbm,2026-01-01,0.3\n");
    EXPECT_TRUE(has(refusal(), "does not hold its value"));
    write_subject("k,three,0.1,m2,somebody\n", "");
    EXPECT_TRUE(has(refusal(), "`value` of `k` is not a number"));
    write_subject("k,3,-0.1,m2,somebody\n", "");
    EXPECT_TRUE(has(refusal(), "above 0"));
    write("published.csv", "item,value\nk,3\n");
    EXPECT_TRUE(has(refusal(), "the columns are others"));
}

// The stored rows of the project itself.
TEST(EvidenceOfTheProject, HasAPageOfItsRowsAndControlsThatDisagree) {
    const Path folder = Path(POREPACK_SOURCE_FOLDER) / "evidence";
    const std::vector<Subject> subjects = read_evidence(folder);
    EXPECT_GE(subjects.size(), 6U);
    const std::string page = core::read_text(folder / "README.md"), table = table_of(subjects);
    EXPECT_TRUE(page.ends_with(table)) << "porepack evidence evidence --page";
    for (const Subject& subject : subjects) {
        const bool judged = std::ranges::any_of(subject.rows, [](const Row& row) { return row.verdict() != Verdict::none; });
        EXPECT_EQ(subject.control_disagrees(), judged) << subject.name;
        EXPECT_EQ(subject.controls.empty(), !judged) << subject.name;
        for (const Row& row : subject.rows) {
            if (!row.ours) continue;  // listed as not computed
            EXPECT_FALSE(row.ours->command.empty() || row.ours->date.empty() || row.ours->version.empty()) << row.published.item;
            EXPECT_FALSE(row.published.source.empty()) << row.published.item;
        }
    }
}

}  // namespace
}  // namespace porepack::evidence
