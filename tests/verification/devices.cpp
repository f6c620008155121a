// Flows computed by a device: the populations, sums and permeabilities of the fast kernel. On a machine without a graphics card the device
// is the processor itself, through PoCL.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/json.hpp"
#include "core/log.hpp"
#include "lbm/inertia.hpp"
#include "lbm/lattice.hpp"
#include "lbm/permeability.hpp"
#include "lbm/sequence.hpp"
#include "lbm/solver.hpp"
#include "packing/packing.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"
#include "support/watched_device.hpp"

namespace porepack {
namespace {

using namespace test;

class Devices : public testing::Test {
protected:
    void SetUp() override {
        const auto all = devices::find_devices();
        REQUIRE_INSTALLED(!all.empty(), "a device of OpenCL (Debian: pocl-opencl-icd)");
        device = std::make_shared<WatchedDevice>(devices::open_device(all.front().id));
    }
    std::unique_ptr<Flow> start(const Domain& domain, const Scheme& scheme, bool single_precision) const {
        return plan_flow(device, single_precision, domain)->start(scheme);
    }
    std::shared_ptr<WatchedDevice> device;
};

std::vector<double> populations_of(const Flow& flow, const Domain& domain) {
    std::vector<std::byte> bytes(domain.nodes() * d3q19::directions * flow.bytes_per_number());
    flow.populations(0, bytes);
    std::vector<double> numbers(domain.nodes() * d3q19::directions);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (flow.bytes_per_number() == sizeof(float)) {
            float value = 0;
            std::memcpy(&value, bytes.data() + i * sizeof(float), sizeof(float));
            numbers[i] = value;
        } else {
            std::memcpy(&numbers[i], bytes.data() + i * sizeof(double), sizeof(double));
        }
    }
    return numbers;
}

// Over the largest number.
double largest_difference(const std::vector<double>& left, const std::vector<double>& right) {
    double largest = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < left.size(); ++i) {
        scale = std::max(scale, std::abs(left[i]));
        largest = std::max(largest, std::abs(left[i] - right[i]));
    }
    return largest / scale;
}

// 20 pairs of steps, with densities added on the way.
std::vector<double> populations_after(Flow& flow, const Domain& domain) {
    std::vector<double> added(domain.nodes());
    for (std::size_t i = 0; i < added.size(); ++i) added[i] = 1e-3 * static_cast<double>(i % 7);
    for (int pair = 0; pair < 20; ++pair) {
        flow.advance_two_steps();
        if (pair == 10) flow.add_density(0, added);
    }
    return populations_of(flow, domain);
}

struct DeviceScene {
    const char* name;
    Scene scene;
};
std::vector<DeviceScene> scenes() {
    std::vector<DeviceScene> list;
    list.push_back({"periodic", Scene(random_bed("box:1,1,1:periodic", 14, 0.08), {0, 1}, 1.0 / 24)});
    list.push_back({"planes", Scene(random_bed("cylinder:1,1", 10, 0.08), {0.1, 0.9}, 1.0 / 24)});
    list.push_back({"reservoirs", Scene(random_bed("cylinder:1,1", 10, 0.08), {0.1, 0.9}, 1.0 / 21, 0.1)});
    return list;
}

TEST_F(Devices, AgreeWithTheFastKernel) {
    for (const auto& [name, scene] : scenes()) {
        EXPECT_GT(scene.domain.narrow_share(), 0.01) << name;  // gaps of one node
        EXPECT_NE(scene.domain.nodes() % 128, 0U) << name;     // the last chunk is partly filled
        std::vector<Scheme> schemes;
        for (const Walls walls : {Walls::interpolated, Walls::bounce_back})
            schemes.push_back({.tau = 0.7, .walls = walls, .force = {1e-4, 2e-4, 1e-3}});
        for (const Model model : {Model::navier_stokes, Model::regularised, Model::recursive})
            schemes.push_back({.tau = 0.8, .model = model, .force = {1e-5, 0, 1e-4}});
        for (const Scheme& scheme : schemes)
            for (const bool single : {false, true}) {
                const auto here = make_flow(single ? Kernel::cpu_single : Kernel::cpu_double, scene.domain, scheme);
                const auto there = start(scene.domain, scheme, single);
                const double difference =
                    largest_difference(populations_after(*here, scene.domain), populations_after(*there, scene.domain));
                EXPECT_LT(difference, single ? 1e-5 : 1e-12) << name << ", model " << static_cast<int>(scheme.model);
                const auto drag_here = here->drag(scene.domain), drag_there = there->drag(scene.domain);
                EXPECT_NEAR(drag_there[2] / drag_here[2], 1.0, single ? 1e-4 : 1e-10) << name;
            }
    }
}

