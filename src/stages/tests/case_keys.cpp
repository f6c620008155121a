// Keys of case.toml: old places, and those of [packings] that cannot be meant together.
#include <string>
#include <vector>

#include "core/context.hpp"
#include "core/error.hpp"
#include "stages/case.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

using test::has;

struct Refusal {
    const char *text, *message;
};

TEST(PackingsKeys, WhatCannotBeMeantIsRefused) {
    const test::Folder folder;
    const std::string head =
        "[shape]\nkind = \"sphere\"\ndiameter_m = 0.01\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.05\nheight_m = 0.2\n";
    for (const Refusal& one : {
             Refusal{"[packings]\nseeds = 8\nmeasured_porosity = [0.4, 0]\n", "`measured_porosity` is [0.4, 0]"},
             Refusal{"[packings]\nseeds = 8\nmeasured_porosity = [0.4]\n", "has 1 entries"},
             Refusal{"[packings]\nseeds = 4\nmeasured_porosity = [0.4, 0.01]\n", "needs 5 packings or more, not 4"},
             Refusal{"[packings]\nseeds = 8\nmeasured_porosity = [0.4, 0.01]\nmeasured_part = \"between\"\n", "needs `measured_between_m`"},
             Refusal{"[packings]\nseeds = 8\nmeasured_porosity = [0.4, 0.01]\nmeasured_between_m = [0.01, 0.02]\n",
                     "has no effect without"},
             Refusal{
                 "[packings]\nseeds = 8\nmeasured_porosity = [0.4, 0.01]\nmeasured_part = \"between\"\nmeasured_between_m = [0.02, 0.01]\n",
                 "are not in order"},
             Refusal{"[packings]\nseeds = 8\nmeasured_part = \"bed\"\n", "no effect without measured_porosity"},
             Refusal{"[packing]\nfriction_uncertainty = 0.1\n", "fixed number of 5 packings or more"},
             Refusal{"[packing]\nfriction_uncertainty = 0.1\n[packings]\nuntil_sure = 0.1\n", "fixed number of 5 packings or more"},
             Refusal{"[packing]\nfriction_uncertainty = 0.3\n[packings]\nseeds = 8\n", "would vary below 0"},
         }) {
        folder.write("case.toml", head + one.text);
        try {
            (void)stages::read_case(folder.path());
            FAIL() << one.text;
        } catch (const core::UserError& error) {
            EXPECT_NE(std::string(error.what()).find(one.message), std::string::npos) << error.what();
        }
    }
    folder.write("case.toml", head + "[packings]\nseeds = 8\nmeasured_porosity = [0.4, 0.01]\n[packing]\nfriction_uncertainty = 0.1\n");
    EXPECT_EQ(stages::read_case(folder.path()).settings.packings.measured_porosity.size(), 2U);
}

TEST(Config, ReadsAKeyFromItsOldTableWithAWarning) {
    const test::Folder folder;
    const std::string start =
        "[shape]\nkind = \"sphere\"\ndiameter_m = 0.01\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.1\nheight_m = 0.2\n";
    std::vector<std::string> lines;
    const Context run{.log = [&](LogLevel, std::string_view line) { lines.emplace_back(line); }, .progress = {}, .interrupted = {}};
    const ContextScope scope(run);
    const auto ends_of = [&](const std::string& text) {
        folder.write("case.toml", start + text);
        return stages::read_case(folder.path()).settings.section.ends;
    };
    EXPECT_EQ(ends_of(""), pore_space::Ends::in_situ);
    EXPECT_TRUE(lines.empty());
    EXPECT_EQ(ends_of("[lbm]\nends = \"pressure\"\n"), pore_space::Ends::planes);
    EXPECT_TRUE(has(lines.at(0), "`lbm.ends` is now `section.ends`")) << lines.at(0);
    EXPECT_EQ(ends_of("[lbm]\nends = \"paper\"\n"), pore_space::Ends::paper);
    EXPECT_THROW((void)ends_of("[lbm]\nends = \"paper\"\n[section]\nends = \"planes\"\n"), UserError);
    EXPECT_THROW((void)ends_of("[lbm]\nends = \"planar\"\n"), UserError);
}

}  // namespace
}  // namespace porepack
