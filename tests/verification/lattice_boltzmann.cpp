// Interpolated walls and the fast kernel: distances, the two kernels against each other, accuracy on arrays and ducts.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "converters/surface.hpp"
#include "lbm/kernels/cpu/kernel.hpp"
#include "lbm/kernels/layout/addresses.hpp"
#include "lbm/lattice.hpp"
#include "lbm/sequence.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using namespace test;

TEST(WallDistance, IsThatOfTheExactGeometry) {
    // Every distance is checked against the signed distance of its wall point, periodic images included.
    const KnownFlow array = sphere_array(0.6, 88.8734, body_centred(), Vec3(0.013, 0.027, 0.041));
    const int n = 24;
    const Scene scene(array.packing, {0, 1}, 1.0 / n);
    ASSERT_GT(scene.domain.walls.size(), 10000U);
    int not_exact = 0;
    for (const WallLink& link : scene.domain.walls) {
        const auto here = scene.domain.grid.place(scene.domain.cells.cell(link.node));
        const auto& c = d3q19::c[link.q];
        const Vec3 way(c[0], c[1], c[2]);
        Vec3 at = (Vec3(here[0] + 0.5, here[1] + 0.5, here[2] + 0.5) + link.fraction() * way) / n;
        double least = 1.0;
        for (const Body& body : array.packing.bodies) {
            Vec3 away = at - body.position_m;
            for (int a = 0; a < 3; ++a) away[a] -= std::round(away[a]);
            least = std::min(least, std::abs(away.norm() - 0.5 * array.diameter_m));
        }
        // A link to a cell that no flow reaches has no wall on it: half-way is used. In a gap of one node the minimum is 0.02.
        if (link.distance == 32768 || (link.narrow && link.distance == 1311))
            ++not_exact;
        else
            EXPECT_LT(least * n, 3e-5) << link.node << " " << int(link.q);
    }
    EXPECT_LT(not_exact, 100);
}

TEST(WallDistance, KnowsTheContainerTheCutAndTheMirror) {
    const Packing packing{.container = parse_container("cylinder:1,2"),
                          .shapes = {make_preset(ShapeKind::sphere, 0.5, 0.0)},
                          .bodies = {{.shape = 0, .position_m = {0, 0, 0.52}}}};
    const Grains grains(packing);
    const Grid grid{.cells = {10, 10, 10}, .origin_m = {-0.5, -0.5, 0.5}, .spacing_m = {0.1, 0.1, 0.1}};
    const Drive drive{.axis = 2, .periodic = {false, false, false}};
    WallFinder side({grains, packing.container, {0.5, 1.5}}, grid, drive);
    side.move_to({0.45, 0.05, 1.05});
    EXPECT_NEAR(*side.fraction({0.1, 0, 0}), (std::sqrt(0.25 - 0.0025) - 0.45) / 0.1, 1e-12);
    EXPECT_FALSE(side.fraction({-0.1, 0, 0}));
    // Beyond the end plane at 0.5 lies the mirror image of the sphere about 0.52: from a centre 0.05 above it, in a slope.
    side.move_to({0.305, 0.0, 0.55});
    const double inward = *side.fraction({-0.1, 0, 0}), mirrored = *side.fraction({-0.1, 0, -0.1});
    EXPECT_NEAR(inward, (0.305 - std::sqrt(0.0625 - 0.0009)) / 0.1, 1e-12);
    EXPECT_GT(mirrored, 0.5);
    const double z = 0.5 + (mirrored - 0.5) * 0.1;
    EXPECT_NEAR(std::hypot(0.305 - 0.1 * mirrored, z - 0.52), 0.25, 1e-12);
    // With void before the section the plane cuts the sphere, and the cut face is a wall.
    const Grid reservoir{.cells = {10, 10, 12}, .origin_m = {-0.5, -0.5, 0.4}, .spacing_m = {0.1, 0.1, 0.1}};
    WallFinder cut({grains, packing.container, {0.5, 1.5}}, reservoir, drive);
    cut.move_to({0.05, 0.05, 0.45});
    EXPECT_NEAR(*cut.fraction({0, 0, 0.1}), 0.5, 1e-12);
}

