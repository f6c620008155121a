// Shapes, vessels and packings.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "analysis/porosity.hpp"
#include "analysis/pour.hpp"
#include "analysis/relax.hpp"
#include "analysis/shape.hpp"
#include "bindings/host.hpp"
#include "bindings/objects.hpp"
#include "core/error.hpp"
#include "inputs/mesh_grains.hpp"
#include "inputs/mesh_vessel.hpp"

namespace porepack::python {
using core::Path;
using packing::Packing;
using vessels::Container;

namespace {

Shape make_shape(const py::dict& keys, const std::string& folder) {
    Shape shape{.config = config_of<shapes::ShapeConfig>(keys, "Shape()"), .folder = folder, .shares = {}};
    if (shape.config.kind == shapes::ShapeKind::surface)
        throw core::UserError("a surface is no grain",
                              {.where = "Shape()", .allowed = "kind = \"mesh\"", .fix = "a whole bed: PoreSpace(file)"});
    return run([&] {
        shape.shares = shapes::make_shapes(inputs::with_mesh_grains(shape.config, shape.folder));
        return shape;
    });
}

Container make_vessel(const py::dict& keys, const std::string& folder) {
    const auto config = config_of<vessels::ContainerConfig>(keys, "Vessel()");
    return run([&] { return inputs::make_container(config, folder); });
}

py::dict measures_of(const Shape& shape, double density_kg_per_m3) {
    const auto measures = run([&] { return analysis::measure_shape(shape.config, density_kg_per_m3, shape.folder); });
    return to_python(measures);
}

// As the stage pack: the packing is what its file holds.
py::tuple pour(const Shape& shape, const Container& vessel, const py::dict& packing_keys, const py::dict& protocol_keys,
               const std::string& folder) {
    const auto config = config_of<pouring::PackingConfig>(packing_keys, "pour()");
    const auto protocol = config_of<pouring::ProtocolConfig>(protocol_keys, "pour()");
    if (config.engine == pouring::Engine::none)
        throw core::UserError("engine = \"none\" pours nothing", {.where = "pour()", .fix = "Packing.read(file)"});
    if (!protocol.none()) pouring::require_protocol(protocol, vessel);
    const auto outcome = run([&] {
        auto [result, packing, table] = analysis::pour(shape.shares, vessel, config, protocol, folder);
        analysis::add_grains(result, packing);
        if (packing.overlap_allowed) result.overlap_allowed = true;
        const Path file = Path(folder) / "packing.json";
        packing::write_packing(file, packing);
        if (table) table->write(Path(folder) / "protocol.csv");
        Packing written = packing::read_packing(file);
        result.bed = analysis::bed_porosity(pore_space::pore_space_of(written));
        return std::pair(std::move(written), std::move(result));
    });
    return py::make_tuple(outcome.first, to_python(outcome.second));
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

Packing packing_of_poses(const Shape& shape, const Container& vessel, const Numbers& positions, const Numbers& orientations,
                         const std::vector<std::size_t>& shape_of, bool overlap_allowed) {
    const auto refuse = [](const std::string& fault, const std::string& allowed) {
        throw core::UserError(fault, {.where = "Packing()", .allowed = allowed});
    };
    const auto count = static_cast<std::size_t>(positions.ndim() == 2 ? positions.shape(0) : 0);
    if (count == 0 || positions.shape(1) != 3)
        refuse("`positions_m` does not hold the positions of grains", "an array of shape (grains, 3)");
    if (orientations.ndim() != 2 || static_cast<std::size_t>(orientations.shape(0)) != count || orientations.shape(1) != 4)
        refuse("`orientations` does not hold the quaternions of these grains", "an array of shape (grains, 4): w, x, y, z");
    if (shape_of.size() != count) refuse("`shape_of` does not name the shape of each grain", "one number per grain");
    Packing packing{.container = vessel, .shapes = {}, .bodies = {}, .overlap_allowed = overlap_allowed};
    for (const auto& share : shape.shares) packing.shapes.push_back(share.shape);
    for (std::size_t n = 0; n < count; ++n) {
        const auto row = static_cast<py::ssize_t>(n);
        const shapes::Vec3 position(positions.at(row, 0), positions.at(row, 1), positions.at(row, 2));
        const shapes::Quaternion turn(orientations.at(row, 0), orientations.at(row, 1), orientations.at(row, 2), orientations.at(row, 3));
        if (!position.allFinite() || !turn.coeffs().allFinite() || !(std::abs(turn.norm() - 1.0) < 1e-3))
            refuse(fmt::format("the pose of grain {} is not one", n), "finite positions, and quaternions of length 1");
        if (shape_of[n] >= packing.shapes.size())
            refuse(fmt::format("grain {} has the shape {}", n, shape_of[n]), fmt::format("0 to {}", packing.shapes.size() - 1));
        packing.bodies.push_back({.shape = shape_of[n], .position_m = position, .orientation = turn.normalized()});
    }
    return run([&] {
        if (!overlap_allowed) packing::require_no_overlap(packing, "Packing()");
        return packing;
    });
}

template <typename Row>
py::array_t<double> rows_of(const Packing& packing, py::ssize_t columns, const Row& row) {
    py::array_t<double> array({static_cast<py::ssize_t>(packing.bodies.size()), columns});
    double* next = array.mutable_data();
    for (const packing::Body& body : packing.bodies)
        for (const double value : row(body)) *next++ = value;
    return array;
}

py::dict contacts_of(const Packing& packing) {
    const auto found = run([&] { return packing::find_overlaps(packing); });
    py::dict contacts;
    contacts["contacts"] = found.contacts;
    contacts["largest_overlap_m"] = found.largest_between_grains_m;
    contacts["mean_overlap_m"] = found.mean_between_grains_m;
    contacts["largest_wall_overlap_m"] = found.largest_with_wall_m;
    return contacts;
}

py::tuple relaxed(const Packing& packing, const py::dict& keys) {
    const auto config = config_of<pouring::PackingConfig>(keys, "relax()");
    const auto found = run([&] { return analysis::relax_packing(packing, config); });
    return py::make_tuple(found.packing, to_python(found.outcome.result));
}

}  // namespace

void bind_packings(py::module_& module) {
    py::class_<Shape>(module, "Shape")
        .def(py::init(&make_shape))
        .def("measures", &measures_of)
        .def_property_readonly("kind", [](const Shape& shape) { return std::string(core::name_of(shape.config.kind)); })
        .def_property_readonly("names", [](const Shape& shape) {
            std::vector<std::string> names;
            for (const auto& share : shape.shares) names.push_back(share.shape.id);
            return py::cast(names);
        });
    py::class_<Container>(module, "Vessel")
        .def(py::init(&make_vessel))
        .def_property_readonly("height_m", &Container::height)
        .def_property_readonly("area_m2", &Container::inner_area_m2)
        .def_property_readonly("low_m", [](const Container& vessel) { return to_python(vessel.low()); })
        .def_property_readonly("high_m", [](const Container& vessel) { return to_python(vessel.high()); })
        .def_property_readonly("periodic", [](const Container& vessel) { return to_python(vessel.periodic()); })
        .def("wall_distance",
             [](const Container& vessel, double x, double y, double z) { return vessel.wall_distance(geometry::Vec3(x, y, z)); })
        .def("keys", [](const Container& vessel) { return python_of(vessels::to_json(vessel)); });
    py::class_<Packing>(module, "Packing")
        .def(py::init(&packing_of_poses))
        .def("__len__", [](const Packing& packing) { return packing.bodies.size(); })
        .def_property_readonly("vessel", [](const Packing& packing) { return packing.container; })
        .def_property_readonly("positions_m",
                               [](const Packing& packing) {
                                   return rows_of(packing, 3, [](const packing::Body& body) {
                                       const auto& p = body.position_m;
                                       return std::array{p.x(), p.y(), p.z()};
                                   });
                               })
        .def_property_readonly("orientations",
                               [](const Packing& packing) {
                                   return rows_of(packing, 4, [](const packing::Body& body) {
                                       const auto& q = body.orientation;
                                       return std::array{q.w(), q.x(), q.y(), q.z()};
                                   });
                               })
        .def_property_readonly("shape_of",
                               [](const Packing& packing) {
                                   std::vector<std::size_t> shapes;
                                   for (const packing::Body& body : packing.bodies) shapes.push_back(body.shape);
                                   return py::array_t<std::size_t>(static_cast<py::ssize_t>(shapes.size()), shapes.data());
                               })
        .def_property_readonly("shape_names",
                               [](const Packing& packing) {
                                   std::vector<std::string> names;
                                   for (const auto& shape : packing.shapes) names.push_back(shape.id);
                                   return py::cast(names);
                               })
        .def("bed",
             [](const Packing& packing) {
                 return to_python(run([&] { return analysis::bed_porosity(pore_space::pore_space_of(packing)); }));
             })
        .def("contacts", &contacts_of)
        .def("relaxed", &relaxed)
        .def("write",
             [](const Packing& packing, const std::string& file) { run_in_thread([&] { packing::write_packing(file, packing); }); });
    module.def("read_packing", [](const std::string& file) { return run([&] { return packing::read_packing(file); }); });
    module.def("pour", &pour);
}

}  // namespace porepack::python
