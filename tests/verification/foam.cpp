// OpenFOAM on cases with exact answers. Reported as skipped where it is not installed.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "lbm/permeability.hpp"
#include "openfoam/foam.hpp"
#include "openfoam/foam_field.hpp"
#include "packing/grains.hpp"
#include "support/helpers.hpp"
#include "support/vessel_meshes.hpp"
#include "vessels/config.hpp"
#include "vessels/mesh.hpp"

namespace porepack {
namespace {

const Path cases = Path(POREPACK_SOURCE_FOLDER) / "openfoam_cases";

// A square duct needs no grain in it, but the case requires a surface: a bead far above the section.
FoamScene duct() {
    Packing packing{
        .container = parse_container("box:0.01,0.01,0.1"), .shapes = {make_preset(ShapeKind::sphere, 0.002, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.005, 0.005, 0.08)});
    const Section section{0.01, 0.02};
    return {.surface = make_surface(packing, {}).surface,
            .container = packing.container,
            .section = section,
            .pore_volume_m3 = 1e-6,
            .grain_size_m = 0.002,
            .pore_point = Vec3(0.00501, 0.00502, 0.01503)};
}

TEST(FoamDuct, IsOfSecondOrder) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    double error[3];
    int i = 0;
    for (const int cells : {6, 12, 24}) {
        const FoamResult result = foam_permeability(duct(), {.meshes = 1, .residual = 1e-6, .max_iterations = 400}, 0.01 / cells, cases,
                                                    folder.path() / std::to_string(cells));
        error[i++] = result.fine().permeability_m2 / (0.03514425 * 1e-4) - 1.0;
        EXPECT_EQ(result.fine().cells, cells * cells * cells);
        EXPECT_LT(result.fine().flow_imbalance, 1e-6);
    }
    std::printf("  errors %+.4f %+.4f %+.4f\n", error[0], error[1], error[2]);
    EXPECT_LT(std::abs(error[2]), 0.01);
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(error[k] / error[k + 1]), 2.0, 0.15);
}

Container bend() {
    std::vector<double> heights;
    for (int i = 0; i <= 12; ++i) heights.push_back(0.001 * i);
    return Container(std::make_shared<const vessels::MeshVessel>(test::tube_mesh(
        32, heights, [](double) { return 0.004; },
        [](double z) { return Vec3(0.0015 * (1.0 - std::cos(std::numbers::pi * z / 0.012)), 0.0, z); })));
}

double by_lattice_boltzmann(const Packing& packing, const Section& section) {
    const PoreSpace pores = pore_space_of(std::make_shared<const packing::Grains>(packing), packing.container, section, 0.001);
    return lbm::lbm_permeability(pores, 4e-4, {.iteration_tolerance = 1e-5, .grids = 2}).permeability_m2;
}

// An annular duct by its closed form, a slender cone by lubrication theory (8 mu Q / pi times the integral of 1 / R^4), and a bend, which
// is a mesh, by lattice Boltzmann.
TEST(FoamDuct, RoundWalls) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const double length = 0.012, a = 0.002, b = 0.006, squares = b * b - a * a, first = 0.005, slope = 0.05, last = first + slope * length;
    struct Duct {
        const char* name;
        Container container;
        Vec3 pore_point;
        double permeability;  // 0: by lattice Boltzmann
    };
    const double integral = (std::pow(first, -3) - std::pow(last, -3)) / (3.0 * slope),
                 area = std::numbers::pi * (first * first + first * last + last * last) / 3.0;
    const Duct ducts[] = {
        {"annulus",
         parse_container("annulus:0.004,0.012,0.1"),
         {0.0041, 0.0003, 0.0051},
         (std::pow(b, 4) - std::pow(a, 4) - squares * squares / std::log(b / a)) / (8.0 * squares)},
        {"cone", parse_container("cone:0.01,0.02,0.1"), {0.0003, 0.0002, 0.0051}, std::numbers::pi * length / (8.0 * integral * area)},
        {"bend", bend(), {0.0016, 0.0002, 0.0061}, 0.0}};
    const Section section{0.0, length};
    for (const Duct& duct : ducts) {
        Packing packing{.container = duct.container, .shapes = {make_preset(ShapeKind::sphere, 0.002, 0.0)}, .bodies = {}};
        packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.004, 0.0, 0.08)});
        const double known = duct.permeability > 0.0 ? duct.permeability : by_lattice_boltzmann(packing, section);
        const double volume = packing.container.vessel().mean_area(section.interval()) * length;
        double error[2];
        for (const int fine : {0, 1}) {
            const FoamScene scene{.surface = make_surface(packing, {}).surface,
                                  .container = packing.container,
                                  .section = section,
                                  .pore_volume_m3 = volume,
                                  .grain_size_m = 0.002,
                                  .pore_point = duct.pore_point};
            const FoamResult result = foam_permeability(scene, {.meshes = 1}, fine != 0 ? 0.0005 : 0.001, cases,
                                                        folder.path() / (duct.name + std::to_string(fine)));
            error[fine] = result.fine().permeability_m2 / known - 1.0;
        }
        std::printf("  %s: errors %+.4f %+.4f\n", duct.name, error[0], error[1]);
        EXPECT_LT(std::abs(error[1]), 0.03) << duct.name;  // the annulus is eight cells wide, with the finer ones at its walls
        EXPECT_LT(std::abs(error[1]), 0.4 * std::abs(error[0])) << duct.name;
    }
}

