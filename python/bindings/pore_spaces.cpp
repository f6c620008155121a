// Pore spaces of packings, images, surfaces and files.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "analysis/porosity.hpp"
#include "bindings/array_image.hpp"
#include "bindings/host.hpp"
#include "bindings/objects.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "inputs/image_input.hpp"
#include "inputs/pore_space_input.hpp"
#include "pore_space/gray_solid.hpp"
#include "scans/ball_walls.hpp"

namespace porepack::python {
using geometry::PhaseImage;
using inputs::InputOptions;
using pore_space::PoreSpace;
using vessels::Container;

namespace {

InputOptions options_of(const py::dict& geometry, const py::dict& section, const py::dict& image, const Container* vessel, double unit_m) {
    const char* place = "PoreSpace()";
    InputOptions options{.unit_m = unit_m,
                         .geometry = config_of<converters::GeometryConfig>(geometry, place),
                         .section = config_of<pore_space::SectionConfig>(section, place),
                         .image = config_of<imaging::ImageConfig>(image, place)};
    if (vessel != nullptr) options.container = *vessel;
    return options;
}

PoreSpace space_of_array(const py::array& array, double voxel_size_m, const std::optional<std::array<bool, 3>>& periodic,
                         const Container* vessel, const py::dict& geometry, const py::dict& section, const py::dict& image) {
    InputOptions options = options_of(geometry, section, image, vessel, 1.0);
    const std::string place = "PoreSpace()", type = type_of(array);
    const py::buffer_info buffer = array.request();
    return run([&] {
        const imaging::VolumeSource source = source_of(buffer, type, voxel_size_m, place);
        if (periodic && vessel == nullptr) options.container = vessels::make_box(inputs::box_of(source.header).size(), *periodic);
        return inputs::load_pore_space(source, "PoreSpace()", options);
    });
}

geometry::TriangleSurface surface_of(const py::array_t<double, py::array::c_style | py::array::forcecast>& vertices,
                                     const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>& triangles) {
    const auto refuse = [](const std::string& what) {
        throw core::UserError(
            what, {.where = "PoreSpace()", .allowed = "vertices of shape (n, 3), triangles of shape (m, 3) with numbers of vertices"});
    };
    if (vertices.ndim() != 2 || vertices.shape(1) != 3 || triangles.ndim() != 2 || triangles.shape(1) != 3) refuse("no triangle surface");
    geometry::TriangleSurface surface;
    for (py::ssize_t n = 0; n < vertices.shape(0); ++n) {
        surface.points.push_back({vertices.at(n, 0), vertices.at(n, 1), vertices.at(n, 2)});
        for (const double x : surface.points.back())
            if (!std::isfinite(x)) refuse(fmt::format("vertex {} is not finite", n));
    }
    for (py::ssize_t n = 0; n < triangles.shape(0); ++n) {
        std::array<int, 3> corners{};
        for (std::size_t c = 0; c < 3; ++c) {
            const std::int64_t vertex = triangles.at(n, static_cast<py::ssize_t>(c));
            if (vertex < 0 || vertex >= vertices.shape(0)) refuse(fmt::format("triangle {} has the vertex {}", n, vertex));
            corners[c] = static_cast<int>(vertex);
        }
        surface.triangles.push_back(corners);
    }
    return surface;
}

py::dict surface_of_packing(const packing::Packing& packing, const py::dict& geometry) {
    const auto config = config_of<converters::GeometryConfig>(geometry, "surface()");
    const auto made = run([&] { return converters::make_surface(packing, converters::surface_options(config)); });
    py::dict found;
    found["vertices_m"] = rows_of(made.surface.points);
    found["triangles"] = rows_of(made.surface.triangles);
    found["largest_deviation_m"] = made.deviation_m;
    found["volume_m3"] = made.check.volume_m3;
    found["area_m2"] = made.check.area_m2;
    found["joined_grains"] = made.joined_grains;
    return found;
}

py::dict porosity_of(const PoreSpace& space) {
    const auto porosity = run([&] { return space.porosity(); });
    py::dict found;
    found["value"] = porosity.value;
    found["standard_uncertainty"] = porosity.uncertainty;
    return found;
}

}  // namespace

void bind_pore_spaces(py::module_& module) {
    py::class_<PoreSpace>(module, "PoreSpace")
        .def("porosity", &porosity_of)
        .def("voxels",
             [](const PoreSpace& space, double voxel_size_m) {
                 PhaseImage image = run([&] { return space.section_only().voxelise_at(space.voxel_size_m(voxel_size_m)); });
                 const geometry::Grid grid = image.grid;
                 return py::make_tuple(array_of(std::move(image.phase), grid), to_python(grid.spacing_m), to_python(grid.origin_m));
             })
        .def_property_readonly("section_m", [](const PoreSpace& space) { return to_python(space.section.interval()); })
        .def_property_readonly("vessel", [](const PoreSpace& space) { return space.container; })
        .def_property_readonly("kind", [](const PoreSpace& space) {
            if (space.gray()) return scans::has_walls_of_balls(*space.gray()) ? "image" : "gray image";
            return space.packing() ? "packing" : space.surface() ? "surface" : space.own_grid() ? "image" : "solid";
        });
    module.def("space_of_array", &space_of_array);
    module.def("space_of_packing", [](const packing::Packing& packing, const py::dict& geometry, const py::dict& section) {
        const InputOptions options = options_of(geometry, section, {}, nullptr, 1.0);
        return run([&] { return inputs::load_pore_space(packing, "PoreSpace()", options); });
    });
    module.def("space_of_surface", [](const py::object& vertices, const py::object& triangles, const Container& vessel,
                                      const py::dict& geometry, const py::dict& section) {
        const InputOptions options = options_of(geometry, section, {}, &vessel, 1.0);
        geometry::TriangleSurface surface = surface_of(vertices, triangles);
        return run([&] { return inputs::load_pore_space(std::move(surface), "PoreSpace()", options); });
    });
    module.def("space_of_file", [](const std::string& file, const Container* vessel, double unit_m, const py::dict& geometry,
                                   const py::dict& section, const py::dict& image) {
        const InputOptions options = options_of(geometry, section, image, vessel, unit_m);
        return run([&] { return inputs::load_pore_space(core::Path(file), options); });
    });
    module.def("surface_of_packing", &surface_of_packing);
}

}  // namespace porepack::python