TEST(WallDistance, OfASurfaceIsThatOfItsTriangles) {
    Packing packing{.container = parse_container("box:1,1,1"),
                    .shapes = {make_preset(ShapeKind::sphere, 0.6, 0.0)},
                    .bodies = {{.position_m = Vec3::Constant(0.5)}}};
    const auto surface = make_surface(packing, {.deviation_m = 5e-4}).surface;
    const SurfaceSolid solid(surface, packing.container);
    const auto probe = solid.probe();
    probe->move_to({0.85, 0.51, 0.52}, 0.2);
    const auto hit = probe->first_hit({0.85, 0.51, 0.52}, {-0.2, 0.0, 0.0});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(*hit, (0.35 - std::sqrt(0.09 - 0.0005)) / 0.2, 1e-3 / 0.2);
    EXPECT_FALSE(probe->first_hit({0.85, 0.51, 0.52}, {0.2, 0.0, 0.0}));
}

double largest_difference(const Scene& scene, const Scheme& scheme, Kernel one, Kernel other, int pairs) {
    const auto a = make_flow(one, scene.domain, scheme), b = make_flow(other, scene.domain, scheme);
    std::vector<double> added(scene.domain.nodes());
    for (std::size_t i = 0; i < added.size(); ++i)
        added[i] = 1e-3 * static_cast<double>(scene.domain.layer_of_cell(scene.domain.cells.cell(i)) % 7);
    for (int i = 0; i < pairs; ++i) {
        a->advance_two_steps();
        b->advance_two_steps();
        if (i != pairs / 2) continue;
        a->add_density(0, added);
        b->add_density(0, added);
    }
    std::vector<Moments> left(scene.domain.nodes()), right(scene.domain.nodes());
    a->moments(0, left);
    b->moments(0, right);
    double largest = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < left.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            scale = std::max(scale, std::abs(left[i].velocity[axis]));
            largest = std::max(largest, std::abs(left[i].velocity[axis] - right[i].velocity[axis]));
        }
    const auto drag_a = a->drag(scene.domain), drag_b = b->drag(scene.domain);
    EXPECT_NEAR(drag_b[2] / drag_a[2], 1.0, one == Kernel::cpu_single || other == Kernel::cpu_single ? 1e-4 : 1e-10);
    return largest / scale;
}

TEST(Kernels, AddedDensityLeavesTheVelocity) {
    const Scene bed(random_bed("cylinder:1,1", 10, 0.08), {0.1, 0.9}, 1.0 / 24);
    const auto flow = make_flow(Kernel::cpu_double, bed.domain, {.force = {0, 0, 1e-3}});
    for (int i = 0; i < 10; ++i) flow->advance_two_steps();
    std::vector<Moments> before(bed.domain.nodes()), after(bed.domain.nodes());
    flow->moments(0, before);
    flow->add_density(0, std::vector<double>(bed.domain.nodes(), 0.25));
    flow->moments(0, after);
    for (std::size_t i = 0; i < before.size(); ++i) {
        ASSERT_NEAR(after[i].density - before[i].density, 0.25, 1e-12);
        for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_NEAR(after[i].velocity[axis], before[i].velocity[axis], 1e-12);
    }
}

