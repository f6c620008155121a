// k of a section inside the flow through its bed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/data_file.hpp"
#include "core/error.hpp"
#include "lbm/layers.hpp"
#include "lbm/permeability.hpp"
#include "openfoam/foam_field.hpp"
#include "support/known_flows.hpp"

using namespace porepack;
using namespace porepack::shapes;
using namespace porepack::packing;
using namespace porepack::vessels;
using namespace porepack::converters;
using namespace porepack::pore_space;
using namespace porepack::lbm;

namespace {

LbmConfig one_grid(long subsections = 1) {
    return {.iteration_tolerance = 1e-4, .grids = 1, .subsections = subsections};
}

}  // namespace

// The settled packing, 3.4 nodes per capsule diameter: the same voxels alone and in the flow through 130 mm.
TEST(InSitu, TheGradientIsTheDropOverTheLayers) {
    // Density 4, 3, 2, 1 in four layers of the same flow; the planes between them lie half-way: 3.5, 2.5, 1.5; zero on the end planes.
    const pore_space::Drive drive{.axis = 2, .periodic = {false, false, false}};
    Layers layers;
    for (const double density : {4.0, 3.0, 2.0, 1.0}) {
        layers.nodes.push_back(1.0);
        layers.flow.push_back(0.5);
        layers.power.push_back(0.5 * density);
        layers.density.push_back(density);
    }
    for (const auto pressure : {PlanePressure::flux_weighted, PlanePressure::mean}) {
        EXPECT_NEAR(gradient_between(0.0, drive, layers, 1, 2, pressure), (3.5 - 1.5) / (3.0 * 2.0), 1e-12);
        EXPECT_NEAR(gradient_between(0.1, drive, layers, 1, 1, pressure), 0.1 + (3.5 - 2.5) / 3.0, 1e-12);
        EXPECT_NEAR(gradient_between(0.1, drive, layers, 0, 3, pressure), 0.1, 1e-12);
    }
}

TEST(InSitu, ASliceAloneAgreesWithTheSliceInItsBed) {
    const double h = 1.5e-3, slice = 16.0 * h, z0 = 88.0 * h;
    const PoreSpace bed = pore_space_of(read_packing(data_file("cases") / "paper_packing" / "settled" / "tetrapod_053.json.gz"));
    const LbmResult whole = lbm_permeability(bed.with_section({z0, z0 + 2.0 * slice}).with_ends(Ends::in_situ, 0.04), h, one_grid(2));
    // 1.5 diameters of the sphere with the volume of a grain, 7.33e-7 m3.
    EXPECT_NEAR(bed.default_buffer_m(), 1.5 * 0.011187, 1e-5);
    double resistance = 0.0, largest_planes_error = 0.0;
    for (int i = 0; i < 2; ++i) {
        const PoreSpace part = bed.with_section({z0 + i * slice, z0 + (i + 1) * slice});
        const double expected = whole.subsections[static_cast<std::size_t>(i)].permeability_m2;
        const double k = lbm_permeability(part.with_ends(Ends::in_situ), h, one_grid()).permeability_m2;
        EXPECT_NEAR(k / expected, 1.0, 0.01) << "slice " << i;
        resistance += 0.5 / k;
        largest_planes_error =
            std::max(largest_planes_error, lbm_permeability(part.with_ends(Ends::planes), h, one_grid()).permeability_m2 / expected - 1.0);
    }
    EXPECT_NEAR(1.0 / resistance / whole.fine().permeability_volume_m2, 1.0, 0.005);
    EXPECT_GT(largest_planes_error, 0.03) << "planes of constant pressure cut grains: k is too high";
}

// One period, cut between the layers and through the spheres: the array's k; constant pressure on the planes gives more.
TEST(InSitu, APeriodOfAnArrayCutAnywhereHasItsPermeability) {
    const test::SphereDrag& drag = test::sphere_drags()[3];
    const test::KnownFlow array = test::three_layers(drag.solid_fraction, drag.simple_cubic);
    for (const double low : {1.75, 2.0, 2.2}) {
        const PoreSpace space = pore_space_of(array.packing).with_section({low, low + 1.0});
        EXPECT_NEAR(lbm_permeability(space.with_ends(Ends::in_situ), 1.0 / 28, one_grid()).permeability_m2 / array.permeability_m2, 1.0,
                    0.01)
            << low;
    }
}

