// What it costs to divide a flow into two slabs, each with one thread of this process: against one part with two threads, and with
// messages that take longer.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "benchmarks/lbm_speed.hpp"
#include "core/communicator.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/median.hpp"
#include "lbm/domain.hpp"
#include "lbm/flow.hpp"
#include "packing/grains.hpp"
#include "packing/packing.hpp"
#include "pore_space/voxels.hpp"
#include "pore_space/walls.hpp"

namespace porepack::benchmarks {
namespace {

// The messages of `parts` take `seconds` longer, and a part may or may not compute meanwhile. Counts bytes and the seconds of waiting.
class SlowMessages : public Communicator {
public:
    SlowMessages(const Communicator& parts, double seconds, bool may_compute)
        : parts_(parts), seconds_(seconds), may_compute_(may_compute) {}
    [[nodiscard]] int parts() const override { return parts_.parts(); }
    [[nodiscard]] int part() const override { return parts_.part(); }
    [[nodiscard]] std::unique_ptr<Transfer> begin_exchange(const std::array<std::span<const std::byte>, 2>& to,
                                                           const std::array<std::span<std::byte>, 2>& from) const override {
        bytes += static_cast<double>(to[0].size() + to[1].size());
        auto transfer = std::make_unique<Slow>(*this, parts_.begin_exchange(to, from));
        if (!may_compute_) transfer->finish();
        return transfer;
    }
    [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> mine) const override { return parts_.gather(mine); }
    void in_turn(std::span<double> numbers, const std::function<void()>& add) const override { parts_.in_turn(numbers, add); }

    mutable double bytes = 0.0, waited_s = 0.0;

private:
    class Slow : public Transfer {
    public:
        Slow(const SlowMessages& of, std::unique_ptr<Transfer> real) : of_(of), real_(std::move(real)) {}
        void finish() override {
            if (!real_) return;
            const double before = watch_.seconds();
            std::this_thread::sleep_for(std::chrono::duration<double>(of_.seconds_ - before));
            real_->finish();
            real_.reset();
            of_.waited_s += watch_.seconds() - before;
        }

    private:
        const SlowMessages& of_;
        std::unique_ptr<Transfer> real_;
        Stopwatch watch_;
    };
    const Communicator& parts_;
    double seconds_;
    bool may_compute_;
};

struct Scene {
    Packing packing;
    Grid grid;
    [[nodiscard]] Domain domain(const Communicator& slabs) const {
        const Grains grains(packing);
        const Section section{0.0, 1.0};
        const FlowWalls walls{grains, packing.container, section};
        const int n = grid.cells[2], part = slabs.part();
        const Grid own = slabs.parts() == 1 ? grid : grid.slab_of(n * part / slabs.parts(), n * (part + 1) / slabs.parts(), true);
        return build_domain(voxelise(grains, packing.container, section, own), choose_drive(packing.container, Axis::z), &walls, 0.0,
                            slabs);
    }
};

struct Rate {
    double updates_per_second, bytes_per_exchange, share_of_waiting;
};

// The median of five times, with as many threads as there are cores in one part, or one in each of two.
Rate rate_of(const Scene& scene, int parts, double latency_s, bool may_compute) {
    Rate rate{};
    const auto measure = [&](const Communicator& given) {
        const SlowMessages slabs(given, latency_s, may_compute);
        const Domain domain = scene.domain(slabs);
        const auto flow = make_flow(Kernel::cpu_double, domain, {.walls = Walls::interpolated, .force = {0, 0, 1e-3}});
        const auto nodes = static_cast<double>(domain.all_nodes);
        const int pairs = static_cast<int>(std::max(5.0, 2e7 / nodes));
        std::vector<double> seconds(5);
        flow->advance_two_steps();
        slabs.bytes = slabs.waited_s = 0.0;
        double all = 0.0;
        for (double& one : seconds) {
            const Stopwatch watch;
            for (int pair = 0; pair < pairs; ++pair) flow->advance_two_steps();
            one = watch.seconds();
            all += one;
        }
        if (slabs.part() == 0)
            rate = {2.0 * pairs * nodes / median(std::move(seconds)), slabs.bytes / (10.0 * pairs), slabs.waited_s / all};
    };
    const int threads = thread_count();
    set_thread_count(parts == 1 ? threads : 1);
    parts == 1 ? measure(no_communicator()) : run_parts(parts, measure);
    set_thread_count(threads);
    return rate;
}

}  // namespace

Json slabs_benchmark(bool quick) {
    constexpr double porosity = 0.7, latency_s = 1e-3;
    Json rows = Json::array();
    for (const double nodes : quick ? std::vector{2e5} : std::vector{2e5, 1e6, 5.5e6}) {
        const int cells = static_cast<int>(std::lround(std::cbrt(nodes / porosity)));
        Scene scene{overlapping_spheres("box:1,1,1:periodic", porosity, 10.0 / cells), {}};
        scene.grid = plan_voxels(scene.packing.container, {0.0, 1.0}, 1.0 / cells, {}, 1.0).grid;
        const Rate one = rate_of(scene, 1, 0.0, true);
        Json row = {{"cells", scene.grid.cells}, {"one_part_updates_per_second", one.updates_per_second}};
        struct Variant {
            const char* name;
            double latency_s;
            bool may_compute;
        };
        for (const auto& [name, latency, may_compute] :
             {Variant{"two_parts", 0.0, true}, {"messages_of_1_ms", latency_s, true}, {"messages_of_1_ms_waited_for", latency_s, false}}) {
            const Rate two = rate_of(scene, 2, latency, may_compute);
            row[name] = {{"rate_over_one_part", two.updates_per_second / one.updates_per_second},
                         {"share_of_waiting", two.share_of_waiting}};
            row["bytes_per_exchange"] = two.bytes_per_exchange;
        }
        log_info("{}", row.dump());
        rows.push_back(row);
    }
    return {{"rows", rows}};
}

}  // namespace porepack::benchmarks