// A bed that is five tubes long: without the correction the pressure along it takes most of the steps.
TEST(Convergence, BalancedLayersSaveStepsInALongBed) {
    const Scene bed(random_bed("cylinder:1,5", 50, 0.08), {0.0, 5.0}, 1.0 / 12);
    const Scheme scheme{.tau = 1.2, .force = {0, 0, 1e-3}};
    const FlowSection section = flow_section(bed.image.grid, bed.packing.container, bed.section, bed.drive);
    const auto solved = [&](bool balance, double tolerance) {
        const auto flow = make_flow(Kernel::cpu_double, bed.domain, scheme);
        return run_to_steady(*flow, bed.domain, scheme, section, {.tolerance = tolerance, .balance = balance});
    };
    const StokesRun plain = solved(false, 1e-3), balanced = solved(true, 1e-3), exact = solved(true, 1e-7);
    std::printf("  steps %ld, balanced %ld; k / k converged %.5f, %.5f; imbalance %.1e, %.1e\n", plain.steps, balanced.steps,
                plain.permeability_lu / exact.permeability_lu, balanced.permeability_lu / exact.permeability_lu, plain.flow_imbalance,
                balanced.flow_imbalance);
    ASSERT_TRUE(plain.converged && balanced.converged && exact.converged);
    EXPECT_LT(2 * balanced.steps, plain.steps);
    EXPECT_NEAR(balanced.permeability_lu / exact.permeability_lu, 1.0, 2e-3);
    EXPECT_NEAR(solved(false, 1e-5).permeability_lu / exact.permeability_lu, 1.0, 1e-4) << "the steady state is the same";
}

// Populations beyond 2^32, and neighbours at the other end of such a grid: every node is read from its slot, by a group or by itself.
TEST(Kernels, AddressesReachBeyond32Bits) {
    using namespace lbm::layout;
    std::mt19937_64 random(3);
    for (const std::uint64_t start :
         {std::uint64_t{5000}, std::uint64_t{1} << 31U, (std::uint64_t{1} << 32U) - 50, std::uint64_t{7} << 33U}) {
        std::vector<std::uint64_t> slots(chunk_nodes - 5);
        for (std::size_t i = 0; i < slots.size(); ++i) {
            slots[i] = start + i + 1000 * (i / 20);
            if (i % 40 == 39) slots[i] = random() >> 20U | 4096U;  // through a periodic face, up to 2^44 away
        }
        const std::size_t q = 7, chunk = start / (19 * chunk_nodes);
        for (std::size_t i = 64; i < 70; ++i) slots[i] = slot_of(q, chunk * chunk_nodes + i);  // walls
        std::array<Addresses::Group, chunk_nodes / group_nodes> groups;
        std::vector<Addresses::Single> singles;
        make_groups(slots, chunk, q, groups.data(), singles);
        std::vector<std::uint64_t> found(slots.size(), 0);
        for (std::size_t i = 0; i < slots.size(); ++i) {
            const Addresses::Group& group = groups[i / group_nodes];
            const std::size_t node = i % group_nodes;
            const bool first = (group.first_nodes >> node & 1U) != 0, second = (group.second_nodes >> node & 1U) != 0;
            if (!first && !second) found[i] = slot_of(q, chunk * chunk_nodes + i);
            if (first != second) found[i] = base_of(chunk) + (first ? group.first : group.second) + node;
        }
        for (const Addresses::Single single : singles) {
            const std::size_t place = single & ((1U << Addresses::place_bits) - 1);
            ASSERT_EQ(place / chunk_nodes, q);
            EXPECT_EQ(found[place % chunk_nodes], 0U);
            found[place % chunk_nodes] = single >> Addresses::place_bits;
        }
        EXPECT_EQ(found, slots) << start;
        EXPECT_LT(singles.size(), 30U);  // most nodes are in groups: 3 far ones, and few from a third place
    }
}

