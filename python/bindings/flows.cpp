// What is computed in a pore space: permeability, tortuosities, pores.
#include <optional>
#include <string>
#include <utility>

#include "analysis/flow.hpp"
#include "analysis/pores.hpp"
#include "analysis/tortuosity.hpp"
#include "bindings/host.hpp"
#include "bindings/objects.hpp"
#include "core/error.hpp"

namespace porepack::python {
using converters::GeometryConfig;
using pore_space::PoreSpace;

namespace {

// The field as arrays [x, y, z] and [x, y, z, component].
py::dict field_of(geometry::FlowImage field) {
    py::dict found;
    found["spacing_m"] = to_python(field.grid.spacing_m);
    found["origin_m"] = to_python(field.grid.origin_m);
    found["velocity_m_per_s"] = array_of(std::move(field.velocity_m_per_s), field.grid, 3);
    found["pressure_Pa"] = array_of(std::move(field.pressure_Pa), field.grid);
    found["phase"] = array_of(std::move(field.phase), field.grid);
    return found;
}

py::tuple permeability(const PoreSpace& space, double voxel_size_m, bool with_flow, const std::string& checkpoint, const py::dict& keys) {
    auto config = config_of<lbm::LbmConfig>(keys, "permeability()");
    config.fields = with_flow ? lbm::FieldFiles::vti : lbm::FieldFiles::none;
    auto [result, field] = run([&] {
        analysis::ComputedFlow flow = analysis::compute_flow(space, {.voxel_size_m = voxel_size_m}, config, checkpoint);
        std::optional<geometry::FlowImage> whole;
        if (with_flow) whole = flow.field.of_own();
        return std::pair(std::move(flow.outcome.result), std::move(whole));
    });
    return py::make_tuple(to_python(result), field ? py::object(field_of(std::move(*field))) : py::none());
}

py::object tortuosity(const PoreSpace& space, double voxel_size_m, const std::string& kind_name, const py::dict& keys) {
    const auto config = config_of<tortuosity::TortuosityConfig>(keys, "tortuosity()");
    const auto kind = core::choice_named<analysis::TortuosityKind>(kind_name);
    const GeometryConfig geometry{.voxel_size_m = voxel_size_m};
    if (kind == analysis::TortuosityKind::diffusive)
        return to_python(run([&] { return analysis::compute_diffusive_tortuosity(space, geometry, config.direction); }));
    if (kind == analysis::TortuosityKind::shortest_path)
        return to_python(run([&] { return analysis::compute_shortest_path(space, geometry, config.direction); }).result);
    if (kind == analysis::TortuosityKind::geometric_paper)
        return to_python(run([&] { return analysis::compute_geometric_paper(space, config); }).result);
    throw core::UserError("no tortuosity is called " + kind_name, {.where = "tortuosity()",
                                                                   .allowed = "diffusive, shortest_path, geometric_paper",
                                                                   .fix = "the hydraulic one comes with permeability()"});
}

py::object pores(const PoreSpace& space, double voxel_size_m) {
    const GeometryConfig geometry{.voxel_size_m = voxel_size_m};
    return to_python(run([&] { return analysis::describe_pores(space, geometry); }).result);
}

}  // namespace

void bind_flows(py::module_& module) {
    module.def("permeability", &permeability);
    module.def("tortuosity", &tortuosity);
    module.def("pores", &pores);
}

}  // namespace porepack::python
