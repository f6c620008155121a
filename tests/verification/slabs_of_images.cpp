// Each part of a flow keeps the layers of an image that it needs: the same permeability, to the last bit.
#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/gray_parts.hpp"
#include "core/communicator.hpp"
#include "lbm/grid_sizes.hpp"
#include "lbm/permeability.hpp"
#include "pore_space/closing.hpp"
#include "pore_space/gray_solid.hpp"
#include "scans/gray_input.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"
#include "support/simulated_scan.hpp"

namespace porepack {
namespace {

using namespace test;

constexpr double voxel = 0.05;

PoreSpace scan_of_bed(const std::string& container, const Section& section) {
    const Packing bed = random_bed(container, 30, 0.1);
    const GrayImage scan = simulated_scan(Grains(bed), bed.container, voxel, {.blur_voxels = 0.6, .noise = 0.02, .seed = 3});
    const scans::GrayInput input = scans::read_gray(
        scan_of(scan, 0.0, 1.0), {.threshold = imaging::ThresholdRule::volume, .gray_levels = {0.0, 1.0}}, bed.container, "scan");
    return pore_space_of(input.solid, bed.container, section, "scan");
}

PoreSpace image_of_bed(const std::string& container, const Section& section) {
    const PoreSpace bed = pore_space_of(random_bed(container, 30, 0.1));
    const Section whole = {0.0, bed.container.height()};
    return pore_space_of(bed.with_section(whole).voxelise_at(voxel), bed.container, section, "image");
}

struct Image {
    std::string name;
    PoreSpace space;
};

std::vector<Image> images() {
    const PoreSpace bed = pore_space_of(random_bed("cylinder:1,2", 30, 0.1)).with_section({0.3, 1.7});
    PoreSpace with_reservoir = closed(pore_space_of(random_bed("cylinder:1,2", 30, 0.1)).with_section({0.5, 1.5}), 0.02);
    with_reservoir.reservoir_m = 1.0;  // longer than a slab
    return {{"scan", scan_of_bed("cylinder:1,2", {0.2, 1.8})},
            {"scan in situ", scan_of_bed("cylinder:1,2", {0.7, 1.3}).with_ends(Ends::in_situ, 0.3)},
            {"periodic scan", scan_of_bed("box:1,1,1:periodic", {0.0, 1.0})},
            {"segmented", image_of_bed("cylinder:1,2", {0.2, 1.8})},
            {"segmented, periodic", image_of_bed("box:1,1,1:periodic", {0.0, 1.0})},
            {"menisci", closed(bed, 0.02)},
            {"menisci under a reservoir", with_reservoir}};
}

LbmResult permeability(PoreSpace space, double voxel_size_m, const LbmConfig& config, const Communicator& parts) {
    LbmRun run{.with_flow = true, .parts = &parts};
    std::optional<scans::GrayVariants> variants;
    analysis::keep_own_part(space, variants, run, voxel_size_m, config, space.porosity().value);
    LbmResult result = lbm_permeability(space, voxel_size_m, config, run);
    analysis::add_gray_parts(result, space, config, run, variants);
    return result;
}

TEST(SlabsOfImages, GiveThePermeabilityOfTheWhole) {
    for (const auto& [name, space] : images()) {
        LbmConfig config;
        config.iteration_tolerance = 1e-2;
        if (space.gray()) config.grids = 3;
        const LbmResult whole = permeability(space, voxel, config, no_communicator());
        const FlowImage flow = whole.flow.of_own();
        for (const int parts : name == "scan" ? std::vector{2, 3} : std::vector{2})
            run_parts(parts, [&](const Communicator& slabs) {
                const LbmResult found = permeability(space, voxel, config, slabs);
                const std::string where = name + ", slabs: " + std::to_string(parts);
                EXPECT_EQ(found.permeability_m2, whole.permeability_m2) << where;
                EXPECT_EQ(found.fine().run.steps, whole.fine().run.steps) << where;
                EXPECT_EQ(found.fine().wall_links, whole.fine().wall_links) << where;
                ASSERT_EQ(found.half_width.has_value(), whole.half_width.has_value()) << where;
                if (found.half_width) EXPECT_EQ(found.half_width->sum(), whole.half_width->sum()) << where;
                const FlowImage own = found.flow.of_own();
                const std::size_t area = flow.grid.index(0, 0, 1), first = static_cast<std::size_t>(found.flow.own[0]) * area;
                EXPECT_TRUE(std::equal(own.phase.begin(), own.phase.end(), flow.phase.begin() + static_cast<std::ptrdiff_t>(first)))
                    << where;
            });
    }
}

// The relaxation time is searched on a piece in the middle, which all parts keep.
TEST(SlabsOfImages, SearchOnTheSamePiece) {
    LbmConfig config;
    config.iteration_tolerance = 2e-2;
    config.grids = 2;
    config.fields = FieldFiles::none;
    const PoreSpace scan = scan_of_bed("cylinder:1,3", {0.1, 2.9});
    constexpr double fine = 0.0135;
    const LbmResult whole = permeability(scan, fine, config, no_communicator());
    ASSERT_GT(whole.grids.front().nodes, 200000U);
    run_parts(2, [&](const Communicator& slabs) {
        const LbmResult found = permeability(scan, fine, config, slabs);
        EXPECT_EQ(found.permeability_m2, whole.permeability_m2);
        EXPECT_EQ(found.grids.front().relaxation_time, whole.grids.front().relaxation_time);
        EXPECT_EQ(found.fine().run.steps, whole.fine().run.steps);
    });
}

// A periodic box whose sides are rounded to whole voxels.
TEST(SlabsOfImages, AreCutOnTheGridsThatAreSolved) {
    LbmConfig config;
    config.iteration_tolerance = 1e-2;
    config.fields = FieldFiles::none;
    const PoreSpace box = pore_space_of(random_bed("box:1,1.13,1.47:periodic", 20, 0.1));
    const LbmResult whole = permeability(box, 0.05, config, no_communicator());
    EXPECT_TRUE(whole.fine().stretch);
    run_parts(2,
              [&](const Communicator& slabs) { EXPECT_EQ(permeability(box, 0.05, config, slabs).permeability_m2, whole.permeability_m2); });
}

TEST(SlabsOfImages, KeepTheirOwnLayers) {
    LbmConfig config;
    config.grids = 1;
    const PoreSpace scan = scan_of_bed("cylinder:1,2", {0.0, 2.0}), segmented = image_of_bed("cylinder:1,2", {0.0, 2.0});
    run_parts(2, [&](const Communicator& parts) {
        const auto own = [&](const PoreSpace& space) {
            return space_of_part(space, voxel, config, slab_cuts(space, voxel, config, parts), space.porosity().value, parts);
        };
        const PoreSpace part = own(scan);
        EXPECT_LT(static_cast<double>(part.gray()->image()->packed.size()), 0.8 * static_cast<double>(scan.gray()->image()->packed.size()));
        EXPECT_EQ(part.kept_m.size(), 1U);
        const PoreSpace half = own(segmented);
        EXPECT_THROW((void)half.phases_on(*half.own_grid()), std::logic_error);
        EXPECT_EQ(half.own_grid()->cells[2], segmented.own_grid()->cells[2]);
    });
}

}  // namespace
}  // namespace porepack