TEST_F(Devices, ShowASmallChangeOfAWeight) {
    const Scene scene = std::move(scenes().front().scene);
    const Scheme scheme{.force = {0, 0, 1e-3}};
    const auto here = make_flow(Kernel::cpu_double, scene.domain, scheme);
    const std::vector<double> expected = populations_after(*here, scene.domain);
    device->replaced = "w1 = (real)(1.0 / 18.0)";
    device->by = "w1 = (real)((1.0 + 1e-7) / 18.0)";
    EXPECT_GT(largest_difference(expected, populations_after(*start(scene.domain, scheme, false), scene.domain)), 1e-10);
}

TEST_F(Devices, SumOverLayersAsTheProcessorDoes) {
    const Packing box = random_bed("box:1,1,1:periodic", 14, 0.08);
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
        const Scene scene(box, {0, 1}, 1.0 / 30, 0.0, axis);
        Scheme scheme{.force = {}};
        scheme.force[static_cast<std::size_t>(scene.drive.axis)] = 1e-3;
        const auto here = make_flow(Kernel::cpu_double, scene.domain, scheme), there = start(scene.domain, scheme, false);
        std::vector<double> added(scene.domain.layers());
        for (std::size_t l = 0; l < added.size(); ++l) added[l] = 1e-3 * static_cast<double>(l % 5);
        for (Flow* flow : {here.get(), there.get()}) {
            for (int pair = 0; pair < 5; ++pair) flow->advance_two_steps();
            flow->add_to_layers(scene.domain, added);
            flow->advance_two_steps();
        }
        const Layers a = here->layers(scene.domain), b = there->layers(scene.domain);
        // Another flow of the same plan does not change what is known of this one.
        const auto plan = plan_flow(device, false, scene.domain);
        const auto first = plan->start(scheme), second = plan->start(scheme);
        first->advance_two_steps();
        const double flow_rate = first->layers(scene.domain).flow[3];
        second->add_to_layers(scene.domain, added);
        EXPECT_NEAR(second->layers(scene.domain).flow[3], 0.5e-3 * a.nodes[3], 1e-12 * a.nodes[3]);  // at rest: half the force
        EXPECT_EQ(first->layers(scene.domain).flow[3], flow_rate);
        EXPECT_EQ(a.nodes, b.nodes);
        for (const auto quantity :
             {&Layers::flow, &Layers::power, &Layers::kinetic, &Layers::kinetic_flux, &Layers::elastic, &Layers::density})
            EXPECT_LT(largest_difference(a.*quantity, b.*quantity), 1e-11);
        const FlowSums one = here->sums(scene.domain, 3, 20), other = there->sums(scene.domain, 3, 20);
        EXPECT_EQ(one.nodes, other.nodes);
        EXPECT_NEAR(other.speed / one.speed, 1.0, 1e-12);
        EXPECT_NEAR(other.along / one.along, 1.0, 1e-12);
        EXPECT_NEAR(other.squares / one.squares, 1.0, 1e-12);
        EXPECT_NEAR(other.fastest / one.fastest, 1.0, 1e-12);
        EXPECT_NEAR(other.density / one.density, 1.0, 1e-9);
        for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(other.velocity[i], one.velocity[i], 1e-12 * one.nodes);
    }
}

TEST_F(Devices, SplitWhatTheDriverDoesNotGiveInOnePiece) {
    const Scene scene = std::move(scenes()[1].scene);
    const Scheme scheme{.force = {0, 0, 1e-3}};
    const std::vector<double> whole = populations_after(*start(scene.domain, scheme, false), scene.domain);
    const std::size_t bytes = whole.size() * sizeof(double);
    device->largest_buffer = bytes * 2 / 5;
    EXPECT_TRUE(populations_after(*start(scene.domain, scheme, false), scene.domain) == whole);
    device->largest_buffer = bytes / 16;  // more than eight pieces
    EXPECT_THROW((void)start(scene.domain, scheme, false), MachineError);
}

