// A grid that is divided into slabs gives the domain, the populations and the permeability of the whole grid, to the last bit.
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/communicator.hpp"
#include "lbm/lattice.hpp"
#include "lbm/layers.hpp"
#include "lbm/sequence.hpp"
#include "lbm/solver.hpp"
#include "pore_space/pore_space.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"
#include "support/known_flows.hpp"

namespace porepack {
namespace {

using namespace test;

struct DividedScene {
    std::string name;
    std::function<PhaseImage(const Grid&)> phases;
    Grid grid;
    Drive drive;
    FlowSection section;
    std::optional<FlowWalls> walls = {};
    std::shared_ptr<const PoreSpace> space = {};
    std::vector<std::vector<int>> cuts;  // the first layers of all slabs but the lowest
};

DividedScene scene_of(const std::string& name, PoreSpace pores, double voxel_size_m, Axis axis, std::vector<std::vector<int>> cuts) {
    const auto space = std::make_shared<const PoreSpace>(std::move(pores));
    DividedScene scene{.name = name,
                       .phases = [space](const Grid& grid) { return space->phases_on(grid); },
                       .grid = space->plan_at(voxel_size_m).grid,
                       .drive = choose_drive(space->container, axis),
                       .section = {},
                       .walls = space->walls(),
                       .space = space,
                       .cuts = std::move(cuts)};
    scene.section = flow_section(scene.grid, space->container, space->section, scene.drive);
    return scene;
}

// Pore cells where `open` says so.
DividedScene scene_of(const std::string& name, const std::array<int, 3>& cells, const Drive& drive,
                      const std::function<bool(const std::array<int, 3>&)>& open, std::vector<std::vector<int>> cuts) {
    const auto phases = [open](const Grid& grid) {
        PhaseImage image{.grid = grid, .phase = std::vector<std::uint8_t>(grid.size()), .notes = {}};
        for (std::size_t cell = 0; cell < grid.size(); ++cell) {
            std::array<int, 3> at = grid.place(cell);
            at[2] = grid.layer(at[2]);
            image.phase[cell] = open(at) ? Phase::pore : Phase::grain;
        }
        return image;
    };
    const auto axis = static_cast<std::size_t>(drive.axis);
    const double area = static_cast<double>(cells[(axis + 1) % 3]) * cells[(axis + 2) % 3];
    return {.name = name,
            .phases = phases,
            .grid = {.cells = cells},
            .drive = drive,
            .section = {.area_cells = area, .first_layer = 0, .last_layer = cells[axis] - 1},
            .cuts = std::move(cuts)};
}

Scheme scheme_along(int axis) {
    Scheme scheme;
    scheme.tau = 1.1;
    scheme.force = {};
    scheme.force[static_cast<std::size_t>(axis)] = 1e-3;
    return scheme;
}

// What a grid, whole or divided, gave; nodes have the numbers of the whole.
struct Solution {
    std::vector<std::size_t> cells;
    std::vector<std::array<std::size_t, 4>> links;
    std::vector<std::uint32_t> cuts;
    std::vector<std::array<double, 19>> populations;
    std::vector<double> conductance;
    std::int64_t isolated_cells = 0, all_nodes = 0;
    StokesRun run;
    std::array<double, 3> drag{};
};

Solution solve(const DividedScene& scene, const Grid& grid, Kernel kernel, const Communicator& slabs) {
    const PhaseImage image = scene.phases(grid);
    const Domain domain = build_domain(image, scene.drive, scene.walls ? &*scene.walls : nullptr, 0.0, slabs);
    const Scheme scheme = scheme_along(scene.drive.axis);
    const auto flow = make_flow(kernel, domain, scheme);
    const ConvergenceCriterion criterion{.tolerance = 1e-3, .max_steps = 200, .progress = [](auto, auto, auto) {}};
    Solution solution{.conductance = domain.layer_conductance,
                      .isolated_cells = domain.isolated_cells,
                      .all_nodes = domain.all_nodes,
                      .run = run_to_steady(*flow, domain, scheme, scene.section, criterion)};
    solution.drag = flow->drag(domain);

    std::size_t below = 0, cells_below = 0;  // nodes, cells
    const std::array<std::size_t, 1> own = {domain.nodes()};
    const std::vector<Bytes> all = slabs.gather(std::as_bytes(std::span(own)));
    for (int part = 0; part < slabs.part(); ++part) below += list_of<std::size_t>(all[static_cast<std::size_t>(part)])[0];
    cells_below = domain.grid.index(0, 0, 1) * static_cast<std::size_t>(domain.grid.slab.first);
    domain.cells.for_each([&](std::size_t cell) {
        solution.cells.push_back(cells_below + cell);
        solution.cuts.push_back(domain.cuts.links(cell));
    });
    for (const WallLink& link : domain.walls) solution.links.push_back({below + link.node, link.q, link.distance, link.narrow});
    for (const BoundaryLink& link : domain.boundary_links)
        solution.links.push_back({below + link.node, link.q, below + link.source, link.source_q});
    solution.populations.resize(domain.nodes());
    flow->populations(0, std::as_writable_bytes(std::span(solution.populations)));
    return solution;
}

template <typename T>
void append(std::vector<T>& list, const std::vector<T>& more) {
    list.insert(list.end(), more.begin(), more.end());
}

// The lists of all slabs, one after the other.
Solution solve_divided(const DividedScene& scene, std::vector<int> cuts, Kernel kernel) {
    const int count = static_cast<int>(cuts.size()) + 1;
    cuts.insert(cuts.begin(), 0);
    cuts.push_back(scene.grid.cells[2]);
    std::vector<Solution> parts(static_cast<std::size_t>(count));
    run_parts(count, [&](const Communicator& slabs) {
        const auto part = static_cast<std::size_t>(slabs.part());
        parts[part] = solve(scene, scene.grid.slab_of(cuts[part], cuts[part + 1], scene.drive.periodic[2]), kernel, slabs);
    });
    Solution all = parts[0];
    for (std::size_t part = 1; part < parts.size(); ++part) {
        append(all.cells, parts[part].cells);
        append(all.links, parts[part].links);
        append(all.cuts, parts[part].cuts);
        append(all.populations, parts[part].populations);
        EXPECT_EQ(parts[part].run.permeability_lu, all.run.permeability_lu);  // all slabs know the result
        EXPECT_EQ(parts[part].conductance, all.conductance);
        EXPECT_EQ(parts[part].all_nodes, all.all_nodes);
    }
    return all;
}

std::vector<DividedScene> scenes() {
    std::vector<DividedScene> list;
    const std::vector<std::vector<int>> two_and_five = {{11}, {1, 2, 9, 17}};
    // Grains that overlap, with gaps of one node, isolated cells and plates between nodes.
    const auto bed = [] { return pore_space_of(random_bed("cylinder:1,2", 30, 0.1)); };
    list.push_back(scene_of("planes", bed().with_section({0.6, 1.4}), 0.05, Axis::z, {{8}, {1, 2, 7, 12}}));
    list.push_back(scene_of("in situ", bed().with_section({0.7, 1.3}).with_ends(Ends::in_situ, 0.3), 0.05, Axis::z, two_and_five));
    const auto box = [] { return pore_space_of(random_bed("box:1,1,1:periodic", 20, 0.08)); };
    for (const Axis axis : {Axis::x, Axis::y, Axis::z})
        list.push_back(scene_of(std::string("periodic along ") + name_of(axis).data(), box(), 0.05, axis, two_and_five));
    // The lowest and the highest slab are neighbours, and each has one layer.
    list.push_back(scene_of("two layers", {9, 8, 2}, {.axis = 2, .periodic = {true, true, true}},
                            [](const auto& at) { return at[0] != 4 || at[1] == 2; }, {{1}}));
    list.push_back(scene_of("a throat of one node on the cut", {9, 9, 12}, {.axis = 2},
                            [](const auto& at) { return (at[2] != 6 && at[2] != 5) || (at[0] == 3 && at[1] == 4); },
                            {{6}, {5, 6}, {5, 6, 7, 11}}));
    list.push_back(scene_of("a slab without fluid", {8, 9, 12}, {.axis = 0, .periodic = {true, true, false}},
                            [](const auto& at) { return at[2] < 4 || at[2] > 7; }, {{6}, {4, 8}, {5, 6, 7, 8}}));
    // Diagonal steps across which two solid cells meet: no link is open there, and a stair that winds round the box.
    list.push_back(scene_of("solids that meet at edges", {6, 6, 12}, {.axis = 2, .periodic = {true, true, true}},
                            [](const auto& at) { return (at[0] + at[2]) % 3 != 0 || (at[1] == 2 && at[2] % 2 == 0) || at[1] == 5; },
                            {{5}, {3, 4, 5, 9}}));
    return list;
}

TEST(Slabs, GiveTheBitsOfTheWholeGrid) {
    std::int64_t isolated_cells = 0, closed_links = 0;
    for (const DividedScene& scene : scenes())
        for (const Kernel kernel : {Kernel::cpu_double, Kernel::reference}) {
            const Solution whole = solve(scene, scene.grid, kernel, no_communicator());
            EXPECT_GT(whole.run.permeability_lu, 0.0) << scene.name;
            EXPECT_GT(whole.run.steps, 40) << scene.name;
            isolated_cells += whole.isolated_cells;
            closed_links += std::count_if(whole.cuts.begin(), whole.cuts.end(), [](std::uint32_t links) { return links != 0; });
            for (const std::vector<int>& cuts : scene.cuts) {
                const std::string where = scene.name + ", slabs: " + std::to_string(cuts.size() + 1);
                const Solution divided = solve_divided(scene, cuts, kernel);
                EXPECT_EQ(divided.all_nodes, whole.all_nodes) << where;
                EXPECT_EQ(divided.isolated_cells, whole.isolated_cells) << where;
                EXPECT_EQ(divided.cells, whole.cells) << where;
                EXPECT_EQ(divided.cuts, whole.cuts) << where;
                EXPECT_EQ(divided.conductance, whole.conductance) << where;
                auto links = divided.links, of_whole = whole.links;  // walls, then open ends, of each slab
                std::sort(links.begin(), links.end());
                std::sort(of_whole.begin(), of_whole.end());
                EXPECT_EQ(links, of_whole) << where;
                EXPECT_EQ(divided.run.steps, whole.run.steps) << where;
                EXPECT_EQ(divided.run.permeability_lu, whole.run.permeability_lu) << where;
                EXPECT_EQ(divided.run.hydraulic_tortuosity, whole.run.hydraulic_tortuosity) << where;
                EXPECT_EQ(divided.run.layers.flow, whole.run.layers.flow) << where;
                EXPECT_EQ(divided.drag, whole.drag) << where;
                EXPECT_TRUE(divided.populations == whole.populations) << where;
            }
        }
    EXPECT_GT(isolated_cells, 0);
    EXPECT_GT(closed_links, 0);
}

// Counts what a part sends.
class Counting : public Communicator {
public:
    explicit Counting(const Communicator& parts) : parts_(parts) {}
    [[nodiscard]] int parts() const override { return parts_.parts(); }
    [[nodiscard]] int part() const override { return parts_.part(); }
    [[nodiscard]] std::unique_ptr<Transfer> begin_exchange(const std::array<std::span<const std::byte>, 2>& to,
                                                           const std::array<std::span<std::byte>, 2>& from) const override {
        bytes += to[0].size() + to[1].size();
        ++exchanges;
        return parts_.begin_exchange(to, from);
    }
    [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> mine) const override { return parts_.gather(mine); }
    void in_turn(std::span<double> numbers, const std::function<void()>& add) const override { parts_.in_turn(numbers, add); }
    mutable std::size_t bytes = 0, exchanges = 0;

private:
    const Communicator& parts_;
};

// One population for each link between two nodes on both sides of the cut, twice in two steps.
TEST(Slabs, ExchangeOneNumberPerLinkAcrossTheCut) {
    const DividedScene scene = scenes().front();
    constexpr int cut = 8;
    const Domain whole = build_domain(scene.phases(scene.grid), scene.drive, &*scene.walls);
    std::size_t links = 0, open_links = 0;
    whole.cells.for_each([&](std::size_t cell) {
        const auto here = whole.grid.place(cell);
        for (int q = 1; q < d3q19::directions; ++q) {
            const auto& c = d3q19::c[static_cast<std::size_t>(q)];
            if (here[2] != cut - 1 || c[2] <= 0) continue;
            ++open_links;
            if (!whole.cuts.closed(cell, c) && whole.node_beside(here, c) >= 0) ++links;
        }
    });
    EXPECT_GT(links, 100U);
    EXPECT_LT(links, open_links);
    run_parts(2, [&](const Communicator& parts) {
        const Counting slabs(parts);
        const int layers = scene.grid.cells[2];
        const Grid own = slabs.part() == 0 ? scene.grid.slab_of(0, cut, false) : scene.grid.slab_of(cut, layers, false);
        const Domain domain = build_domain(scene.phases(own), scene.drive, &*scene.walls, 0.0, slabs);
        for (const Kernel kernel : {Kernel::cpu_double, Kernel::cpu_single}) {
            const auto flow = make_flow(kernel, domain, scheme_along(2));
            slabs.bytes = slabs.exchanges = 0;
            for (int pair = 0; pair < 5; ++pair) flow->advance_two_steps();
            EXPECT_EQ(slabs.exchanges, 10U);
            EXPECT_EQ(slabs.bytes, 10 * links * flow->bytes_per_number());
        }
    });
}

TEST(Slabs, NeedTheCommunicatorOfAll) {
    const DividedScene scene = scenes().front();
    EXPECT_THROW((void)solve(scene, scene.grid.slab_of(0, 5, false), Kernel::cpu_double, no_communicator()), std::logic_error);
}

}  // namespace
}  // namespace porepack
