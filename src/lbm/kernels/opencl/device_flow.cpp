#include "lbm/kernels/opencl/device_flow.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lbm/kernels/layout/addresses.hpp"
#include "lbm/kernels/layout/chunked_walls.hpp"
#include "lbm/kernels/opencl/layer_blocks.hpp"
#include "lbm/kernels/opencl/store.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm::opencl {

extern const std::string_view lattice_text;
#ifdef POREPACK_WITH_CUDA
extern "C" const char porepack_ptx_lattice_float[], porepack_ptx_lattice_double[];
#endif

namespace {

#ifdef POREPACK_WITH_CUDA
template <typename Real>
constexpr const char* ptx_of = sizeof(Real) == 4 ? porepack_ptx_lattice_float : porepack_ptx_lattice_double;
#else
template <typename Real>
constexpr const char* ptx_of = nullptr;
#endif

using devices::Argument;
using devices::Buffer;
using devices::Device;
using namespace layout;

constexpr std::size_t rows = d3q19::directions * chunk_nodes, quantities = 12, maximum = 11;

template <typename Real>
struct End {
    std::uint16_t row;
    Real sign, added;
};

template <typename Real>
struct Rates {
    Real rate_plus, rate_minus, wall_shift, wall_magic, wall_bound, wall_limit;
    Real force[3], term[9];

    explicit Rates(const Scheme& scheme)
        : rate_plus(static_cast<Real>(scheme.rate_plus())),
          rate_minus(static_cast<Real>(scheme.rate_minus())),
          wall_shift(static_cast<Real>(scheme.wall_rule().shift)),
          wall_magic(static_cast<Real>(scheme.wall_rule().magic)),
          wall_bound(static_cast<Real>(scheme.wall_rule().bound)),
          wall_limit(static_cast<Real>(scheme.wall_rule().limit)) {
        for (std::size_t a = 0; a < 3; ++a) force[a] = static_cast<Real>(scheme.force[a]);
        for (int k = 0; k < 9; ++k) term[k] = static_cast<Real>(scheme.force_term(2 * k + 1));
    }
};

template <typename T>
std::unique_ptr<Buffer> on_device(Device& device, const std::vector<T>& list) {
    auto buffer = device.allocate(list.size() * sizeof(T));
    device.write(*buffer, 0, std::as_bytes(std::span(list)));
    return buffer;
}

// Addresses, walls, ends and layers of a domain, on the device.
template <typename Real>
class DevicePlan : public FlowPlan, public std::enable_shared_from_this<DevicePlan<Real>> {
public:
    DevicePlan(std::shared_ptr<Device> on, const Domain& domain)
        : device(std::move(on)),
          nodes(domain.nodes()),
          chunks(chunks_for(nodes)),
          layers(domain.layers()),
          axis(domain.drive.axis),
          blocks(domain) {
        if (domain.slabs->parts() > 1)
            throw UserError("a device computes a flow of one process", {.fix = "choose --device cpu, or no --ranks"});
        {
            const Addresses addresses = find_addresses(domain);
            groups = on_device(*device, addresses.groups);
            singles = on_device(*device, addresses.singles);
            first_single = on_device(*device, addresses.first_single);
        }
        {
            const ChunkedWalls walls(domain);
            first_wall = on_device(*device, walls.first);
            wall_row = on_device(*device, walls.row);
            wall_distance = on_device(*device, walls.distance);
            first_gap = on_device(*device, walls.first_gap);
            gaps = on_device(*device, walls.gaps);
            for (std::size_t c = 0; c < chunks; ++c)
                known = std::max(known, walls.first[c + 1] - walls.first[c] + 2 * (walls.first_gap[c + 1] - walls.first_gap[c]));
        }
        std::vector<std::uint32_t> first;
        std::size_t link = 0;
        for (std::size_t c = 0; c <= chunks; ++c) {
            first.push_back(static_cast<std::uint32_t>(ends.size()));
            for (; link < domain.boundary_links.size() && domain.boundary_links[link].node < (c + 1) * chunk_nodes; ++link) {
                const BoundaryLink& here = domain.boundary_links[link];
                ends.push_back({static_cast<std::uint16_t>(here.q * chunk_nodes + here.node - c * chunk_nodes),
                                static_cast<Real>(here.sign), static_cast<Real>(here.added)});
            }
        }
        first_end = on_device(*device, first);
        order = on_device(*device, blocks.order);
        first_in_block = on_device(*device, blocks.first_in_block);
        layer_of_block = on_device(*device, blocks.layer_of_block);
        layer = on_device(*device, blocks.layer);
        block_of_layer = on_device(*device, blocks.block_of_layer);
        std::uint64_t max_blocks = 0;
        for (const LayerBlocks::Batch& batch : blocks.batches) max_blocks = std::max(max_blocks, batch.blocks);
        of_nodes = device->allocate(4 * sizeof(double) * std::min(LayerBlocks::batch_nodes, chunks * chunk_nodes));
        of_blocks = device->allocate(quantities * sizeof(double) * max_blocks);
    }
    [[nodiscard]] std::unique_ptr<Flow> start(const Scheme& scheme) const override;