// Every instruction set of this processor; each is selected one after the other.
TEST(Kernels, EveryInstructionSetAgreesWithTheReference) {
    const Scene bed(random_bed("cylinder:1,1", 10, 0.08), {0.1, 0.9}, 1.0 / 24);
    for (const lbm::cpu::InstructionSet& set : lbm::cpu::instruction_sets()) {
        setenv("POREPACK_INSTRUCTION_SET", set.name, 1);
        if (!set.runs_here()) {
            EXPECT_THROW((void)make_flow(Kernel::cpu_double, bed.domain, {}), UserError) << set.name;
            std::printf("  %s: this processor does not have it\n", set.name);
            continue;
        }
        EXPECT_STREQ(lbm::cpu::chosen_instruction_set().name, set.name);
        for (const Model model : {Model::stokes, Model::navier_stokes, Model::regularised, Model::recursive}) {
            const Scheme scheme{.tau = 0.8, .model = model, .force = {1e-4, 2e-4, 1e-3}};
            EXPECT_LT(largest_difference(bed, scheme, Kernel::reference, Kernel::cpu_double, 20), 1e-12) << set.name;
            EXPECT_LT(largest_difference(bed, scheme, Kernel::reference, Kernel::cpu_single, 20), 2e-5) << set.name;
        }
        std::printf("  %s: agrees\n", set.name);
    }
    setenv("POREPACK_INSTRUCTION_SET", "sse9", 1);
    EXPECT_TRUE(test::has(test::message_of<UserError>([] { (void)lbm::cpu::chosen_instruction_set(); }), "baseline, avx2, avx512"));
    unsetenv("POREPACK_INSTRUCTION_SET");
}

TEST(Kernels, AgreeOnABedOfManyScheduleParts) {
    const Scene bed(random_bed("box:1,1,1:periodic", 30, 0.05), {0, 1}, 1.0 / 50);
    ASSERT_GT(bed.domain.nodes(), 5U * 128U * 128U);
    EXPECT_LT(largest_difference(bed, {.force = {1e-4, 2e-4, 1e-3}}, Kernel::reference, Kernel::cpu_double, 8), 1e-12);
}

TEST(Kernels, FastAndReferenceAgreeToRounding) {
    const Scene periodic(random_bed("box:1,1,1:periodic", 14, 0.08), {0, 1}, 1.0 / 24);
    const Scene planes(random_bed("cylinder:1,1", 10, 0.08), {0.1, 0.9}, 1.0 / 24);
    const Scene reservoirs(random_bed("cylinder:1,1", 10, 0.08), {0.1, 0.9}, 1.0 / 20, 0.1);
    for (const Scene* scene : {&periodic, &planes, &reservoirs}) {
        EXPECT_GT(scene->domain.narrow_share(), 0.01);
        EXPECT_EQ(scene->domain.boundary_links.empty(), scene == &periodic);
        for (const Walls walls : {Walls::interpolated, Walls::bounce_back})
            for (const double tau : {0.6, 1.2}) {
                const Scheme scheme{.tau = tau, .walls = walls, .force = {1e-4, 2e-4, 1e-3}};
                EXPECT_LT(largest_difference(*scene, scheme, Kernel::reference, Kernel::cpu_double, 20), 1e-12);
                EXPECT_LT(largest_difference(*scene, scheme, Kernel::cpu_double, Kernel::cpu_single, 20), 2e-5);
            }
        for (const Model model : {Model::navier_stokes, Model::regularised, Model::recursive}) {
            const Scheme inertia{.tau = 0.8, .model = model, .force = {0, 0, 1e-4}};
            EXPECT_LT(largest_difference(*scene, inertia, Kernel::reference, Kernel::cpu_double, 20), 1e-12);
        }
    }
}

struct Known {
    const char* name;
    KnownFlow array;
    double cells, at_20, median_at_20, at_40;
};

