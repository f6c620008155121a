// Solid between two nodes: plates thinner than a voxel, grazing grains, and edges that solid voxels share.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "converters/surface.hpp"
#include "lbm/permeability.hpp"
#include "lbm/solver.hpp"
#include "pore_space/find_cuts.hpp"
#include "pore_space/link_cuts.hpp"
#include "shapes/segments.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack {
namespace {

using namespace test;

// Adds the box with these half lengths along the axes of `frame`, its facets outwards.
void add_plate(geometry::TriangleSurface& surface, const Vec3& centre, const Eigen::Matrix3d& frame, const Vec3& half) {
    const int first = static_cast<int>(surface.points.size());
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 sides((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
        const Vec3 at = centre + frame * half.cwiseProduct(sides);
        surface.points.push_back({at.x(), at.y(), at.z()});
    }
    for (const auto& t : std::initializer_list<std::array<int, 3>>{{0, 2, 1},
                                                                   {1, 2, 3},
                                                                   {4, 5, 6},
                                                                   {5, 7, 6},
                                                                   {0, 1, 4},
                                                                   {1, 5, 4},
                                                                   {2, 6, 3},
                                                                   {3, 6, 7},
                                                                   {0, 4, 2},
                                                                   {2, 4, 6},
                                                                   {1, 3, 5},
                                                                   {3, 7, 5}})
        surface.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

// Infinite parallel plates in a periodic unit cube: planes p x + q z = m + offset, and the flow along z between them.
struct Plates {
    int p, q;
    double thickness, offset;

    [[nodiscard]] Container box() const { return parse_container("box:1,1,1:periodic"); }
    [[nodiscard]] PoreSpace space() const {
        const double norm = std::hypot(p, q);
        Eigen::Matrix3d frame;  // along the plate, y, normal
        frame.col(0) = Vec3(q, 0, -p) / norm;
        frame.col(1) = Vec3::UnitY();
        frame.col(2) = frame.col(0).cross(frame.col(1));
        // One plate through the box and beyond it; its images overlap and make the others. Large parts outside would be repeated twice.
        geometry::TriangleSurface surface;
        const int planes = std::abs(p) + std::abs(q);
        for (int m = -planes; m <= planes; ++m) {
            const Vec3 on_plane = frame.col(2) * frame.col(2).dot(Vec3(p, 0, q)) * (m + offset) / (norm * norm);
            const Vec3 middle = on_plane + frame.col(0) * frame.col(0).dot(Vec3(0.5, 0.0, 0.5)) + 0.5 * Vec3::UnitY();
            const double distance = std::abs(frame.col(2).dot(Vec3(0.5, 0.5, 0.5) - middle));
            if (distance < 0.75) add_plate(surface, middle, frame, {0.75, 0.6, 0.5 * thickness});
        }
        const auto solid = std::make_shared<const SurfaceSolid>(surface, box());
        return pore_space_of(solid, box(), {0.0, 1.0}, 1.0);
    }
    // Poiseuille flow between the plates; the force along z has the component sin^2 of the plates' slope along z.
    [[nodiscard]] double gap() const { return 1.0 / std::hypot(p, q) - thickness; }
    [[nodiscard]] double along() const { return static_cast<double>(p * p) / (p * p + q * q); }
    [[nodiscard]] double permeability() const { return gap() * gap() / 12.0 * gap() * std::hypot(p, q) * along(); }
};

TEST(ThinWalls, PlatesOfAFifthOfAVoxelLetNothingThrough) {
    // Upright plates, 45 degrees, slopes of 1/2 and 1/3: at every resolution the interval holds Poiseuille's k.
    for (const auto& [p, q] : {std::pair(2, 0), std::pair(1, 1), std::pair(2, 1), std::pair(1, 2), std::pair(3, 1)})
        for (const int cells : {24, 36}) {
            const Plates plates{.p = p, .q = q, .thickness = 0.2 / cells, .offset = 0.3137};
            const LbmResult result = lbm_permeability(plates.space(), 1.0 / cells, {});
            ASSERT_TRUE(result.interval_m2()) << p << q;
            EXPECT_LT(result.interval_m2()->low, plates.permeability()) << p << q << " " << cells;
            EXPECT_GT(result.interval_m2()->high, plates.permeability()) << p << q << " " << cells;
            // With open links these flows do not become steady.
            EXPECT_NEAR(result.permeability_m2 / plates.permeability(), 1.0, 0.02) << p << q << " " << cells;
        }
}

// Diffusion along the plates: the slope alone. A plate that leaked would have less. There is no interval, because the error is of first
// order here: faces beside the plates are those of whole cells.
TEST(ThinWalls, PlatesOfAFifthOfAVoxelLetNothingDiffuse) {
    constexpr int cells = 24;
    for (const auto& [p, q] : {std::pair(2, 0), std::pair(1, 1), std::pair(2, 1), std::pair(3, 1)}) {
        const Plates plates{.p = p, .q = q, .thickness = 0.2 / cells, .offset = 0.3137};
        const DiffusiveEstimate found = diffusive_tortuosity(plates.space(), 1.0 / cells, Axis::z);
        EXPECT_FALSE(found.interval()) << p << q;
        EXPECT_GT(found.value() * plates.along(), 0.98) << p << q;
        EXPECT_LT(found.value() * plates.along(), 1.1) << p << q;
    }
}

TEST(ThinWalls, AClosingPlateDoesNotPercolate) {
    const Plates across{.p = 0, .q = 1, .thickness = 0.005, .offset = 0.3137};  // nothing passes along z
    EXPECT_THROW((void)lbm_permeability(across.space(), 1.0 / 20, {.grids = 1}), DoesNotPercolate);
    EXPECT_THROW((void)diffusive_tortuosity(across.space(), 1.0 / 20, Axis::z), DoesNotPercolate);
    // Along the plate the pores are straight.
    EXPECT_NEAR(diffusive_tortuosity(across.space(), 1.0 / 20, Axis::x).value(), 1.0, 1e-6);
    // The plate in the periodic face, and beyond the end planes of a box with walls: between the last centres and the mirror.
    const Plates in_face{.p = 0, .q = 1, .thickness = 0.005, .offset = 0.0};
    EXPECT_THROW((void)lbm_permeability(in_face.space(), 1.0 / 20, {.grids = 1}), DoesNotPercolate);
    geometry::TriangleSurface lid;
    add_plate(lid, {0.5, 0.5, 0.99}, Eigen::Matrix3d::Identity(), {0.6, 0.6, 0.003});
    const Container walls = parse_container("box:1,1,2");
    const PoreSpace under_lid = pore_space_of(std::make_shared<const SurfaceSolid>(lid, walls), walls, {0.0, 1.0}, 1.0);
    EXPECT_THROW((void)lbm_permeability(under_lid, 1.0 / 20, {.grids = 1}), DoesNotPercolate);
}

// Brute force: every pair of neighbouring pore cells, by the segment between their centres.
std::int64_t closed_links(const PhaseImage& image, const Drive& drive, const packing::Grains& grains) {
    const auto& grid = image.grid;
    std::int64_t count = 0;
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
        if (image.phase[cell] != Phase::pore) continue;
        const auto at = grid.place(cell);
        for (std::size_t q = 1; q < d3q19::directions; ++q) {
            auto there = at;
            if (!step_in_grid(grid, drive, there, d3q19::c[q]) || image.phase[grid.index(there[0], there[1], there[2])] != Phase::pore)
                continue;
            const Vec3 from(grid.centre(0, at[0]), grid.centre(1, at[1]), grid.centre(2, at[2]));
            const Vec3 step = grid.spacing_m[0] * Vec3(d3q19::c[q][0], d3q19::c[q][1], d3q19::c[q][2]);
            for (const auto& of : grains.images()) {
                const bool hit = std::any_of(of.capsules.begin(), of.capsules.end(), [&](const Capsule& capsule) {
                    return closest_points({from, step}, {capsule.a, capsule.b - capsule.a}).distance < capsule.radius;
                });
                if (!hit) continue;
                ++count;
                break;
            }
        }
    }
    return count;
}

TEST(ThinWalls, AllLinksThatGrainsCrossAreFound) {
    // Random tetrapods, from grains thinner than a voxel to ten voxels per diameter; across periodic sides and at a cylinder's wall.
    for (const auto& [container, section] :
         {std::pair("box:1,1,1:periodic", Section{0.0, 1.0}), std::pair("cylinder:1,1", Section{0.0, 1.0})})
        for (const double radius : {0.01, 0.03, 0.1}) {
            const Packing packing = random_bed(container, 20, radius);
            const Grains grains(packing);
            const PoreSpace space = pore_space_of(packing).with_section(section);
            const PhaseImage image = voxelise(grains, packing.container, section,
                                              plan_voxels(packing.container, section, 0.05, {}, 1.0).grid, space.kept_solid());
            const Drive drive{.axis = 2, .periodic = packing.container.periodic()};
            const LinkCuts cuts = find_cuts(image, *space.walls(), drive);
            const std::int64_t expected = closed_links(image, drive, grains);
            EXPECT_GT(expected, 10) << container << radius;
            if (drive.by_pressure()) {  // links through the open ends are counted too
                EXPECT_GE(cuts.count(), expected) << container << radius;
                EXPECT_LE(cuts.count(), expected + expected / 2) << container << radius;
            } else {
                EXPECT_EQ(cuts.count(), expected) << container << radius;
            }
        }
}

TEST(ThinWalls, BothKernelsObeyThem) {
    const Packing packing = random_bed("box:1,1,1:periodic", 20, 0.03);
    const Scene scene(packing, {0.0, 1.0}, 1.0 / 24);
    ASSERT_GT(scene.domain.cuts.count(), 100);
    const Scheme scheme{.tau = 0.8, .force = {0, 0, 1e-4}};
    const auto fast = make_flow(Kernel::cpu_double, scene.domain, scheme), slow = make_flow(Kernel::reference, scene.domain, scheme);
    for (int pair = 0; pair < 10; ++pair) {
        fast->advance_two_steps();
        slow->advance_two_steps();
    }
    std::vector<Moments> one(scene.domain.nodes()), other(scene.domain.nodes());
    fast->moments(0, one);
    slow->moments(0, other);
    double largest = 0.0, difference = 0.0;
    for (std::size_t i = 0; i < one.size(); ++i)
        for (std::size_t a = 0; a < 3; ++a) {
            largest = std::max(largest, std::abs(other[i].velocity[a]));
            difference = std::max(difference, std::abs(one[i].velocity[a] - other[i].velocity[a]));
        }
    EXPECT_LT(difference, 1e-12 * largest + 1e-15);  // rounding
}

TEST(ThinWalls, NothingPassesThroughAnEdgeThatTwoSolidVoxelsShare) {
    // A channel between side walls, closed by an oblique wall of voxels that touch by edges, apart from a gap at its end. The image with
    // every voxel divided into 27 has the same geometry.
    const int n = 24, gap = 6;
    const auto image_of = [&](int factor) {
        PhaseImage image{.grid = {.cells = {n * factor, 1, n * factor}}, .phase = {}, .notes = {}};
        image.phase.assign(image.grid.size(), Phase::pore);
        for (int k = 0; k < n * factor; ++k)
            for (int i = 0; i < (n - gap) * factor; ++i)
                if (k / factor == i / factor + 2) image.phase[image.grid.index(i, 0, k)] = Phase::grain;
        return image;
    };
    const Drive drive{.axis = 2, .periodic = {false, true, true}};
    const auto k_of = [&](int factor) {
        const Domain domain = build_domain(image_of(factor), drive, nullptr);
        const Scheme scheme{.magic = 3.0 / 16.0, .walls = Walls::bounce_back, .force = {0, 0, 1e-3}};
        const auto flow = make_flow(Kernel::cpu_double, domain, scheme);
        const StokesRun run =
            run_to_steady(*flow, domain, scheme, {.area_cells = static_cast<double>(n * factor), .last_layer = n * factor - 1},
                          {.tolerance = 1e-5, .max_steps = 200000});
        return run.permeability_lu / (factor * factor);
    };
    const double coarse = k_of(1), fine = k_of(3);
    std::printf("  one voxel per step: k %.4f, three: %.4f\n", coarse, fine);
    // The walls of the coarse image cost 10 % in the gap of six voxels. With the edges open the ratio is 1.22.
    EXPECT_NEAR(coarse / fine, 1.0, 0.15);
    // Seventeen edges between eighteen voxels; each link has two ends.
    EXPECT_EQ(build_domain(image_of(1), drive, nullptr).cuts.count(), 2 * (n - gap - 1));
}

}  // namespace
}  // namespace porepack
