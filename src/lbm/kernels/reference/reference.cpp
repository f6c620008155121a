// Direct implementation of the method: two copies of the populations, one node after the other, double precision. The fast
// kernel must agree with it to rounding error.
#include "lbm/kernels/reference/reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "lbm/uses.hpp"

namespace porepack::lbm::reference {
namespace {

using d3q19::c;
using d3q19::directions;
using d3q19::opposite;
using Populations = std::array<double, directions>;

std::array<double, 3> momentum(const Populations& f) {
    std::array<double, 3> j{};
    for (std::size_t q = 0; q < directions; ++q)
        for (std::size_t a = 0; a < 3; ++a) j[a] += c[q][a] * f[q];
    return j;
}

double sum(const Populations& f) {
    double rho = 0.0;
    for (const double value : f) rho += value;
    return rho;
}

// Two relaxation times: the symmetric part of each pair towards w rho (with inertia + w (9 (c.u)^2 - 3 u^2)/2), the
// antisymmetric one towards 3 w c.j; then the force.
Populations collide_two_times(const Populations& f, const Scheme& scheme) {
    const double rho = sum(f);
    const auto j = momentum(f);
    std::array<double, 3> u{};
    for (std::size_t a = 0; a < 3; ++a) u[a] = j[a] + 0.5 * scheme.force[a];
    const double u2 = scheme.inertia() ? u[0] * u[0] + u[1] * u[1] + u[2] * u[2] : 0.0;
    Populations after{};
    for (int q = 0; q < directions; ++q) {
        const auto here = static_cast<std::size_t>(q), there = static_cast<std::size_t>(opposite(q));
        const double w = d3q19::w(q);
        const double cj = c[here][0] * j[0] + c[here][1] * j[1] + c[here][2] * j[2];
        const double cu = scheme.inertia() ? c[here][0] * u[0] + c[here][1] * u[1] + c[here][2] * u[2] : 0.0;
        const double even = 0.5 * (f[here] + f[there]) - w * (rho + 4.5 * cu * cu - 1.5 * u2);
        const double odd = 0.5 * (f[here] - f[there]) - 3.0 * w * cj;
        after[here] = f[here] - scheme.rate_plus() * even - scheme.rate_minus() * odd + scheme.force_term(q);
    }
    return after;
}

// Full equilibrium; of the rest the shear stress alone is kept. P is the stress, and b_xxy etc. are moments of third order of what remains
// after collision: u_x^2 u_y of the equilibrium, and (1 - 1/tau) (2 u_x P_xy + u_y P_xx) of the rest. Eq. (T20),
// (T21).
Populations collide_regularised(const Populations& f, const Scheme& scheme) {
    const double rho = sum(f);
    const auto j = momentum(f);
    std::array<double, 3> u{};
    for (std::size_t a = 0; a < 3; ++a) u[a] = j[a] + 0.5 * scheme.force[a];
    std::array<std::array<double, 3>, 3> stress{};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) {
            for (std::size_t q = 0; q < directions; ++q) stress[a][b] += c[q][a] * c[q][b] * f[q];
            stress[a][b] -= (a == b ? rho / 3.0 : 0.0) + u[a] * u[b];
        }
    // The trace is set to zero: the bulk viscosity becomes 1/9, which damps sound.
    const double trace = stress[0][0] + stress[1][1] + stress[2][2];
    for (std::size_t a = 0; a < 3; ++a) stress[a][a] -= trace / 3.0;
    const double kept = 1.0 - scheme.rate_plus(), u2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    const auto third = [&](std::size_t a, std::size_t b) {  // of the moment a a b
        return scheme.model == Model::recursive ? u[a] * u[a] * u[b] + kept * (2.0 * u[a] * stress[a][b] + u[b] * stress[a][a]) : 0.0;
    };
    Populations after{};
    for (int q = 0; q < directions; ++q) {
        const auto& e = c[static_cast<std::size_t>(q)];
        double ej = 0.0, eu = 0.0, along = 0.0, odd = 0.0;
        int length = 0;
        for (std::size_t a = 0; a < 3; ++a) {
            ej += e[a] * j[a];
            eu += e[a] * u[a];
            length += e[a] * e[a];
            for (std::size_t b = 0; b < 3; ++b) along += e[a] * e[b] * stress[a][b];
        }
        for (std::size_t b = 0; b < 3; ++b)
            for (std::size_t a = 0; a < 3; ++a)
                if (a != b && e[b] != 0) odd += length == 1 ? -9.0 * e[b] * third(a, b) : 9.0 * e[b] * std::abs(e[a]) * third(a, b);
        after[static_cast<std::size_t>(q)] =
            d3q19::w(q) * (rho + 3.0 * ej + 4.5 * eu * eu - 1.5 * u2 + 4.5 * kept * along + odd) + scheme.force_term(q);
    }
    return after;
}

Populations collide(const Populations& f, const Scheme& scheme) {
    return scheme.two_relaxation_times() ? collide_two_times(f, scheme) : collide_regularised(f, scheme);
}

class ReferenceFlow : public Flow {
public:
    ReferenceFlow(std::shared_ptr<const Domain> of, const Scheme& scheme)
        : kept_(std::move(of)),
          domain_(*kept_),
          scheme_(scheme),
          before_(domain_.nodes(), Populations{}),
          after_(domain_.first_beyond(1) + static_cast<std::size_t>(domain_.beyond[1].size()), Populations{}),
          stored_(domain_.walls.size(), 0.0) {
        const Domain& domain = domain_;
        for (std::size_t l = 0; l < domain.walls.size(); ++l)
            for (std::size_t m = l; m < domain.walls.size() && domain.walls[m].node == domain.walls[l].node; ++m)
                if (domain.walls[m].q == opposite(domain.walls[l].q)) gaps_.push_back({l, m});
        for (const BoundaryLink& link : domain.boundary_links) boundary_added_.push_back(link.added);
        arrive();
    }