std::vector<Known> known_arrays(const Vec3& shift) {
    const auto spheres = [&](double c, double K, const std::vector<Vec3>& centres, int cells) {
        return sphere_array(c, K, centres, shift / cells);
    };
    const double touching = std::numbers::pi / 6.0, body_touching = std::sqrt(3.0) * std::numbers::pi / 8.0;
    const auto cylinders = [&](double phi, double drag, int cells, Axis direction) {
        return cylinder_array(phi, drag, 4.0 / cells, shift / cells, direction);
    };
    // Cells that make 20 nodes per diameter; the bounds are the project's own requirements.
    std::vector<Known> known;
    const auto add = [&](const char* name, KnownFlow flow, double cells, double at_20, double median_at_20, double at_40) {
        known.push_back({name, std::move(flow), cells, at_20, median_at_20, at_40});
    };
    add("SC 0.343", spheres(0.343, 15.39949, simple_cubic(), 23), 23, 0.01, 0.005, 0.0025);
    add("BCC 0.343", spheres(0.343, 16.33505, body_centred(), 29), 29, 0.01, 0.005, 0.0025);
    add("BCC 0.6", spheres(0.6, 88.8734, body_centred(), 24), 24, 0.01, 0.005, 0.0025);
    add("SC touching", spheres(touching, 42.1005, simple_cubic(), 20), 20, 0.015, 0.015, 0.004);
    add("BCC touching", spheres(body_touching, 162.779, body_centred(), 23), 23, 0.03, 0.03, 0.005);
    add("cylinders 0.3 across", cylinders(0.3, 102.881, 32, Axis::x), 32, 0.01, 0.01, 0.01);
    add("cylinders 0.5 across", cylinders(0.5, 532.548, 25, Axis::x), 25, 0.01, 0.01, 0.01);
    add("cylinders 0.3 along", cylinders(0.3, 44.5254, 32, Axis::z), 32, 0.01, 0.01, 0.01);
    add("cylinders 0.5 along", cylinders(0.5, 141.349, 25, Axis::z), 25, 0.01, 0.01, 0.01);
    return known;
}

TEST(Accuracy, ArraysOfSpheresAndCylinders) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<std::vector<double>> errors(9);
    constexpr int shifts = 6;
    for (int s = 0; s < shifts; ++s) {
        const auto arrays = known_arrays({unit(random), unit(random), unit(random)});
        for (std::size_t k = 0; k < arrays.size(); ++k) {
            const Known& known = arrays[k];
            errors[k].push_back(error_of(known.array, known.cells, {.iteration_tolerance = 1e-5, .grids = 1}));
            EXPECT_LE(std::abs(errors[k].back()), known.at_20) << known.name;
        }
    }
    const auto arrays = known_arrays({0.31, 0.17, 0.43});
    for (std::size_t k = 0; k < arrays.size(); ++k) {
        const Known& known = arrays[k];
        std::vector<double> sizes;
        for (const double error : errors[k]) sizes.push_back(std::abs(error));
        std::sort(sizes.begin(), sizes.end());
        EXPECT_LE(sizes[shifts / 2], known.median_at_20) << known.name;
        const double fine = error_of(known.array, 2.0 * known.cells, {.iteration_tolerance = 1e-5, .grids = 1});
        EXPECT_LE(std::abs(fine), known.at_40) << known.name;
        std::printf("  %-22s 20 nodes: %+.2f to %+.2f %%, 40 nodes: %+.3f %%\n", known.name,
                    100.0 * *std::min_element(errors[k].begin(), errors[k].end()),
                    100.0 * *std::max_element(errors[k].begin(), errors[k].end()), 100.0 * fine);
    }
}

TEST(Accuracy, ATurnedArrayIsAsGood) {
    EXPECT_LE(std::abs(error_of(turned_array(0.343, 15.39949), 23, {.iteration_tolerance = 1e-5, .grids = 1})), 0.01);
}

double duct_error(const KnownFlow& duct, double cells) {
    return error_of(duct, cells, {.iteration_tolerance = 1e-8, .grids = 1});
}

TEST(Accuracy, DuctsAreOfSecondOrder) {
    // A slit inclined 1:2 to the grid (its normal is (2, 1)/sqrt 5, its period along it 1/sqrt 5), and a pipe off the
    // grid's centre; 10, 20, 40 nodes across.
    const double period = 1.0 / std::sqrt(5.0), width = 0.6 * period;
    const auto slit = [=](double x, double y) {
        const double across = (2.0 * x + y) / std::sqrt(5.0) + 0.05;
        return 0.5 * width - std::abs(across - period * std::round(across / period));
    };
    const double radius = 0.4;
    const auto pipe = [=](double x, double y) { return radius - std::hypot(x - 0.513, y - 0.487); };
    double slits[3], pipes[3];
    for (int i = 0; i < 3; ++i) {
        const double fine = 37 << i, coarse = std::lround(10 * (1 << i) / (2.0 * radius));
        slits[i] = duct_error(duct("slit", slit, width, width * width / 12.0 * (width / period), 4.0 / fine), fine);
        pipes[i] = duct_error(duct("pipe", pipe, 2.0 * radius, std::numbers::pi * std::pow(radius, 4) / 8.0, 4.0 / coarse), coarse);
    }
    std::printf("  slit %+.3f %+.3f %+.3f %%, pipe %+.3f %+.3f %+.3f %%\n", 100 * slits[0], 100 * slits[1], 100 * slits[2], 100 * pipes[0],
                100 * pipes[1], 100 * pipes[2]);
    EXPECT_GE(std::log2(std::abs(slits[0] / slits[2])) / 2.0, 1.9);
    EXPECT_GE(std::log2(std::abs(pipes[0] / pipes[2])) / 2.0, 1.9);
}

