#include "lbm/kernels/cpu/cpu_flow.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace porepack::lbm::cpu {
namespace {

// The kernel reads moments as four consecutive numbers.
static_assert(sizeof(Moments) == 4 * sizeof(double) && offsetof(Moments, density) == 0);

/// Memory that each thread initialises first (NUMA placement), in large pages where available.
template <typename Real>
class Populations {
public:
    explicit Populations(std::size_t count) : count_(count) {
        constexpr std::size_t page = std::size_t{1} << 21;
        bytes_ = (count * sizeof(Real) + page - 1) / page * page;
        data_ = static_cast<Real*>(::operator new (bytes_, std::align_val_t{page}));
        madvise(data_, bytes_, MADV_HUGEPAGE);
    }
    Populations(const Populations&) = delete;
    Populations& operator=(const Populations&) = delete;
    ~Populations() { ::operator delete (data_, std::align_val_t{std::size_t{1} << 21}); }
    [[nodiscard]] Real* data() { return data_; }
    [[nodiscard]] std::size_t size() const { return count_; }

private:
    std::size_t count_, bytes_;
    Real* data_;
};

template <typename Real>
const KernelFunctions<Real>& kernel_of(const InstructionSet& set) {
    if constexpr (sizeof(Real) == 4)
        return *set.single_precision;
    else
        return *set.double_precision;
}

template <typename Real>
class CpuFlow : public Flow {
public:
    CpuFlow(const Domain& domain, const Scheme& scheme)
        : kernel_(kernel_of<Real>(chosen_instruction_set())),
          chunks_((domain.nodes() + chunk_nodes - 1) / chunk_nodes),
          addresses_(find_addresses(domain)),
          schedule_(addresses_, chunks_),
          walls_(domain),
          store_(addresses_.slots + d3q19::directions * chunk_nodes) {
        std::size_t link = 0;
        for (std::size_t c = 0; c <= chunks_; ++c) {
            first_boundary_.push_back(static_cast<std::uint32_t>(boundary_.size()));
            for (; link < domain.boundary_links.size() && domain.boundary_links[link].node < (c + 1) * chunk_nodes; ++link) {
                const BoundaryLink& here = domain.boundary_links[link];
                boundary_.push_back({static_cast<std::uint16_t>(here.q * chunk_nodes + here.node - c * chunk_nodes),
                                     static_cast<Real>(here.sign), static_cast<Real>(here.added)});
            }
        }
#pragma omp parallel for schedule(static)
        for (std::size_t c = 0; c < chunks_; ++c)
            std::memset(store_.data() + slot_of(0, c * chunk_nodes), 0, d3q19::directions * chunk_nodes * sizeof(Real));
        std::memset(store_.data() + addresses_.slots, 0, vector_bytes);
        fill_data(domain, scheme);
    }

    void advance_two_steps() override {
        kernel_.two_steps(data_);
    }
    void moments(std::size_t first, std::span<Moments> moments) const override {
        kernel_.moments(data_, first, moments.data(), moments.size());
    }
    void set_moments(std::size_t first, std::span<const Moments> moments) override {
        kernel_.set_moments(data_, first, moments.data(), moments.size());
    }
    void add_density(std::size_t first, std::span<const double> added) override {
        kernel_.add_density(data_, first, added.data(), added.size());
    }
    void set_boundary_links(std::span<const double> added) override {
        for (std::size_t l = 0; l < boundary_.size(); ++l) boundary_[l].added = static_cast<Real>(added[l]);
    }
    [[nodiscard]] std::span<std::byte> state() override {
        return std::as_writable_bytes(std::span(store_.data(), store_.size()));
    }
    [[nodiscard]] std::array<double, 3> drag() const override {
        std::array<double, 3> force = {0.0, 0.0, 0.0};
        kernel_.drag(data_, force.data());
        return force;
    }
    [[nodiscard]] double bytes() const override {
        return static_cast<double>(store_.size() * sizeof(Real)) + addresses_.bytes() + walls_.bytes() +
               static_cast<double>(sizeof(BoundaryPlace<Real>) * boundary_.size());
    }

private:
    void fill_data(const Domain& domain, const Scheme& scheme) {
        const WallRule rule = scheme.wall_rule();
        data_ = {.store = store_.data(),
                 .nodes = domain.nodes(),
                 .chunks = chunks_,
                 .bases = addresses_.bases.data(),
                 .groups = addresses_.groups.data(),
                 .singles = addresses_.singles.data(),
                 .first_single = addresses_.first_single.data(),
                 .first_wall = walls_.first.data(),
                 .wall_row = walls_.row.data(),
                 .wall_distance = walls_.distance.data(),
                 .first_gap = walls_.first_gap.data(),
                 .gaps = walls_.gaps.data(),
                 .first_boundary = first_boundary_.data(),
                 .boundary = boundary_.data(),
                 .parts = schedule_.parts.data(),
                 .part_count = schedule_.parts.size(),
                 .odd_order = schedule_.odd_order.data(),
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

    const KernelFunctions<Real>& kernel_;
    std::size_t chunks_;
    Addresses addresses_;
    Schedule schedule_;
    ChunkedWalls walls_;
    std::vector<BoundaryPlace<Real>> boundary_;
    std::vector<std::uint32_t> first_boundary_;
    Populations<Real> store_;
    KernelData<Real> data_{};
};

}  // namespace

std::unique_ptr<Flow> make_flow(const Domain& domain, const Scheme& scheme, bool single_precision) {
    if (single_precision) return std::make_unique<CpuFlow<float>>(domain, scheme);
    return std::make_unique<CpuFlow<double>>(domain, scheme);
}

}  // namespace porepack::lbm::cpu