    [[nodiscard]] double bytes() const {
        double sum = 0.0;
        for (const auto* buffer : {&groups, &singles, &first_single, &first_wall, &wall_row, &wall_distance, &first_gap, &gaps, &first_end,
                                   &order, &first_in_block, &layer_of_block, &layer, &block_of_layer, &of_nodes, &of_blocks})
            sum += static_cast<double>((*buffer)->bytes());
        return sum;
    }

    const std::shared_ptr<Device> device;
    const std::size_t nodes, chunks, layers;
    const int axis;
    std::unique_ptr<Buffer> groups, singles, first_single, first_wall, wall_row, wall_distance, first_gap, gaps, first_end;
    std::vector<End<Real>> ends;
    std::uint64_t known = 0;  ///< numbers that a chunk's walls need at most
    const LayerBlocks blocks;
    std::unique_ptr<Buffer> order, first_in_block, layer_of_block, layer, block_of_layer;
    std::unique_ptr<Buffer> of_nodes, of_blocks;  ///< of the batch that is summed; for one flow at a time, within one call
};

constexpr std::array model_names = {"stokes", "navier_stokes", "regularised", "recursive"};

template <typename Real>
class DeviceFlow : public Flow {
public:
    DeviceFlow(std::shared_ptr<const DevicePlan<Real>> plan, const Scheme& scheme)
        : plan_(std::move(plan)),
          device_(*plan_->device),
          rates_(scheme),
          half_force_{0.5 * scheme.force[0], 0.5 * scheme.force[1], 0.5 * scheme.force[2]},
          interpolated_(scheme.walls == Walls::interpolated),
          model_(model_names[static_cast<std::size_t>(scheme.model)]),
          store_(device_, plan_->chunks * rows),
          ends_(plan_->ends),
          ends_on_device_(on_device(device_, ends_)),
          of_layers_(device_.allocate(quantities * sizeof(double) * plan_->layers)) {
        std::vector<std::string> definitions = {"PIECES=" + std::to_string(store_.pieces())};
        if constexpr (sizeof(Real) == 8) definitions.emplace_back("DOUBLE");
        const std::string text = std::string(devices::kernel_language) + std::string(lattice_text);
        program_ = device_.compile({.text = text, .definitions = definitions, .ptx = store_.pieces() == 1 ? ptx_of<Real> : nullptr});
    }

    void advance_two_steps() override {
        const std::scoped_lock one(mutex_);
        are_summed_ = false;
        std::vector<Argument> even = on_chunks(), odd = on_chunks();
        even.emplace_back(shared(rows + plan_->known));
        device_.run(*program_, std::string("even_step_") + model_, plan_->chunks, chunk_nodes, even);
        for (const auto* list : {&plan_->groups, &plan_->singles, &plan_->first_single}) odd.emplace_back(**list);
        odd.emplace_back(shared(rows + plan_->known));
        device_.run(*program_, std::string("odd_step_") + model_, plan_->chunks, chunk_nodes, odd);
    }