// Spheres at known permeability, by the whole sequence of grids.
TEST_F(Devices, GiveThePermeabilityOfTheProcessor) {
    const PoreSpace array = pore_space_of(sphere_array(0.343, 0.0, simple_cubic(), Vec3(0.01, 0.02, 0.03)).packing),
                    dense = pore_space_of(sphere_array(0.6, 0.0, body_centred(), Vec3(0.013, 0.027, 0.041)).packing),
                    bed = pore_space_of(random_bed("cylinder:1,2", 30, 0.1)).with_section({0.7, 1.3}).with_ends(Ends::in_situ, 0.3);
    for (const PoreSpace* space : {&array, &dense, &bed})
        for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
            LbmConfig config;
            config.precision = precision;
            const bool single = precision == Precision::single_precision;
            const LbmResult here = lbm_permeability(*space, 0.05, config),
                            there = lbm_permeability(*space, 0.05, config, {.device = device});
            ASSERT_EQ(here.grids.size(), there.grids.size());
            EXPECT_NEAR(there.permeability_m2 / here.permeability_m2, 1.0, single ? 1e-4 : 1e-9);
            if (!single) EXPECT_EQ(there.fine().run.steps, here.fine().run.steps);
            EXPECT_NEAR(there.fine().run.hydraulic_tortuosity / here.fine().run.hydraulic_tortuosity, 1.0, single ? 1e-4 : 1e-9);
        }
}

// Steady flows with inertia between end planes, whose pressure follows the flow there.
TEST_F(Devices, GiveTheFlowsWithInertia) {
    const PoreSpace bed = pore_space_of(random_bed("cylinder:1,2", 30, 0.1)).with_section({0.7, 1.3}).with_ends(Ends::in_situ, 0.3);
    const std::vector<double> reynolds = {5.0};
    const InertialSeries here = lbm_inertial_flows(bed, 0.05, reynolds, 0.2, {}),
                         there = lbm_inertial_flows(bed, 0.05, reynolds, 0.2, {.device = device});
    EXPECT_NEAR(there.creeping_permeability_m2 / here.creeping_permeability_m2, 1.0, 1e-8);
    ASSERT_EQ(here.flows.size(), 1U);
    ASSERT_EQ(there.flows.size(), 1U);
    EXPECT_NEAR(there.flows[0].permeability_m2 / here.flows[0].permeability_m2, 1.0, 1e-8);
}

// Small enough for a checker of memory (tests/install/check_gpu_memory): two chunks, end planes, gaps of one node.
TEST_F(Devices, RunEveryKernel) {
    const Scene scene(random_bed("cylinder:1,1", 10, 0.08), {0.1, 0.9}, 1.0 / 8);
    EXPECT_GT(scene.domain.nodes(), 128U);
    EXPECT_GT(scene.domain.narrow_share(), 0.0);
    for (const Model model : {Model::stokes, Model::recursive}) {
        const auto flow = start(scene.domain, {.model = model, .force = {0, 0, 1e-3}}, false);
        std::vector<Moments> moments(scene.domain.nodes());
        flow->advance_two_steps();
        flow->moments(0, moments);
        flow->set_moments(0, moments);
        flow->add_to_layers(scene.domain, std::vector<double>(scene.domain.layers(), 1e-3));
        flow->advance_two_steps();
        EXPECT_GT(flow->sums(scene.domain, 0, 3).along, 0.0);
        EXPECT_GT(flow->drag(scene.domain)[2], 0.0);
    }
}

TEST_F(Devices, MoveLittleBetweenChecks) {
    const Scene scene(random_bed("cylinder:1,4", 40, 0.08), {0.1, 3.9}, 1.0 / 24);
    const Scheme scheme{.force = {0, 0, 1e-3}};
    const FlowSection section = flow_section(scene.image.grid, scene.packing.container, scene.section, scene.drive);
    const auto flow = start(scene.domain, scheme, true);
    device->bytes_moved = 0;
    const StokesRun run = run_to_steady(*flow, scene.domain, scheme, section, {.tolerance = 1e-4});
    std::printf("  %zu nodes, %zu layers, %ld steps: %.0f bytes per step\n", scene.domain.nodes(), scene.domain.layers(), run.steps,
                static_cast<double>(device->bytes_moved) / static_cast<double>(run.steps));
    EXPECT_LT(device->bytes_moved, 4096U * static_cast<std::size_t>(run.steps));
    // A note: two states are summed per check, 40 steps apart.
    const auto seconds_of = [&](const std::function<void()>& work) {
        double best = 1e300;
        for (int trial = 0; trial < 5; ++trial) {
            flow->advance_two_steps();
            device->finish();
            const Stopwatch watch;
            work();
            device->finish();
            best = std::min(best, watch.seconds());
        }
        return best;
    };
    const double checks = 2.0 * seconds_of([&] { (void)flow->layers(scene.domain); }),
                 steps = 20.0 * seconds_of([&] { flow->advance_two_steps(); });
    std::printf("  checks take %.1f %% of the time\n", 100.0 * checks / (checks + steps));
}

