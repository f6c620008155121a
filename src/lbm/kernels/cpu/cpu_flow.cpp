#include "lbm/kernels/cpu/cpu_flow.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/communicator.hpp"
#include "core/pages.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm::cpu {
namespace {

// The kernel reads moments as four consecutive numbers.
static_assert(sizeof(Moments) == 4 * sizeof(double) && offsetof(Moments, density) == 0);

template <typename Real>
const KernelFunctions<Real>& kernel_of(const InstructionSet& set) {
    if constexpr (sizeof(Real) == 4)
        return *set.single_precision;
    else
        return *set.double_precision;
}

// Addresses, walls and boundary links of a domain.
template <typename Real>
class CpuPlan : public FlowPlan, public std::enable_shared_from_this<CpuPlan<Real>> {
public:
    explicit CpuPlan(const Domain& domain)
        : kernel(kernel_of<Real>(chosen_instruction_set())),
          slabs(*domain.slabs),
          nodes(domain.nodes()),
          chunks(chunks_for(nodes)),
          addresses(find_addresses(domain)),
          schedule(addresses, chunks),
          walls(domain) {
        std::size_t link = 0;
        for (std::size_t c = 0; c <= chunks; ++c) {
            first_boundary.push_back(static_cast<std::uint32_t>(boundary.size()));
            for (; link < domain.boundary_links.size() && domain.boundary_links[link].node < (c + 1) * chunk_nodes; ++link) {
                const BoundaryLink& here = domain.boundary_links[link];
                boundary.push_back({static_cast<std::uint16_t>(here.q * chunk_nodes + here.node - c * chunk_nodes),
                                    static_cast<Real>(here.sign), static_cast<Real>(here.added)});
            }
        }
    }
    [[nodiscard]] std::unique_ptr<Flow> start(const Scheme& scheme) const override;

    const KernelFunctions<Real>& kernel;
    const Communicator& slabs;
    const std::size_t nodes, chunks;
    const Addresses addresses;
    const Schedule schedule;
    const ChunkedWalls walls;
    std::vector<BoundaryPlace<Real>> boundary;
    std::vector<std::uint32_t> first_boundary;
};

template <typename Real>
class CpuFlow : public Flow {
public:
    CpuFlow(std::shared_ptr<const CpuPlan<Real>> plan, const Scheme& scheme)
        : plan_(std::move(plan)),
          kernel_(plan_->kernel),
          boundary_(plan_->boundary),
          store_(plan_->addresses.slots + d3q19::directions * chunk_nodes) {
        fill_data(scheme);
    }

    void advance_two_steps() override {
        const Schedule& schedule = plan_->schedule;
        if (plan_->slabs.parts() == 1) return kernel_.two_steps(data_, 0, schedule.parts.size());
        const std::size_t middle = (schedule.inside + schedule.border) / 2;
        kernel_.two_steps(data_, 0, schedule.inside);
        exchange(&SharedSlots::own, &SharedSlots::beyond, schedule.inside, middle);
        kernel_.two_steps(data_, schedule.border, schedule.parts.size());
        exchange(&SharedSlots::beyond, &SharedSlots::own, middle, schedule.border);
    }
    void moments(std::size_t first, std::span<Moments> moments) const override {
        for_chunks(first, moments,
                   [&](std::size_t node, std::span<Moments> some) { kernel_.moments(data_, node, some.data(), some.size()); });
    }
    void set_moments(std::size_t first, std::span<const Moments> moments) override {
        for_chunks(first, moments,
                   [&](std::size_t node, std::span<const Moments> some) { kernel_.set_moments(data_, node, some.data(), some.size()); });
    }
    void add_density(std::size_t first, std::span<const double> added) override {
        kernel_.add_density(data_, first, added.data(), added.size());
    }
    void set_boundary_links(std::span<const double> added) override {
        for (std::size_t l = 0; l < boundary_.size(); ++l) boundary_[l].added = static_cast<Real>(added[l]);
    }
    void forget(std::size_t first, std::size_t end) override {
        const bool last = end == plan_->nodes;
        store_.release(slot_of(0, first), last ? store_.size() : slot_of(0, end / chunk_nodes * chunk_nodes));
    }
    void populations(std::size_t first, std::span<std::byte> of_nodes) const override {
        for_numbers(first, of_nodes.size(),
                    [&](std::size_t slot, std::size_t byte) { std::memcpy(of_nodes.data() + byte, store_.data() + slot, sizeof(Real)); });
    }
    void set_populations(std::size_t first, std::span<const std::byte> of_nodes) override {
        for_numbers(first, of_nodes.size(),
                    [&](std::size_t slot, std::size_t byte) { std::memcpy(store_.data() + slot, of_nodes.data() + byte, sizeof(Real)); });
    }
    [[nodiscard]] std::size_t bytes_per_number() const override { return sizeof(Real); }
    void wall_forces(std::size_t first, std::span<std::array<double, 3>> forces) const override {
        kernel_.wall_forces(data_, first, forces.data()->data(), forces.size());
    }
    [[nodiscard]] double bytes() const override {
        return static_cast<double>(store_.size() * sizeof(Real)) + plan_->addresses.bytes() + plan_->walls.bytes() +
               static_cast<double>(sizeof(BoundaryPlace<Real>) * boundary_.size());
    }

private:
    // Visits the slot of each population of the nodes from `first` on, with its place in a list of so many bytes.
    template <typename Visit>
    static void for_numbers(std::size_t first, std::size_t bytes, const Visit& visit) {
        for (std::size_t byte = 0, node = first; byte < bytes; ++node)
            for (std::size_t q = 0; q < d3q19::directions; ++q, byte += sizeof(Real)) visit(slot_of(q, node), byte);
    }
    // Some chunks at a time, by all threads; one is visited by the thread that calls.
    template <typename T, typename Visit>
    static void for_chunks(std::size_t first, std::span<T> list, const Visit& visit) {
        if (list.size() <= chunk_nodes) return visit(first, list);
        const std::size_t some = 16 * chunk_nodes;
#pragma omp parallel for schedule(static)
        for (std::size_t done = 0; done < list.size(); done += some)
            visit(first + done, list.subspan(done, std::min(some, list.size() - done)));
    }
    using Slots = std::vector<std::uint64_t> SharedSlots::*;
    // Sends what the slots `from` hold to the slabs below and above, and puts what they send in the slots `to`; makes these parts of the
    // schedule meanwhile.
    void exchange(Slots from, Slots to, std::size_t first_part, std::size_t end_part) {
        for (std::size_t side = 0; side < 2; ++side) {
            const SharedSlots& shared = plan_->addresses.shared[side];
            sent_[side].clear();
            for (const std::uint64_t slot : shared.*from) sent_[side].push_back(store_.data()[slot]);
            received_[side].resize((shared.*to).size());
        }
        const auto transfer =
            plan_->slabs.begin_exchange({core::bytes_of(sent_[0]), core::bytes_of(sent_[1])},
                                        {std::as_writable_bytes(std::span(received_[0])), std::as_writable_bytes(std::span(received_[1]))});
        // Long messages move only while the library of messages is called.
        constexpr std::size_t pieces = 8;
        for (std::size_t piece = 0; piece < pieces; ++piece) {
            const auto at = [&](std::size_t p) { return first_part + (end_part - first_part) * p / pieces; };
            if (at(piece) == at(piece + 1)) continue;
            kernel_.two_steps(data_, at(piece), at(piece + 1));
            transfer->move_on();
        }
        transfer->finish();
        for (std::size_t side = 0; side < 2; ++side) {
            const std::vector<std::uint64_t>& slots = plan_->addresses.shared[side].*to;
            for (std::size_t s = 0; s < slots.size(); ++s) store_.data()[slots[s]] = received_[side][s];
        }
    }

