#include "lbm/layered_flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lbm/uses.hpp"

namespace porepack::lbm {
namespace {

constexpr double water_viscosity_Pa_s = 1e-3;

}  // namespace

LayeredFlow layered_flow(PhaseImage&& image, FlowField&& field, const Grid& whole, const LbmGridResult& result, double force,
                         double superficial_velocity_m_per_s) {
    const double speed = superficial_velocity_m_per_s / result.run.superficial_velocity_lu;
    const double gradient = water_viscosity_Pa_s * superficial_velocity_m_per_s / result.permeability_m2;
    const double pressure = gradient * result.voxel_size_m / result.run.gradient_lu;
    const auto axis = static_cast<std::size_t>(field.domain.drive.axis);
    const double slope = field.domain.drive.by_pressure() ? force : 0.0;
    LayeredFlow flow{.grid = whole, .own = {}, .notes = std::move(image.notes), .layers = {}};
    flow.notes["state"] =
        fmt::format("water (1e-3 Pa s) at a superficial velocity of {:g} m/s along {}", superficial_velocity_m_per_s, "xyz"[axis]);
    flow.notes["direction"] = std::string(1, "xyz"[axis]);
    const auto phase = std::make_shared<const std::vector<std::uint8_t>>(std::move(image.phase));
    const auto of_nodes = std::make_shared<const FlowField>(std::move(field));
    const int below = image.grid.slab.first;  // layers of the whole grid
    flow.own = {below, below + image.grid.cells[2]};
    flow.layers = [=, own = image.grid](int first, int end) {
        const std::size_t begin = own.index(0, 0, first - below), cells = own.index(0, 0, end - below) - begin;
        const auto from = phase->begin() + static_cast<std::ptrdiff_t>(begin);
        FlowImage picture{.grid = whole,
                          .velocity_m_per_s = std::vector<float>(3 * cells, 0.0F),
                          .pressure_Pa = std::vector<float>(cells, 0.0F),
                          .phase = {from, from + static_cast<std::ptrdiff_t>(cells)},
                          .notes = {}};
        picture.grid.origin_m[2] += first * whole.spacing_m[2];
        picture.grid.cells[2] = end - first;
        const Domain& domain = of_nodes->domain;
        const std::size_t in_field = domain.grid.is_slab() ? own.index(0, 0, below - domain.grid.slab.first) : 0;
        auto node = static_cast<std::size_t>(domain.cells.rank(in_field + begin));
        for (std::size_t cell = 0; cell < cells; ++cell) {
            if (!domain.cells.contains(in_field + begin + cell)) continue;
            const auto& moments = of_nodes->moments[node++];
            for (std::size_t a = 0; a < 3; ++a)
                picture.velocity_m_per_s[3 * cell + a] = static_cast<float>(speed * static_cast<double>(moments[a + 1]));
            std::array<int, 3> at = own.place(begin + cell);
            at[2] = own.layer(at[2]);
            const double to_outlet = own.whole_cells(axis) - at[axis] - 0.5;
            picture.pressure_Pa[cell] = static_cast<float>(pressure * (static_cast<double>(moments[0]) / 3.0 + slope * to_outlet));
        }
        return picture;
    };
    return flow;
}

}  // namespace porepack::lbm