    [[nodiscard]] Layers layers(const Domain& /*domain*/) const override {
        constexpr std::array parts = {&Layers::nodes,        &Layers::flow,    &Layers::power,  &Layers::kinetic,
                                      &Layers::kinetic_flux, &Layers::elastic, &Layers::density};
        const std::vector<double> totals = layer_totals(parts.size());
        Layers all;
        for (std::size_t v = 0; v < parts.size(); ++v) {
            const auto first = totals.begin() + static_cast<std::ptrdiff_t>(v * plan_->layers);
            (all.*parts[v]).assign(first, first + static_cast<std::ptrdiff_t>(plan_->layers));
        }
        for (std::size_t l = 0; l < plan_->layers; ++l) all.density[l] /= std::max(1.0, all.nodes[l]);
        return all;
    }
    [[nodiscard]] FlowSums sums(const Domain& /*domain*/, int first_layer, int last_layer) const override {
        const std::vector<double> totals = layer_totals(quantities);
        FlowSums sums;
        double square = 0.0;
        for (std::size_t l = 0; l < plan_->layers; ++l) {
            const auto of_layer = [&](std::size_t quantity) { return totals[quantity * plan_->layers + l]; };
            for (std::size_t a = 0; a < 3; ++a) sums.velocity[a] += of_layer(8 + a);
            sums.density += of_layer(6);
            if (of_layer(maximum) > square || std::isnan(of_layer(maximum))) square = of_layer(maximum);
            if (static_cast<int>(l) < first_layer || static_cast<int>(l) > last_layer) continue;
            sums.nodes += of_layer(0);
            sums.along += of_layer(1);
            sums.squares += 2.0 * of_layer(3);
            sums.speed += of_layer(7);
        }
        sums.fastest = std::sqrt(square);
        return sums;
    }
    [[nodiscard]] std::array<double, 3> drag(const Domain& /*domain*/) const override {
        const std::scoped_lock one(mutex_);
        std::array<double, 3> sum{};
        const auto total = device_.allocate(sizeof(sum));
        device_.fill_with_zeros(*total);
        for (const LayerBlocks::Batch& batch : plan_->blocks.batches) {
            find_wall_forces(batch.first_node, batch.nodes);
            const std::vector<Argument> arguments = {*plan_->of_nodes, std::uint64_t{batch.nodes}, *total,
                                                     Argument::SharedBytes{3 * chunk_nodes * sizeof(double)}};
            device_.run(*program_, "add_forces", 1, chunk_nodes, arguments);
        }
        device_.read(*total, 0, std::as_writable_bytes(std::span(sum)));
        return sum;
    }
    void add_to_layers(const Domain& /*domain*/, std::span<const double> added) override {
        const std::scoped_lock one(mutex_);
        are_summed_ = false;
        device_.write(*of_layers_, 0, std::as_bytes(added));
        for (const LayerBlocks::Batch& batch : plan_->blocks.batches) {
            std::vector<Argument> arguments = {*of_layers_, *plan_->layer_of_block, batch.first_layer_of_block};
            add_batch(arguments, batch);
            arguments.emplace_back(*plan_->of_nodes);
            device_.run(*program_, "spread_over_blocks", batch.blocks, chunk_nodes, arguments);
            add_density_of_batch(batch.first_node, batch.nodes);
        }
    }