// A checkpoint of one device is resumed by another, with the same steps; a lost device leaves it.
TEST_F(Devices, ResumeFromACheckpointOfAnother) {
    const Folder folder;
    const PoreSpace bed = pore_space_of(random_bed("cylinder:1,2", 30, 0.1)).with_section({0.3, 1.7});
    LbmConfig config;
    config.grids = 1;
    config.relaxation_time = 1.0;
    config.iteration_tolerance = 1e-5;
    config.checkpoint_minutes = 1e-4;
    const Path checkpoint = folder.path() / "lbm.checkpoint";
    const LbmResult whole = lbm_permeability(bed, 0.05, config);
    device->runs_until_lost = 300;
    EXPECT_THROW((void)lbm_permeability(bed, 0.05, config, {.checkpoint = checkpoint, .device = device}), devices::DeviceLost);
    ASSERT_TRUE(std::filesystem::exists(checkpoint));
    const LbmResult here = lbm_permeability(bed, 0.05, config, {.checkpoint = checkpoint});
    EXPECT_EQ(here.fine().run.steps, whole.fine().run.steps);
    EXPECT_NEAR(here.permeability_m2 / whole.permeability_m2, 1.0, 1e-9);
    EXPECT_FALSE(std::filesystem::exists(checkpoint));
}

TEST_F(Devices, AreNamedInTheResult) {
    const Folder folder;
    const Path packing = folder.path() / "packing.json";
    Packing bed = random_bed("cylinder:1,2", 30, 0.1);
    bed.overlap_allowed = true;
    write_packing(packing, bed);
    const std::string lbm =
                          "lbm " + quoted(packing) + " --section 0.3,1.7 --voxel-size 0.05 --json --output " + quoted(folder.path()) + " ",
                      id = device->info().id;
    const Output found = porepack(lbm + "--device " + id);
    ASSERT_EQ(found.exit_code, 0) << found.err;
    EXPECT_EQ(found.json().at("device").get<std::string>(), id + " (" + device->info().name + ")");
    EXPECT_EQ(read_json(folder.path() / "lbm.manifest.json").at("configuration").at("lbm").at("device"), id);
    const Output listed = porepack("devices --json");
    ASSERT_EQ(listed.exit_code, 0) << listed.err;
    EXPECT_EQ(listed.json().at("devices").at(0).at("id"), id);
    EXPECT_GT(listed.json().at("devices").at(0).at("copy_bytes_per_second"), 1e8);
    const Output dry = porepack(lbm + "--dry-run --device " + id);
    EXPECT_TRUE(has(dry.out, "of " + id + " (")) << dry.out << dry.err;
    for (const std::string& wrong : {std::string("card"), std::string("opencl:99"), id + " --ranks 2"}) {
        const Output refused = porepack(lbm + "--dry-run --device " + wrong);
        EXPECT_EQ(refused.exit_code, 2) << wrong << refused.out;
        EXPECT_TRUE(has(refused.err, "--device") || has(refused.err, "porepack devices")) << refused.err;
    }
}

TEST_F(Devices, AreRefusedByName) {
    const std::string message = message_of<UserError>([] { (void)devices::open_device("opencl:99"); });
    EXPECT_TRUE(has(message, "opencl:99") && has(message, "opencl:0 (")) << message;
    const Scene scene = std::move(scenes()[0].scene);
    EXPECT_TRUE(devices::is_device_name("cpu") && devices::is_device_name("gpu") && devices::is_device_name("opencl:1"));
    for (const char* name : {"", "opencl", "opencl:", "opencl:-1", "opencl:1x", "cuda", "GPU"})
        EXPECT_FALSE(devices::is_device_name(name)) << name;
    EXPECT_GT(devices::copy_bandwidth(*device), 1e8);
}

}  // namespace
}  // namespace porepack
