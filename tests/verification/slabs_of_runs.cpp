// Runs on slabs give the permeability, the tensor, the flows with inertia and the checkpoints of runs on the whole grid, to the last bit.
#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "core/communicator.hpp"
#include "core/context.hpp"
#include "core/interrupt.hpp"
#include "core/members_json.hpp"
#include "lbm/checkpoint.hpp"
#include "lbm/inertia.hpp"
#include "lbm/sequence.hpp"
#include "pore_space/pore_space.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"
#include "support/known_flows.hpp"

namespace porepack {
namespace {

using namespace test;

template <typename T>
void append(std::vector<T>& list, const std::vector<T>& more) {
    list.insert(list.end(), more.begin(), more.end());
}

// Grids from coarse to fine, each started from the one before, the search for the best relaxation time, and the flow field.
struct Sequenced {
    LbmResult result;
    FlowImage flow;
};

Sequenced sequence_of(const PoreSpace& space, double voxel_size_m, const LbmConfig& config, const Communicator& slabs) {
    Sequenced found{.result = lbm_permeability(space, voxel_size_m, config, {.with_flow = true, .parts = &slabs}), .flow = {}};
    found.flow = found.result.flow.of_own();
    return found;
}

struct SequencedScene {
    std::string name;
    PoreSpace space;
    double voxel_size_m;
    LbmConfig config;
};

TEST(SlabsOfRuns, GiveThePermeabilityOfAllGrids) {
    const PoreSpace bed = pore_space_of(random_bed("cylinder:1,2", 30, 0.1)),
                    box = pore_space_of(random_bed("box:1,1,1:periodic", 20, 0.1));
    LbmConfig three, along_x, to_tolerance;
    along_x.direction = Axis::x;
    to_tolerance.tolerance = 0.2;
    const std::vector<SequencedScene> list = {{"planes", bed.with_section({0.3, 1.7}), 0.05, three},
                                              {"in situ", bed.with_section({0.7, 1.3}).with_ends(Ends::in_situ, 0.3), 0.05, three},
                                              {"periodic along z", box, 0.045, three},
                                              {"periodic along x", box, 0.045, along_x},
                                              {"to a tolerance", bed.with_section({0.4, 1.6}), 0.0, to_tolerance}};
    for (const auto& [name, space, voxel_size_m, config] : list) {
        const Sequenced whole = sequence_of(space, voxel_size_m, config, no_communicator());
        EXPECT_GE(whole.result.grids.size(), 3U) << name;
        for (const int parts : name == "planes" ? std::vector{2, 3} : std::vector{2}) {
            std::vector<Sequenced> of_parts(static_cast<std::size_t>(parts));
            run_parts(parts, [&](const Communicator& slabs) {
                of_parts[static_cast<std::size_t>(slabs.part())] = sequence_of(space, voxel_size_m, config, slabs);
            });
            const std::string where = name + ", slabs: " + std::to_string(parts);
            for (const auto& [result, flow] : of_parts) {
                EXPECT_EQ(result.permeability_m2, whole.result.permeability_m2) << where;
                EXPECT_EQ(result.half_width->sum(), whole.result.half_width->sum()) << where;
                ASSERT_EQ(result.grids.size(), whole.result.grids.size()) << where;
                for (std::size_t grid = 0; grid < result.grids.size(); ++grid) {
                    EXPECT_EQ(result.grids[grid].run.steps, whole.result.grids[grid].run.steps) << where;
                    EXPECT_EQ(result.grids[grid].permeability_m2, whole.result.grids[grid].permeability_m2) << where;
                    EXPECT_EQ(result.grids[grid].nodes, whole.result.grids[grid].nodes) << where;
                    EXPECT_EQ(result.grids[grid].wall_links, whole.result.grids[grid].wall_links) << where;
                    EXPECT_EQ(result.grids[grid].cells, whole.result.grids[grid].cells) << where;
                }
            }
            FlowImage flow = of_parts[0].flow;
            for (std::size_t part = 1; part < of_parts.size(); ++part) {
                append(flow.velocity_m_per_s, of_parts[part].flow.velocity_m_per_s);
                append(flow.pressure_Pa, of_parts[part].flow.pressure_Pa);
                append(flow.phase, of_parts[part].flow.phase);
            }
            EXPECT_TRUE(flow.velocity_m_per_s == whole.flow.velocity_m_per_s) << where;
            EXPECT_TRUE(flow.pressure_Pa == whole.flow.pressure_Pa) << where;
            EXPECT_TRUE(flow.phase == whole.flow.phase) << where;
        }
    }
}

TEST(SlabsOfRuns, GiveTheTensor) {
    const PoreSpace box = pore_space_of(random_bed("box:1,1,1:periodic", 20, 0.1));
    LbmConfig config;
    config.grids = 1;
    config.iteration_tolerance = 1e-3;
    const TensorResult whole = lbm_tensor(box, 0.05, config);
    run_parts(3, [&](const Communicator& slabs) {
        EXPECT_EQ(lbm_tensor(box, 0.05, config, {.parts = &slabs}).permeability_m2, whole.permeability_m2);
    });
}

TEST(SlabsOfRuns, GiveTheFlowsWithInertia) {
    const KnownFlow cell = sphere_array(0.343, 15.39949, simple_cubic()), layers = three_layers(0.343, 15.39949);
    PoreSpace in_situ = pore_space_of(layers.packing).with_section({2.0, 3.0}).with_ends(Ends::in_situ, 2.0);
    in_situ.reservoir_m = 1.0;
    const InertialCriterion steady{.tolerance = 1e-3}, in_time{.in_time = InertialCriterion::InTime{.tolerance = 0.02}};
    const std::array<double, 2> reynolds = {5.0, 20.0};
    for (const auto& [space, voxel, criterion] : {std::tuple(in_situ, 1.0 / 10, steady), {cell.space(), 1.0 / 12, in_time}}) {
        const auto flows = [&](const Communicator& slabs) {
            Json series = json_of(lbm_inertial_flows(space, voxel, reynolds, cell.diameter_m, criterion, slabs));
            for (Json& flow : series.at("flows")) flow.erase("wall_time_s");
            return series;
        };
        const Json whole = flows(no_communicator());
        EXPECT_EQ(whole.at("flows").size(), 2U) << whole.dump(2);
        run_parts(2, [&](const Communicator& slabs) { EXPECT_EQ(flows(slabs), whole); });
    }
}

// Interrupted when it has written some checkpoints, in the same call of all parts.
void interrupt_after(int checkpoints, const std::function<void()>& work) {
    std::atomic<int> written = 0;
    const Context context{.log =
                              [&](auto, std::string_view text) {
                                  if (has(std::string(text), "checkpoint at step")) ++written;
                              },
                          .progress = [](auto, auto, auto, auto) {},
                          .interrupted = [&] { return written >= checkpoints; }};
    const ContextScope scope(context);
    EXPECT_THROW(work(), Interrupted);
}

TEST(SlabsOfRuns, ResumeWithAnyNumberOfParts) {
    const PoreSpace bed = pore_space_of(random_bed("cylinder:1,2", 30, 0.1)).with_section({0.3, 1.7});
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
        LbmConfig config;
        config.precision = precision;
        config.iteration_tolerance = 1e-4;
        config.checkpoint_minutes = 1e-9;  // at each check
        const LbmResult whole = lbm_permeability(bed, 0.05, config, {.parts = &no_communicator()});
        const Folder folder;
        const Path file = folder.path() / "lbm.checkpoint";
        const auto solve = [&](int parts) {
            std::vector<double> found(static_cast<std::size_t>(parts));
            const auto of_part = [&](const Communicator& slabs) {
                found[static_cast<std::size_t>(slabs.part())] =
                    lbm_permeability(bed, 0.05, config, {.checkpoint = file, .parts = &slabs}).permeability_m2;
            };
            parts == 1 ? of_part(no_communicator()) : run_parts(parts, of_part);
            for (const double k : found) EXPECT_EQ(k, whole.permeability_m2);
        };
        interrupt_after(5, [&] { solve(2); });
        interrupt_after(5, [&] { solve(3); });
        interrupt_after(5, [&] { solve(1); });
        EXPECT_TRUE(std::filesystem::exists(file));
        const SavedRun saved = read_checkpoint(file);
        EXPECT_GT(saved.run.steps, 0);
        solve(4);
        EXPECT_FALSE(std::filesystem::exists(file));
    }
}

TEST(SlabsOfRuns, AreNotThinnerThanWhatTheyExchange) {
    const PoreSpace bed = pore_space_of(random_bed("cylinder:1,2", 30, 0.1)).with_section({0.4, 1.6});
    const auto solve_on_twelve = [&] {
        run_parts(12, [&](const Communicator& slabs) { (void)lbm_permeability(bed, 0.1, {}, {.parts = &slabs}); });
    };
    EXPECT_THROW(solve_on_twelve(), UserError);
}

}  // namespace
}  // namespace porepack