TEST(Momentum, DragBalancesTheDrivingForce) {
    const Scene scene(sphere_array(0.343, 15.39949, simple_cubic()).packing, {0, 1}, 1.0 / 16);
    const Scheme scheme{.force = {0, 0, 1e-3}};
    const auto flow = make_flow(Kernel::cpu_double, scene.domain, scheme);
    for (int i = 0; i < 2000; ++i) flow->advance_two_steps();
    EXPECT_NEAR(flow->drag(scene.domain)[2] / (1e-3 * static_cast<double>(scene.domain.nodes())), 1.0, 1e-6);
}

TEST(Precision, SingleGivesTheSamePermeability) {
    const KnownFlow array = sphere_array(0.6, 88.8734, body_centred(), Vec3(0.01, 0.02, 0.03));
    const double full = solve(array, 32, {.iteration_tolerance = 1e-6, .grids = 1}).fine().permeability_m2;
    const double single =
        solve(array, 32, {.precision = Precision::single_precision, .iteration_tolerance = 1e-6, .grids = 1}).fine().permeability_m2;
    EXPECT_NEAR(single / full, 1.0, 1e-4);
}

// About five minutes: ctest -L long.
TEST(Precision, LongSingleGivesTheSameOnTenMillionNodes) {
    Packing packing{
        .container = parse_container("box:1,1,1:periodic"), .shapes = {make_preset(ShapeKind::sphere, 0.14, 0.0)}, .bodies = {}};
    std::mt19937 random(1);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (int i = 0; i < 520; ++i) {
        const double x = unit(), y = unit(), z = unit();
        packing.bodies.push_back({.shape = 0, .position_m = {x, y, z}});
    }
    const PoreSpace space = pore_space_of(packing).with_section({0.0, 1.0});
    const auto k_of = [&](Precision precision) {
        const LbmGridResult fine =
            lbm_permeability(space, 1.0 / 292, {.precision = precision, .iteration_tolerance = 2e-5, .grids = 3}).fine();
        EXPECT_GT(fine.nodes, 9'000'000U);
        return fine.permeability_m2;
    };
    const double full = k_of(Precision::double_precision), single = k_of(Precision::single_precision);
    std::printf("  single / double - 1 = %.2e\n", single / full - 1.0);
    EXPECT_NEAR(single / full, 1.0, 1e-4);
}

TEST(Stability, EveryViscosityOnADenseBedOfTouchingGrains) {
    for (const double tau : {0.501, 0.51, 2.0, 10.0}) {
        const Scene scene(random_bed("cylinder:1,1", 25, 0.08), {0.1, 0.9}, 1.0 / 24);
        const Scheme scheme{.tau = tau, .force = {0, 0, 1e-3}};
        const auto flow = make_flow(Kernel::cpu_double, scene.domain, scheme);
        for (int i = 0; i < 1000; ++i) flow->advance_two_steps();
        std::vector<Moments> moments(scene.domain.nodes());
        flow->moments(0, moments);
        for (const Moments& here : moments) ASSERT_LT(std::abs(here.velocity[2]), 1e3) << tau;
    }
}

}  // namespace
}  // namespace porepack
