// Shortest paths and diffusion through pores against exact answers.
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "core/machine.hpp"
#include "packing/grains.hpp"
#include "pore_space/percolation.hpp"
#include "support/helpers.hpp"
#include "tortuosity/tortuosity.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

double observed_order(double coarse_error, double fine_error, double ratio) {
    return std::log(coarse_error / fine_error) / std::log(ratio);
}

constexpr std::array<bool, 3> walls = {false, false, false};

PhaseImage image_of(std::array<int, 3> cells, double h, const std::function<bool(const Vec3&)>& is_solid) {
    PhaseImage image{.grid = {.cells = cells, .origin_m = {0, 0, 0}, .spacing_m = {h, h, h}}, .phase = {}, .notes = {}};
    for (int k = 0; k < cells[2]; ++k)
        for (int j = 0; j < cells[1]; ++j)
            for (int i = 0; i < cells[0]; ++i)
                image.phase.push_back(is_solid(Vec3((i + 0.5) * h, (j + 0.5) * h, (k + 0.5) * h)) ? Phase::grain : Phase::pore);
    return image;
}

PhaseImage turned(const PhaseImage& image) {  // z becomes x, x becomes y, y becomes z
    const auto& n = image.grid.cells;
    PhaseImage other{
        .grid = {.cells = {n[2], n[0], n[1]}, .origin_m = {0, 0, 0}, .spacing_m = image.grid.spacing_m}, .phase = {}, .notes = {}};
    for (int k = 0; k < n[1]; ++k)
        for (int j = 0; j < n[0]; ++j)
            for (int i = 0; i < n[2]; ++i) other.phase.push_back(image.phase[image.grid.index(j, k, i)]);
    return other;
}

// ---- shortest_path ----

TEST(ShortestPath, AnEmptyBoxIsExactlyOne) {
    const PhaseImage empty = image_of({7, 5, 9}, 0.1, [](const Vec3&) { return false; });
    for (int axis = 0; axis < 3; ++axis) {
        const ShortestPathResult result = shortest_path(empty, axis, {true, false, true});
        EXPECT_EQ(result.value, 1.0);
        EXPECT_EQ(result.minimum, 1.0);
    }
}

// Plates of thickness t leave gaps g at alternating walls of a channel of height H, one every s.
TEST(ShortestPath, StaggeredPlates) {
    const double H = 10, g = 2, s = 5, t = 0.5;
    const int plates = 6;
    const double exact = (plates * t + (plates - 1) * std::hypot(s - t, H - 2 * g) + s - t) / (plates * s);
    for (const int n : {2, 4, 8}) {
        const auto plate = [&](const Vec3& at) {
            const int number = static_cast<int>(at.z() / s);
            return at.z() - number * s < t && (number % 2 == 0 ? at.x() > g : at.x() < H - g);
        };
        const PhaseImage image = image_of({10 * n, 3, plates * 5 * n}, 1.0 / n, plate);
        const double found = shortest_path(image, 2, walls).minimum;
        std::printf("  %d voxels a unit: %.6f, exact %.6f\n", n, found, exact);
        EXPECT_NEAR(found / exact, 1.0, 1e-5);
        EXPECT_NEAR(shortest_path(turned(image), 0, walls).minimum, found, 1e-6);
    }
}