TEST(FoamField, ThePressureOfAPlaneIsFluxWeighted) {
    // A fast stream at pressure 2 - z and a slow one at 5 - z, through the plane z = 0: (3 * 2 + 1 * 5) / 4.
    std::vector<FoamCell> cells;
    for (const double z : {-0.6, -0.2, 0.2, 0.6}) {
        cells.push_back({Vec3(0.0, 0.0, z), Vec3(0.0, 0.0, 3.0), 2.0 - z, 1.0});
        cells.push_back({Vec3(1.0, 0.0, z), Vec3(0.0, 0.0, 1.0), 5.0 - z, 1.0});
    }
    EXPECT_NEAR(plane_pressure(cells, 0.0, 1.0), 11.0 / 4.0, 1e-12);
    EXPECT_NEAR(plane_pressure(cells, 0.1, 1.0), 11.0 / 4.0 - 0.1, 1e-12);
}

TEST(FoamExtrapolation, TwoMeshesHaveOrderOneAndAHalf) {
    // 8 times the cells: cells of half the size; k = 1 + h^1.5 with h = 0.2 and 0.1.
    const std::array<double, 2> cells = {1000.0, 8000.0}, values = {1.0 + std::pow(0.2, 1.5), 1.0 + std::pow(0.1, 1.5)};
    const FoamExtrapolation found = extrapolate_meshes(cells, values);
    EXPECT_NEAR(found.value, 1.0, 1e-12);
    const double change = values[1] - values[0];
    EXPECT_NEAR(found.interval.low, values[1] + change, 1e-12);         // order 1
    EXPECT_NEAR(found.interval.high, values[1] + change / 3.0, 1e-12);  // order 2
}

TEST(FoamExtrapolation, FindsOrderAndLimit) {
    const std::array<double, 3> cells = {1000, 5000, 20000};
    for (const double order : {1.6, 2.0, 2.4}) {
        std::array<double, 3> values{};
        for (std::size_t i = 0; i < 3; ++i) values[i] = 3.0 + 40.0 * std::pow(cells[i], -order / 3.0);
        const FoamExtrapolation found = extrapolate_meshes(cells, values);
        EXPECT_NEAR(*found.observed_order, order, 1e-6);
        EXPECT_NEAR(found.value, 3.0, 1e-6);
        EXPECT_LT(found.interval.low, 3.0);
        EXPECT_GT(found.interval.high, 3.0);
        EXPECT_NEAR(*found.grid_convergence_index, 1.25 * (values[2] - 3.0) / values[2], 1e-6);
    }
    // Too coarse to observe an order: second order is assumed, with a wide interval.
    const std::array<double, 3> coarse = {3.9, 3.6, 3.4};
    const FoamExtrapolation wide = extrapolate_meshes(cells, coarse);
    EXPECT_LT(*wide.observed_order, 1.5);
    EXPECT_NEAR(wide.value, 3.4 - 0.2 / (std::cbrt(16.0) - 1.0), 1e-12);
    EXPECT_GT(wide.interval.high - wide.interval.low, 0.15);
    // Not monotone: no order, and the interval contains all three values.
    const std::array<double, 3> swings = {1.0, 1.2, 1.1};
    const FoamExtrapolation none = extrapolate_meshes(cells, swings);
    EXPECT_FALSE(none.observed_order);
    EXPECT_LT(none.interval.low, 1.0);
    EXPECT_GT(none.interval.high, 1.2);
}