    void advance_two_steps() override {
        for (int step = 0; step < 2; ++step) {
            for (std::size_t x = 0; x < domain_.nodes(); ++x) after_[x] = collide(before_[x], scheme_);
            meet_walls();
            exchange();
            arrive();
        }
    }

    void moments(std::size_t first, std::span<Moments> moments) const override {
        for (std::size_t i = 0; i < moments.size(); ++i) {
            const auto& f = before_[first + i];
            const auto j = momentum(f);
            moments[i] = {sum(f), {j[0] + 0.5 * scheme_.force[0], j[1] + 0.5 * scheme_.force[1], j[2] + 0.5 * scheme_.force[2]}};
        }
    }

    void wall_forces(std::size_t first, std::span<std::array<double, 3>> forces) const override {
        std::fill(forces.begin(), forces.end(), std::array<double, 3>{});
        const auto by_node = [](const WallLink& link, std::size_t node) { return link.node < node; };
        for (auto link = std::lower_bound(domain_.walls.begin(), domain_.walls.end(), first, by_node);
             link != domain_.walls.end() && link->node < first + forces.size(); ++link) {
            const double given = collide(before_[link->node], scheme_)[link->q] + before_[link->node][out(*link)];
            for (std::size_t a = 0; a < 3; ++a) forces[link->node - first][a] += c[link->q][a] * given;
        }
    }

    void set_moments(std::size_t first, std::span<const Moments> moments) override {
        for (std::size_t i = 0; i < moments.size(); ++i) {
            auto momentum = moments[i].velocity;
            for (std::size_t a = 0; a < 3; ++a) momentum[a] -= 0.5 * scheme_.force[a];
            for (int q = 0; q < directions; ++q)
                before_[first + i][static_cast<std::size_t>(q)] = Scheme::equilibrium(q, moments[i].density, momentum);
        }
    }

    void add_density(std::size_t first, std::span<const double> added) override {
        for (std::size_t i = 0; i < added.size(); ++i)
            for (int q = 0; q < directions; ++q) before_[first + i][static_cast<std::size_t>(q)] += d3q19::w(q) * added[i];
    }

    void set_boundary_links(std::span<const double> added) override { boundary_added_.assign(added.begin(), added.end()); }

    void populations(std::size_t first, std::span<std::byte> of_nodes) const override {
        std::memcpy(of_nodes.data(), before_.data() + first, of_nodes.size());
    }
    void set_populations(std::size_t first, std::span<const std::byte> of_nodes) override {
        std::memcpy(before_.data() + first, of_nodes.data(), of_nodes.size());
    }
    [[nodiscard]] std::size_t bytes_per_number() const override { return sizeof(double); }

    [[nodiscard]] double bytes() const override { return static_cast<double>(domain_.nodes()) * 2.0 * sizeof(Populations); }

private:
    static std::size_t out(const WallLink& link) { return static_cast<std::size_t>(opposite(link.q)); }
    [[nodiscard]] WallWeights<double> weights(const WallLink& link) const { return {link.fraction(), scheme_.wall_rule()}; }