// Water above and below a dense bed flows freely, and the pressure along the bed starts near its steady state: without both, the flow
// rates of the layers of this bed still differ by a factor of two after 240 steps. With both, the error is
// 1.8 % at 600 steps, and a run ends at the second check below the tolerance of 2 %.
TEST(InSitu, ADenseBedWithFreeEndsIsSteadySoon) {
    const PoreSpace bed = pore_space_of(read_packing(data_file("cases") / "paper_packing" / "settled" / "tetrapod_087.json.gz"));
    const PoreSpace whole = bed.with_section({0.03, 0.33}).with_ends(Ends::in_situ, 0.05);
    ASSERT_TRUE(whole.computes_whole_bed());
    const LbmConfig config{
        .precision = Precision::single_precision, .relaxation_time = 1.5, .iteration_tolerance = 0.02, .max_steps = 720, .grids = 1};
    EXPECT_NO_THROW((void)lbm_permeability(whole, 1.8e-3, config));
}

// The relaxation time that a program chooses is one at which walls in pores of a few nodes are stable (3.3 was not, in this bed).
TEST(InSitu, ChosenRelaxationTimesAreStable) {
    const PoreSpace bed = pore_space_of(read_packing(data_file("cases") / "paper_packing" / "settled" / "tetrapod_053.json.gz"));
    const LbmResult result = lbm_permeability(bed.with_section({0.15, 0.174}).with_ends(Ends::in_situ, 0.012), 1.2e-3,
                                              {.precision = Precision::single_precision, .iteration_tolerance = 1e-2, .grids = 2});
    for (const LbmGridResult& grid : result.grids) {
        EXPECT_TRUE(grid.run.converged);
        EXPECT_LE(grid.relaxation_time, 2.0);
    }
}

TEST(InSitu, BuffersEndWhereTheBedEnds) {
    const PoreSpace space = pore_space_of(test::three_layers(0.343, 15.39949).packing).with_section({2.0, 3.0});
    const PoreSpace in_situ = space.with_ends(Ends::in_situ, 0.25);
    EXPECT_EQ(in_situ.buffers_m, (std::array<double, 2>{0.25, 0.25}));
    EXPECT_FALSE(in_situ.computes_whole_bed());
    const PoreSpace whole = space.with_ends(Ends::in_situ, 5.0);
    EXPECT_NEAR(whole.computed().z0_m, space.bed_bottom_m, 1e-12);
    EXPECT_NEAR(whole.computed().z1_m, space.bed_top_m, 1e-12);
    EXPECT_TRUE(whole.computes_whole_bed());
    EXPECT_EQ(space.with_ends(Ends::planes).buffers_m, (std::array<double, 2>{0.0, 0.0}));
    // The grid has the section's planes on its layers.
    const Grid grid = whole.plan_at(0.05).grid;
    const double below = (2.0 - grid.origin_m[2]) / grid.spacing_m[2];
    EXPECT_NEAR(below, std::round(below), 1e-9);
    EXPECT_LE(grid.origin_m[2], space.bed_bottom_m + 1e-12);
}

TEST(InSitu, AnImageThatEndsAtTheSectionHasNothingToReachInto) {
    const PoreSpace exact = pore_space_of(test::three_layers(0.343, 15.39949).packing).with_section({1.8, 3.2});
    const auto image = [&](const Section& section) {
        return pore_space_of(exact.voxelise_at(0.05), exact.container, section, "an image").with_ends(Ends::in_situ);
    };
    EXPECT_EQ(image({1.8, 3.2}).ends, Ends::planes);
    const PoreSpace inner = image({2.3, 2.7});
    EXPECT_EQ(inner.ends, Ends::in_situ);
    EXPECT_NEAR(inner.buffers_m[0], 0.5, 1e-9);
    EXPECT_EQ(inner.voxelise_at(0.05).grid.cells[2], 28);
    EXPECT_EQ(inner.section_only().voxelise_at(0.05).grid.cells[2], 8);
}

// Pressure falls linearly with z; the flow is faster on one side: the weights must not move the plane.
TEST(InSitu, OpenFoamsPressureOnAPlaneIsExactForALine) {
    std::vector<openfoam::FoamCell> cells;
    for (int i = 0; i < 40; ++i)
        for (int j = 0; j < 3; ++j) {
            const double z = 0.01 * i + 0.003 * j;
            cells.push_back({{0.1 * j, 0.0, z}, {0.0, 0.0, 1.0 + 2.0 * z + j}, 5.0 - 7.0 * z, 1e-3 * (1 + i % 2)});
        }
    EXPECT_NEAR(openfoam::plane_pressure(cells, 0.2, 0.03), 5.0 - 7.0 * 0.2, 1e-12);
    EXPECT_THROW((void)openfoam::plane_pressure(cells, 2.0, 0.03), NumericalError);
}