// Coarse meshes close throats of dense beds: k then grows with refinement, and extrapolation would go too far.
TEST(FoamExtrapolation, IsNotDoneWhereMeshesLosePores) {
    const std::vector<double> cells = {27084, 90230}, values = {6.8e-8, 1.21e-7};
    const FoamExtrapolation plain = extrapolate_meshes(cells, values);
    EXPECT_GT(plain.value, 1.8e-7);
    const FoamExtrapolation found = without_lost_pores(plain, values, std::vector<double>{0.82, 0.92});
    EXPECT_TRUE(found.lost_pores);
    EXPECT_EQ(found.value, 1.21e-7);
    EXPECT_EQ(found.interval.low, 6.8e-8);
    EXPECT_EQ(found.interval.high, plain.interval.high);
    // Complete meshes, or k that falls as usual: unchanged.
    EXPECT_EQ(without_lost_pores(plain, values, std::vector<double>{0.98, 0.99}).value, plain.value);
    const std::vector<double> falls = {1.3e-7, 1.25e-7};
    EXPECT_EQ(without_lost_pores(extrapolate_meshes(cells, falls), falls, std::vector<double>{0.9, 0.95}).value,
              extrapolate_meshes(cells, falls).value);
}

TEST(FoamSpheres, SimpleCubicWithinItsInterval) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    Packing packing{.container = parse_container("box:1,1,1:periodic"), .shapes = {}, .bodies = {}};
    const double r = std::cbrt(3.0 * 0.343 / (4.0 * std::numbers::pi));
    packing.shapes.push_back(make_preset(ShapeKind::sphere, 2.0 * r, 0.0));
    packing.bodies.push_back({.shape = 0, .position_m = Vec3::Constant(0.5)});
    const FoamScene scene{.surface = make_surface(packing, {.deviation_m = 0.002}).surface,
                          .container = packing.container,
                          .section = {0.0, 1.0},
                          .pore_volume_m3 = 0.657,
                          .grain_size_m = 2.0 * r,
                          .pore_point = Vec3(0.0131, 0.0173, 0.0119)};
    const FoamResult result = foam_permeability(scene, {.meshes = 3, .mesh_ratio = 1.5}, 1.0 / 36, cases, folder.path() / "run");
    const double exact = 2.0 * r * r / (9.0 * 0.343 * 15.39949);
    ASSERT_EQ(result.meshes.size(), 3U);
    for (const FoamMeshResult& mesh : result.meshes)
        std::printf("  %ld cells: %+.2f %%\n", mesh.cells, 100.0 * (mesh.permeability_m2 / exact - 1.0));
    ASSERT_TRUE(result.extrapolation && result.extrapolation->observed_order);
    const double order = *result.extrapolation->observed_order, gci = *result.extrapolation->grid_convergence_index;
    std::printf("  extrapolated %+.2f %%, order %.2f, grid convergence index %.2f %%\n", 100.0 * (result.permeability_m2 / exact - 1.0),
                order, 100.0 * gci);
    EXPECT_NEAR(result.permeability_m2 / exact, 1.0, 0.01);
    EXPECT_GT(order, 1.0);
    EXPECT_LT(order, 3.0);
    EXPECT_NEAR(result.fine().permeability_m2, exact, gci * result.fine().permeability_m2);
    EXPECT_LT(std::abs(result.fine().permeability_m2 / exact - 1.0), std::abs(result.meshes[0].permeability_m2 / exact - 1.0));
}

TEST(FoamFailure, GarbageThatEndsWithZeroIsSeen) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    FoamScene in_grain = duct();
    in_grain.section = {0.07, 0.09};
    in_grain.pore_volume_m3 = 2e-6;
    in_grain.pore_point = Vec3(0.00501, 0.00502, 0.0801);  // inside the bead
    EXPECT_TRUE(test::has(test::message_of<EngineError>([&] {
                              (void)foam_permeability(in_grain, {.meshes = 1, .surface_level = 2}, 0.001, cases, folder.path() / "grain");
                          }),
                          "OpenFOAM"));
    FoamConfig wild{.meshes = 1};
    wild.relaxation_velocity = 0.99;
    wild.relaxation_pressure = 0.99;
    EXPECT_ANY_THROW((void)foam_permeability(duct(), wild, 0.001, cases, folder.path() / "wild"));
    EXPECT_TRUE(test::has(test::message_of<NumericalError>([&] {
                              (void)foam_permeability(duct(), {.meshes = 1, .max_iterations = 5}, 0.001, cases, folder.path() / "short");
                          }),
                          "did not converge"));
}

}  // namespace
}  // namespace porepack