    [[nodiscard]] double arrival_weight(const WallLink& link) const {
        const auto w = weights(link);
        return scheme_.walls == Walls::bounce_back ? 0.0 : w.share * w.b;
    }

    void meet_walls() {
        for (std::size_t l = 0; l < domain_.walls.size(); ++l) {
            const WallLink& link = domain_.walls[l];
            const auto &f = before_[link.node], &star = after_[link.node];
            const std::size_t q = link.q, o = out(link);
            const auto w = weights(link);
            stored_[l] = scheme_.walls == Walls::bounce_back ? star[q]
                                                             : w.share * ((1.0 + w.shift) * star[q] - (w.b + w.shift) * star[o] -
                                                                          w.shift * (f[q] - f[o] + 2.0 * scheme_.force_term(link.q))) +
                                                                   (1.0 - w.share) * f[o];
        }
    }

    // The nodes of the first and last layer go to the slabs below and above.
    void exchange() {
        if (domain_.slabs->parts() == 1) return;
        const Grid& grid = domain_.grid;
        const auto rank = [&](int layer) {
            return layer < grid.cells[2] ? static_cast<std::size_t>(domain_.cells.rank(grid.index(0, 0, layer))) : domain_.nodes();
        };
        const auto sent = [&](std::size_t side, std::size_t first, std::size_t end) {
            return std::as_bytes(std::span(after_).subspan(first, domain_.beyond[side].has_grid() ? end - first : 0));
        };
        const auto received = [&](std::size_t side) {
            return std::as_writable_bytes(
                std::span(after_).subspan(domain_.first_beyond(side), static_cast<std::size_t>(domain_.beyond[side].size())));
        };
        domain_.slabs->exchange({sent(0, 0, rank(1)), sent(1, rank(grid.cells[2] - 1), domain_.nodes())}, {received(0), received(1)});
    }

    void arrive() {
        std::size_t x = 0;
        domain_.cells.for_each([&](std::size_t cell) {
            const auto here = domain_.grid.place(cell);
            for (int q = 0; q < directions; ++q) {
                const auto& back = c[static_cast<std::size_t>(opposite(q))];
                if (domain_.cuts.closed(cell, back)) continue;
                if (const auto other = domain_.node_beside(here, back); other >= 0)
                    before_[x][static_cast<std::size_t>(q)] = after_[static_cast<std::size_t>(other)][static_cast<std::size_t>(q)];
            }
            ++x;
        });
        for (std::size_t l = 0; l < domain_.boundary_links.size(); ++l) {
            const BoundaryLink& link = domain_.boundary_links[l];
            before_[link.node][link.q] = link.sign * after_[link.source][link.source_q] + boundary_added_[l];
        }
        for (std::size_t l = 0; l < domain_.walls.size(); ++l) {
            const WallLink& link = domain_.walls[l];
            if (!link.narrow) before_[link.node][out(link)] = stored_[l] + arrival_weight(link) * before_[link.node][link.q];
        }
        for (const auto& [l, m] : gaps_) {
            const WallLink &one = domain_.walls[l], &other = domain_.walls[m];
            const double a = arrival_weight(one), b = arrival_weight(other);
            before_[one.node][out(one)] = (stored_[l] + a * stored_[m]) / (1.0 - a * b);
            before_[one.node][out(other)] = (stored_[m] + b * stored_[l]) / (1.0 - a * b);
        }
    }

    std::shared_ptr<const Domain> kept_;
    const Domain& domain_;
    Scheme scheme_;
    std::vector<Populations> before_, after_;  // collision
    std::vector<double> stored_;               // by wall link
    std::vector<double> boundary_added_;
    struct Gap {
        std::size_t one, other;
    };
    std::vector<Gap> gaps_;
};

}  // namespace

std::shared_ptr<const FlowPlan> plan_flow(const Domain& domain) {
    struct Plan : FlowPlan {
        std::shared_ptr<const Domain> domain;
        [[nodiscard]] std::unique_ptr<Flow> start(const Scheme& scheme) const override {
            return std::make_unique<ReferenceFlow>(domain, scheme);
        }
    };
    auto plan = std::make_shared<Plan>();
    plan->domain = std::make_shared<const Domain>(domain);
    return plan;
}

}  // namespace porepack::lbm::reference