    void moments(std::size_t first, std::span<Moments> moments) const override {
        const std::scoped_lock one(mutex_);
        for_batches(first, moments.size(), [&](std::size_t node, std::size_t from, std::size_t count) {
            find_moments(node, count);
            device_.read(*plan_->of_nodes, 0, std::as_writable_bytes(moments.subspan(from, count)));
        });
    }
    void wall_forces(std::size_t first, std::span<std::array<double, 3>> forces) const override {
        const std::scoped_lock one(mutex_);
        for_batches(first, forces.size(), [&](std::size_t node, std::size_t from, std::size_t count) {
            find_wall_forces(node, count);
            device_.read(*plan_->of_nodes, 0, std::as_writable_bytes(forces.subspan(from, count)));
        });
    }
    void set_moments(std::size_t first, std::span<const Moments> moments) override {
        const std::scoped_lock one(mutex_);
        are_summed_ = false;
        for_batches(first, moments.size(), [&](std::size_t node, std::size_t from, std::size_t count) {
            device_.write(*plan_->of_nodes, 0, std::as_bytes(moments.subspan(from, count)));
            run_on_nodes("set_moments", node, count,
                         {*plan_->of_nodes, std::uint64_t{count}, half_force_[0], half_force_[1], half_force_[2]}, rows);
        });
    }
    void add_density(std::size_t first, std::span<const double> added) override {
        const std::scoped_lock one(mutex_);
        are_summed_ = false;
        for_batches(first, added.size(), [&](std::size_t node, std::size_t from, std::size_t count) {
            device_.write(*plan_->of_nodes, 0, std::as_bytes(added.subspan(from, count)));
            add_density_of_batch(node, count);
        });
    }
    void set_boundary_links(std::span<const double> added) override {
        const std::scoped_lock one(mutex_);
        are_summed_ = false;
        for (std::size_t l = 0; l < ends_.size(); ++l) ends_[l].added = static_cast<Real>(added[l]);
        device_.write(*ends_on_device_, 0, std::as_bytes(std::span(ends_)));
    }
    void populations(std::size_t first, std::span<std::byte> of_nodes) const override {
        const std::scoped_lock one(mutex_);
        const std::size_t nodes = of_nodes.size() / (d3q19::directions * sizeof(Real));
        std::vector<Real> numbers(chunks_for(nodes) * rows);
        store_.read(slot_of(0, first), numbers);
        for (std::size_t node = 0, byte = 0; node < nodes; ++node)
            for (std::size_t q = 0; q < d3q19::directions; ++q, byte += sizeof(Real))
                std::memcpy(of_nodes.data() + byte, numbers.data() + slot_of(q, node), sizeof(Real));
    }
    void set_populations(std::size_t first, std::span<const std::byte> of_nodes) override {
        const std::scoped_lock one(mutex_);
        are_summed_ = false;
        const std::size_t nodes = of_nodes.size() / (d3q19::directions * sizeof(Real));
        std::vector<Real> numbers(chunks_for(nodes) * rows);
        for (std::size_t node = 0, byte = 0; node < nodes; ++node)
            for (std::size_t q = 0; q < d3q19::directions; ++q, byte += sizeof(Real))
                std::memcpy(numbers.data() + slot_of(q, node), of_nodes.data() + byte, sizeof(Real));
        store_.write(slot_of(0, first), numbers);
    }
    [[nodiscard]] std::size_t bytes_per_number() const override { return sizeof(Real); }
    [[nodiscard]] double bytes() const override { return store_.bytes() + plan_->bytes() + static_cast<double>(ends_on_device_->bytes()); }

private:
    static Argument shared(std::size_t numbers) { return Argument::SharedBytes{numbers * sizeof(Real)}; }
    void add_batch(std::vector<Argument>& arguments, const LayerBlocks::Batch& batch) const {
        for (const Argument& one : {Argument(*plan_->order), Argument(batch.first_order), Argument(std::uint32_t{plan_->blocks.ordered()}),
                                    Argument(*plan_->first_in_block), Argument(batch.first_in_block)})
            arguments.push_back(one);
    }
    // What all kernels that work on chunks begin with.
    [[nodiscard]] std::vector<Argument> on_chunks() const {
        std::vector<Argument> list;
        store_.add_arguments(list);
        for (const Argument& one : {Argument(rates_), Argument(*plan_->first_wall), Argument(*plan_->wall_row),
                                    Argument(*plan_->wall_distance), Argument(*plan_->first_gap), Argument(*plan_->gaps),
                                    Argument(std::uint32_t{interpolated_}), Argument(*plan_->first_end), Argument(*ends_on_device_)})
            list.push_back(one);
        return list;
    }
    // `numbers` of shared memory.
    void run_on_nodes(const std::string& kernel, std::size_t first, std::size_t count, const std::vector<Argument>& more,
                      std::size_t numbers) const {
        std::vector<Argument> arguments = on_chunks();
        arguments.emplace_back(std::uint64_t{first / chunk_nodes});
        for (const Argument& one : more) arguments.push_back(one);
        arguments.push_back(shared(numbers));
        device_.run(*program_, kernel, chunks_for(count), chunk_nodes, arguments);
    }
    void find_moments(std::size_t first, std::size_t count) const {
        run_on_nodes("moments", first, count, {*plan_->of_nodes, half_force_[0], half_force_[1], half_force_[2]}, rows);
    }
    void find_wall_forces(std::size_t first, std::size_t count) const {
        run_on_nodes(std::string("wall_forces_") + model_, first, count, {*plan_->of_nodes}, rows + plan_->known);
    }
    void add_density_of_batch(std::size_t first, std::size_t count) {
        run_on_nodes("add_density", first, count, {*plan_->of_nodes, std::uint64_t{count}}, rows + chunk_nodes);
    }
    template <typename Visit>
    static void for_batches(std::size_t first, std::size_t count, const Visit& visit) {
        for (std::size_t done = 0; done < count; done += LayerBlocks::batch_nodes)
            visit(first + done, done, std::min(LayerBlocks::batch_nodes, count - done));
    }
    // The first quantities of each layer, quantity after quantity, of the flow as it is.
    std::vector<double> layer_totals(std::size_t first_quantities) const {
        const std::scoped_lock one(mutex_);
        if (!are_summed_) sum_layers();
        are_summed_ = true;
        std::vector<double> totals(first_quantities * plan_->layers);
        device_.read(*of_layers_, 0, std::as_writable_bytes(std::span(totals)));
        return totals;
    }
    void sum_layers() const {
        device_.fill_with_zeros(*of_layers_);
        for (const LayerBlocks::Batch& batch : plan_->blocks.batches) {
            find_moments(batch.first_node, batch.nodes);
            std::vector<Argument> sums = {*plan_->of_nodes};
            add_batch(sums, batch);
            sums.emplace_back(static_cast<std::uint32_t>(plan_->axis));
            sums.emplace_back(*plan_->of_blocks);
            sums.emplace_back(Argument::SharedBytes{quantities * chunk_nodes * sizeof(double)});
            device_.run(*program_, "sum_blocks", batch.blocks, chunk_nodes, sums);
            const std::vector<Argument> adds = {*plan_->of_blocks,
                                                *plan_->layer,
                                                batch.first_layer,
                                                *plan_->block_of_layer,
                                                batch.first_block_of_layer,
                                                static_cast<std::uint32_t>(batch.layers),
                                                static_cast<std::uint32_t>(plan_->layers),
                                                *of_layers_};
            device_.run(*program_, "add_blocks", chunks_for(batch.layers * quantities), chunk_nodes, adds);
        }
    }

    std::shared_ptr<const DevicePlan<Real>> plan_;
    Device& device_;
    Rates<Real> rates_;
    std::array<double, 3> half_force_;
    bool interpolated_;
    const char* model_;
    Store<Real> store_;
    std::vector<End<Real>> ends_;
    std::unique_ptr<Buffer> ends_on_device_, of_layers_;
    std::shared_ptr<devices::Program> program_;
    mutable bool are_summed_ = false;  // of_layers_ has the sums of the flow as it is
    mutable std::mutex mutex_;
};

template <typename Real>
std::unique_ptr<Flow> DevicePlan<Real>::start(const Scheme& scheme) const {
    return std::make_unique<DeviceFlow<Real>>(this->shared_from_this(), scheme);
}

}  // namespace

std::shared_ptr<const FlowPlan> plan_flow(const std::shared_ptr<Device>& device, const Domain& domain, bool single_precision) {
    if (single_precision) return std::make_shared<const DevicePlan<float>>(device, domain);
    return std::make_shared<const DevicePlan<double>>(device, domain);
}

}  // namespace porepack::lbm::opencl