// The path from a height D below a sphere's centre, at distance a from its axis, past the sphere to the plane at height D.
// On the axis it is the longest.
double past_a_sphere(double R, double D, double a) {
    if (a >= R) return 2.0 * D;
    const double away = std::hypot(a, D), angle = std::atan2(D, a) - std::acos(R / away);
    return std::sqrt(away * away - R * R) + R * angle + D;
}
TEST(ShortestPath, PastASphere) {
    EXPECT_NEAR(past_a_sphere(1.0, 1.5, 0.0), std::sqrt(1.25) + std::asin(1 / 1.5) + 1.5, 1e-12);
    const double R = 0.9973, D = 1.2, exact = past_a_sphere(R, D, 0.0) / (2.0 * D);
    Packing packing{
        .container = parse_container("box:2.4,2.4,2.4"), .shapes = {make_preset(ShapeKind::sphere, 2.0 * R, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.position_m = Vec3::Constant(1.2)});
    const PoreSpace space = pore_space_of(packing).with_section({0.0, 2.4});
    std::vector<double> errors, voxel_errors;
    for (const int n : {5, 10, 20}) {
        const ShortestPathResult result = shortest_path(space, 1.0 / n, Axis::z, 10000);
        errors.push_back(result.maximum / exact - 1.0);
        voxel_errors.push_back(shortest_path(space.voxelise_at(1.0 / n), 2, walls).maximum / exact - 1.0);
        std::printf("  %d voxels per radius: %+.3f %% between exact grains, %+.3f %% between voxels\n", n, 100 * errors.back(),
                    100 * voxel_errors.back());
    }
    std::printf("  orders %.2f and %.2f\n", observed_order(std::abs(errors[0]), std::abs(errors[2]), 4.0),
                observed_order(std::abs(voxel_errors[0]), std::abs(voxel_errors[2]), 4.0));
    for (const double error : errors) EXPECT_LT(std::abs(error), 1e-3);
    // Around a staircase the path is longer by an error of first order, minus the scatter from the sphere's outermost voxels.
    EXPECT_LT(std::abs(voxel_errors[2]), 0.007);
    EXPECT_GT(observed_order(std::abs(voxel_errors[0]), std::abs(voxel_errors[2]), 4.0), 0.6);
    // The mean over starting points, from an image alone, against the mean between exact grains.
    const double mean = shortest_path(space, 1.0 / 20, Axis::z).value;
    const double of_image = shortest_path(space.voxelise_at(1.0 / 20), 2, walls).value;
    std::printf("  mean over starting points %.5f between exact grains, %.5f between voxels\n", mean, of_image);
    EXPECT_NEAR(of_image / mean, 1.0, 0.005);
}

TEST(ShortestPath, ThroatsSlotsAndDeadEnds) {
    // A single path of one voxel's width: along z, across, and along z again.
    const PhaseImage single = image_of({8, 3, 8}, 1.0, [](const Vec3& at) {
        const bool low = at.x() < 1.0 && at.z()<4.0, across = at.z()> 3.0 && at.z()<4.0, high = at.x()> 7.0 && at.z() > 3.0;
        return at.y() < 1.0 || at.y() > 2.0 || !(low || across || high);
    });
    const ShortestPathResult way = shortest_path(single, 2, walls);
    // From the right edge of the first duct, along the upper corner, to the left edge of the second.
    EXPECT_NEAR(way.minimum, (3.0 + std::hypot(6.0, 1.0) + 4.0) / 8.0, 1e-6);
    // The same pores connected only through edges: no path.
    const auto checker = [](const Vec3& at) {
        return (static_cast<int>(at.x()) + static_cast<int>(at.y()) + static_cast<int>(at.z())) % 2 == 0;
    };
    EXPECT_THROW((void)shortest_path(image_of({6, 6, 6}, 1.0, checker), 2, walls), NumericalError);
    EXPECT_THROW((void)shortest_path(image_of({6, 6, 6}, 1.0, checker), 2, {true, true, false}), NumericalError);
    EXPECT_THROW((void)shortest_path(image_of({4, 4, 6}, 1.0, [](const Vec3& at) { return at.z() > 3 && at.z() < 4; }), 2, walls),
                 NumericalError);
    // A dead end starts from the first plane and leads nowhere.
    const PhaseImage dead =
        image_of({5, 1, 6}, 1.0, [](const Vec3& at) { return (at.x() > 1 && at.x() < 2) || (at.x() < 1 && at.z() > 3); });
    const ShortestPathResult alive = shortest_path(dead, 2, walls);
    EXPECT_EQ(alive.value, 1.0);
    EXPECT_EQ(alive.blocked_starts, 4);
    // One slice only.
    EXPECT_EQ(shortest_path(image_of({4, 4, 1}, 1.0, [](const Vec3&) { return false; }), 2, walls).value, 1.0);
}

TEST(ShortestPath, GoesOnAcrossPeriodicSides) {
    // A plate with its gap at x = 0, the next with its gap at the far side: across the periodic side they are neighbours.
    const auto plates = [](const Vec3& at) { return (at.z() > 2 && at.z() < 3 && at.x() > 1) || (at.z() > 5 && at.z() < 6 && at.x() < 9); };
    const PhaseImage image = image_of({10, 2, 8}, 1.0, plates);
    const ShortestPathResult closed = shortest_path(image, 2, walls), open = shortest_path(image, 2, {true, false, false});
    EXPECT_NEAR(closed.minimum, (3.0 + std::hypot(8.0, 2.0) + 3.0) / 8.0, 1e-6);
    EXPECT_EQ(open.minimum, 1.0);
    EXPECT_LT(open.value, closed.value);
}

// Layers of a slit that moves by half its width from layer to layer: up, diagonally from corner to corner, and up.
TEST(ShortestPath, ASlantedSlit) {
    const PhaseImage slit = image_of({12, 1, 4}, 1.0, [](const Vec3& at) {
        const double x = at.x() - 2.0 * std::floor(at.z());
        return x < 0.0 || x > 4.0;
    });
    const ShortestPathResult result = shortest_path(slit, 2, walls);
    EXPECT_NEAR(result.minimum, (2.0 + std::sqrt(8.0)) / 4.0, 1e-6);
    EXPECT_GT(result.value, result.minimum);
}

TEST(ShortestPath, AnisotropicVoxels) {
    PhaseImage image = image_of({6, 2, 12}, 1.0, [](const Vec3& at) { return at.z() > 5 && at.z() < 6 && at.x() > 2; });
    image.grid.spacing_m = {2.0, 1.0, 0.5};
    // From the far corner to the plate's lower edge, along its side, and up: 8 across and 2.5 high, then straight.
    const ShortestPathResult result = shortest_path(image, 2, walls);
    EXPECT_NEAR(result.maximum, (std::hypot(8.0, 2.5) + 0.5 + 3.0) / 6.0, 1e-6);
    EXPECT_EQ(result.minimum, 1.0);
    EXPECT_NEAR(result.paths_m.front().back().z(), 6.0, 1e-12);
}

// ---- diffusive ----

TEST(Diffusive, AnEmptyBoxIsOneAndABlockedOneIsNamed) {
    const PhaseImage empty = image_of({6, 5, 7}, 0.3, [](const Vec3&) { return false; });
    for (int axis = 0; axis < 3; ++axis)
        for (const bool around : {false, true}) {
            std::array<bool, 3> periodic = {true, false, true};
            periodic[static_cast<std::size_t>(axis)] = around;
            EXPECT_NEAR(diffusive_tortuosity(empty, axis, periodic).value, 1.0, 1e-6);
        }
    const auto wall = [](const Vec3& at) { return at.z() > 3 && at.z() < 4; };
    EXPECT_THROW((void)diffusive_tortuosity(image_of({4, 4, 6}, 1.0, wall), 2, walls), DoesNotPercolate);
    EXPECT_THROW((void)diffusive_tortuosity(image_of({4, 4, 6}, 1.0, wall), 2, {true, true, true}), DoesNotPercolate);
    EXPECT_NEAR(diffusive_tortuosity(image_of({4, 4, 6}, 1.0, wall), 0, walls).value, 1.0, 1e-6);
    const auto wall_across_x = [](const Vec3& at) { return at.x() > 3 && at.x() < 4; };
    EXPECT_THROW((void)diffusive_tortuosity(image_of({6, 4, 4}, 1.0, wall_across_x), 0, walls), DoesNotPercolate);
}

// A solver that fails on any of the three grids is an error, never "no path leads through".
TEST(Diffusive, AFailedSolverIsNoBlockedPore) {
    Packing packing{.container = parse_container("box:1,1,1"), .shapes = {make_preset(ShapeKind::sphere, 0.5, 0.0)}, .bodies = {}};
    for (const double x : {0.2, 0.55, 0.8})
        for (const double z : {0.3, 0.7}) packing.bodies.push_back({.shape = 0, .position_m = Vec3(x, 1.0 - x, z)});
    const PoreSpace space = pore_space_of(packing).with_section({0.0, 1.0});
    EXPECT_TRUE(diffusive_tortuosity(space, 1.0 / 24, Axis::z).limit);
    int failed = 0;
    // Decreasing numbers of iterations: a solver that fails on any grid is an error; an estimate is always complete.
    for (long iterations = 40; iterations > 0; iterations -= 3) {
        try {
            const DiffusiveEstimate estimate = diffusive_tortuosity(space, 1.0 / 24, Axis::z, {.max_iterations = iterations});
            EXPECT_TRUE(estimate.limit) << estimate.no_limit_because;
        } catch (const DoesNotPercolate& fault) {
            ADD_FAILURE() << fault.what();
        } catch (const NumericalError& fault) {
            EXPECT_TRUE(test::has(fault.what(), "has not converged"));
            ++failed;
        }
    }
    EXPECT_GT(failed, 0);
}

// Images of three voxel sizes a factor of two apart; the staircase errors are of first order, so extrapolation removes them.
struct ThreeGrids {
    std::array<double, 3> error{};
    double extrapolated = 0.0, order = 0.0;
};
ThreeGrids three_grids(double exact, const std::array<int, 3>& cells, const std::function<double(int)>& value) {
    ThreeGrids grids;
    std::array<double, 3> values{};
    for (std::size_t i = 0; i < 3; ++i) {
        values[i] = value(cells[i]);
        grids.error[i] = values[i] / exact - 1.0;
    }
    grids.order = std::log2(std::abs(values[1] - values[0]) / std::abs(values[2] - values[1]));
    grids.extrapolated = (2.0 * values[2] - values[1]) / exact - 1.0;
    EXPECT_LT(std::abs(grids.extrapolated), 0.005);
    std::printf("  errors %+.2f %+.2f %+.2f %%, order %.2f, extrapolated %+.2f %%\n", 100 * grids.error[0], 100 * grids.error[1],
                100 * grids.error[2], grids.order, 100 * grids.extrapolated);
    return grids;
}

// Rayleigh 1892; Perrins, McKenzie & McPhedran 1979: D_eff/D0 across a square array of insulating cylinders, solid fraction f.
TEST(Diffusive, SquareArraysOfCylinders) {
    for (const double f : {0.2, 0.5}) {
        const double T = 1.0;
        const double D =
            1.0 - 2.0 * f / (T + f - 0.305827 * T * std::pow(f, 4) / (T * T - 1.402958 * std::pow(f, 8)) - 0.013362 * std::pow(f, 8) / T);
        const double r = std::sqrt(f / std::numbers::pi);
        const ThreeGrids grids = three_grids((1.0 - f) / D, {32, 64, 128}, [&](int n) {
            const auto in = [&](const Vec3& at) { return std::hypot(at.x() - 0.5, at.z() - 0.5) < r; };
            return diffusive_tortuosity(image_of({n, 1, n}, 1.0 / n, in), 2, {true, true, true}).value;
        });
        EXPECT_GT(grids.order, 0.8);
    }
}

// Sangani & Acrivos 1983: insulating spheres in simple cubic order.
TEST(Diffusive, SimpleCubicSpheres) {
    for (const double f : {0.15, 0.343}) {
        const auto L = [](int i) { return -1.0 / (2.0 * i / (2.0 * i - 1.0)); };
        const double D = 1.0 - 3.0 * f /
                                   (2.0 + f +
                                    1.3047 * L(2) * std::pow(f, 10.0 / 3.0) * (1.0 + 0.2305 * L(3) * std::pow(f, 11.0 / 3.0)) /
                                        (1.0 - 0.4054 * L(2) * std::pow(f, 7.0 / 3.0)) +
                                    0.07231 * L(3) * std::pow(f, 14.0 / 3.0) + 0.1526 * L(4) * std::pow(f, 6.0) +
                                    0.0105 * L(5) * std::pow(f, 22.0 / 3.0));
        const double r = std::cbrt(3.0 * f / (4.0 * std::numbers::pi));
        const ThreeGrids grids = three_grids((1.0 - f) / D, {20, 40, 80}, [&](int n) {
            const auto in = [&](const Vec3& at) { return (at - Vec3::Constant(0.5)).norm() < r; };
            const PhaseImage image = image_of({n, n, n}, 1.0 / n, in);
            const double around = diffusive_tortuosity(image, 2, {true, true, true}).value;
            // Half-way between the layers the concentration is uniform by symmetry: planes there have no effect.
            if (n == 20) {
                EXPECT_NEAR(diffusive_tortuosity(image, 2, {true, true, false}).value, around, 2e-5 * around);
            }
            return around;
        });
        EXPECT_GT(grids.order, 0.8);
    }
}

// A duct inclined by theta: 1/cos^2(theta).
TEST(Diffusive, InclinedDucts) {
    for (const int rise : {1, 2}) {  // x per z
        const double exact = 1.0 + rise * rise;
        const ThreeGrids grids = three_grids(exact, {24, 48, 96}, [&](int n) {
            const auto out = [&](const Vec3& at) {
                const double x = at.x() - rise * at.z() + 0.237;
                return x - std::floor(x) > 0.5;
            };
            return diffusive_tortuosity(image_of({n, 1, n}, 1.0 / n, out), 2, {true, true, true}).value;
        });
        EXPECT_GT(grids.order, 0.8);
    }
}

TEST(Diffusive, DeadEndsThroatsAndThinPores) {
    // Dead ends carry no flux: the straight pore keeps its flux, the porosity increases, and so does the tortuosity factor.
    const auto comb = [](const Vec3& at) { return at.x() > 2 && !(at.z() > 4 && at.z() < 6); };
    const DiffusiveResult dead = diffusive_tortuosity(image_of({8, 3, 10}, 1.0, comb), 2, walls);
    EXPECT_GT(dead.value, 1.2);
    EXPECT_LT(dead.flux_imbalance, 1e-4);
    // One voxel of 20 x 20: porosity 0.0025.
    const auto thin = [](const Vec3& at) { return !(at.x() > 7 && at.x() < 8 && at.y() > 3 && at.y() < 4); };
    const DiffusiveResult pore = diffusive_tortuosity(image_of({20, 20, 30}, 1.0, thin), 2, walls);
    EXPECT_NEAR(pore.value, 1.0, 1e-6);
    EXPECT_NEAR(pore.relative_diffusivity, 1.0 / 400.0, 1e-8);
    // A closed pocket counts as porosity, and is reported separately.
    const auto pocket = [](const Vec3& at) { return at.x() > 2 && !(at.x() > 4 && at.x() < 6 && at.z() > 3 && at.z() < 5); };
    const DiffusiveResult closed = diffusive_tortuosity(image_of({8, 2, 8}, 1.0, pocket), 2, walls);
    EXPECT_GT(closed.porosity, closed.porosity_flowing);
    EXPECT_NEAR(closed.value, closed.porosity / 0.25, 1e-5);
    const auto checker = [](const Vec3& at) {
        return (static_cast<int>(at.x()) + static_cast<int>(at.y()) + static_cast<int>(at.z())) % 2 == 0;
    };
    EXPECT_THROW((void)diffusive_tortuosity(image_of({6, 6, 6}, 1.0, checker), 2, {true, true, true}), DoesNotPercolate);
}

// Touching spheres in simple cubic order, nearly no solid, nearly all solid: all between 1 and known bounds.
TEST(AllKinds, HoldAtTheEnds) {
    const auto ball = [](double r) { return [r](const Vec3& at) { return (at - Vec3::Constant(0.5)).norm() < r; }; };
    const PhaseImage touching = image_of({40, 40, 40}, 1.0 / 40.0, ball(0.5));
    EXPECT_NEAR(shortest_path(touching, 2, walls).minimum, 1.0, 1e-12);  // along the corners of the cell
    const double ways = shortest_path(touching, 2, walls).value;
    EXPECT_GT(ways, 1.0);
    EXPECT_LT(ways, 1.2);
    // Diffusion between spheres is slower than Maxwell's upper bound; Bruggeman's sqrt(eps) is near.
    const DiffusiveResult slow = diffusive_tortuosity(touching, 2, {true, true, true});
    EXPECT_GT(slow.value, 1.0 + 0.5 * (1.0 - slow.porosity));
    EXPECT_LT(slow.value, 2.0);
    // Porosity 0.99: Maxwell 1 + (1 - eps)/2.
    const PhaseImage airy = image_of({60, 60, 60}, 1.0 / 60.0, ball(0.1337));
    const DiffusiveResult airy_result = diffusive_tortuosity(airy, 2, {true, true, true});
    EXPECT_NEAR(airy_result.value, 1.0 + 0.5 * (1.0 - airy_result.porosity), 2e-3);
    EXPECT_LT(shortest_path(airy, 2, {true, true, false}).value, 1.005);
    // Porosity 0.05: one duct of a rectangle, straight.
    const PhaseImage dense = image_of({20, 20, 20}, 1.0, [](const Vec3& at) { return !(at.x() < 5 && at.y() < 4); });
    EXPECT_NEAR(diffusive_tortuosity(dense, 2, walls).value, 1.0, 1e-6);
    EXPECT_NEAR(diffusive_tortuosity(dense, 2, walls).porosity, 0.05, 1e-12);
    EXPECT_EQ(shortest_path(dense, 2, walls).value, 1.0);
    // Noise: single voxels of the wrong phase here and there.
    PhaseImage noisy = touching;
    std::mt19937 random(1);
    for (auto& phase : noisy.phase)
        if (random() % 200 == 0) phase = phase == Phase::pore ? Phase::grain : Phase::pore;
    EXPECT_NEAR(shortest_path(noisy, 2, walls).value / ways, 1.0, 0.02);
    EXPECT_NEAR(diffusive_tortuosity(noisy, 2, {true, true, true}).value / slow.value, 1.0, 0.05);
    // The wrong axis of a cylinder: its sides are not planes that could be inlet and outlet.
    PhaseImage pipe = image_of({10, 10, 10}, 0.1, [](const Vec3&) { return false; });
    for (int k = 0; k < 10; ++k)
        for (int j = 0; j < 10; ++j)
            for (int i = 0; i < 10; ++i)
                if (std::hypot(i - 4.5, j - 4.5) > 4.4) pipe.phase[pipe.grid.index(i, j, k)] = Phase::outside;
    EXPECT_THROW((void)shortest_path(pipe, 0, walls), NumericalError);
    EXPECT_THROW((void)diffusive_tortuosity(pipe, 0, walls), DoesNotPercolate);
    EXPECT_EQ(shortest_path(pipe, 2, walls).value, 1.0);
}

TEST(Diffusive, TheNumberOfThreadsChangesNoBit) {
    const auto in = [&](const Vec3& at) { return (at - Vec3::Constant(0.5)).norm() < 0.4; };
    const PhaseImage image = image_of({21, 22, 23}, 1.0 / 22.0, in);
    const int threads = thread_count();
    set_thread_count(1);
    const double one = diffusive_tortuosity(image, 2, {true, true, false}).value;
    set_thread_count(2);
    EXPECT_EQ(diffusive_tortuosity(image, 2, {true, true, false}).value, one);
    set_thread_count(threads);
}

}  // namespace
}  // namespace porepack