    void fill_data(const Scheme& scheme) {
        const WallRule rule = scheme.wall_rule();
        data_ = {.store = store_.data(),
                 .nodes = plan_->nodes,
                 .chunks = plan_->chunks,
                 .groups = plan_->addresses.groups.data(),
                 .singles = plan_->addresses.singles.data(),
                 .first_single = plan_->addresses.first_single.data(),
                 .first_wall = plan_->walls.first.data(),
                 .wall_row = plan_->walls.row.data(),
                 .wall_distance = plan_->walls.distance.data(),
                 .first_gap = plan_->walls.first_gap.data(),
                 .gaps = plan_->walls.gaps.data(),
                 .first_boundary = plan_->first_boundary.data(),
                 .boundary = boundary_.data(),
                 .parts = plan_->schedule.parts.data(),
                 .odd_order = plan_->schedule.odd_order.data(),
                 .interpolated = scheme.walls == Walls::interpolated,
                 .model = scheme.model,
                 .rate_plus = static_cast<Real>(scheme.rate_plus()),
                 .rate_minus = static_cast<Real>(scheme.rate_minus()),
                 .wall_shift = static_cast<Real>(rule.shift),
                 .wall_magic = static_cast<Real>(rule.magic),
                 .wall_bound = static_cast<Real>(rule.bound),
                 .wall_limit = static_cast<Real>(rule.limit)};
        for (std::size_t a = 0; a < 3; ++a) {
            data_.force[a] = static_cast<Real>(scheme.force[a]);
            data_.force_lu[a] = scheme.force[a];
        }
        for (int q = 0; q < d3q19::directions; ++q) data_.force_term[q] = static_cast<Real>(scheme.force_term(q));
    }

    std::shared_ptr<const CpuPlan<Real>> plan_;
    const KernelFunctions<Real>& kernel_;
    std::vector<BoundaryPlace<Real>> boundary_;  // of this flow: their values may change
    core::Pages<Real> store_;                    // each thread touches its chunks first, in the first step (NUMA placement)
    KernelData<Real> data_{};
    std::array<std::vector<Real>, 2> sent_, received_;  // populations on their way to and from the slabs below and above
};

template <typename Real>
std::unique_ptr<Flow> CpuPlan<Real>::start(const Scheme& scheme) const {
    return std::make_unique<CpuFlow<Real>>(this->shared_from_this(), scheme);
}

}  // namespace

std::shared_ptr<const FlowPlan> plan_flow(const Domain& domain, bool single_precision) {
    if (single_precision) return std::make_shared<const CpuPlan<float>>(domain);
    return std::make_shared<const CpuPlan<double>>(domain);
}

}  // namespace porepack::lbm::cpu
