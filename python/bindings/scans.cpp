// Scans: segmented into grains, or grains of known shape fitted.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/fit_image.hpp"
#include "analysis/segment.hpp"
#include "bindings/array_image.hpp"
#include "bindings/host.hpp"
#include "bindings/objects.hpp"
#include "inputs/pore_space_input.hpp"

namespace porepack::python {
using analysis::Segmented;
using vessels::Container;

namespace {

// A file, or an array with its voxel size.
struct Scan {
    std::string file;
    std::optional<py::buffer_info> array = {};
    std::string type = {};
    double voxel_size_m = 0.0;
};
Scan scan_of(const py::object& source, double voxel_size_m) {
    if (py::isinstance<py::str>(source)) return {.file = source.cast<std::string>()};
    const auto array = source.cast<py::array>();
    return {.file = {}, .array = array.request(), .type = type_of(array), .voxel_size_m = voxel_size_m};
}
imaging::VolumeSource open(const Scan& scan, const imaging::ImageConfig& config, const std::string& place) {
    if (!scan.array) return imaging::open_volume(scan.file, config);
    return source_of(*scan.array, scan.type, scan.voxel_size_m, place);
}
std::optional<Container> given(const Container* vessel) {
    return vessel != nullptr ? std::optional(*vessel) : std::nullopt;
}

std::shared_ptr<Segmented> segment(const py::object& source, double voxel_size_m, const Container* vessel, const py::dict& segment_keys,
                                   const py::dict& image_keys) {
    const std::string place = "segment()";
    const auto config = config_of<analysis::SegmentConfig>(segment_keys, place);
    const auto image = config_of<imaging::ImageConfig>(image_keys, place);
    const Scan scan = scan_of(source, voxel_size_m);
    return run([&] {
        return std::make_shared<Segmented>(
            analysis::segment_image(open(scan, image, place), image, given(vessel), config, scan.array ? place : scan.file));
    });
}

py::tuple fit(const py::object& source, double voxel_size_m, const Shape& shape, const Container* vessel, const py::dict& image_keys) {
    const std::string place = "fit()";
    const auto image = config_of<imaging::ImageConfig>(image_keys, place);
    const Scan scan = scan_of(source, voxel_size_m);
    const auto fitted = run([&] {
        std::vector<shapes::Shape> shapes;
        for (const auto& share : shape.shares) shapes.push_back(share.shape);
        return analysis::fit_image(open(scan, image, place), image, given(vessel), shapes, scan.array ? place : scan.file);
    });
    return py::make_tuple(fitted.packing, to_python(fitted.outcome.result), fitted.outcome.files.tables.front().second.csv());
}

// The scan's solid fractions without the grains that were removed, as the file gray.vti gives them.
pore_space::PoreSpace space_of_segmented(const Segmented& segmented, const py::dict& geometry, const py::dict& section) {
    const char* place = "pore_space()";
    const inputs::InputOptions options{.geometry = config_of<converters::GeometryConfig>(geometry, place),
                                       .section = config_of<pore_space::SectionConfig>(section, place)};
    return run([&] {
        const geometry::Grid& grid = segmented.gray.grid;
        imaging::VolumeSource source{.header = {.voxels = {grid.cells[0], grid.cells[1], grid.cells[2]},
                                                .spacing_m = grid.spacing_m,
                                                .origin_m = grid.origin_m,
                                                .type = imaging::ValueType::float32,
                                                .format = "segmented scan",
                                                .own_fractions = true,
                                                .notes = segmented.gray.notes}};
        source.read = [&](std::int64_t first, std::span<float> values) {
            const std::size_t from = static_cast<std::size_t>(first) * static_cast<std::size_t>(source.header.layer());
            for (std::size_t n = 0; n < values.size(); ++n) values[n] = static_cast<float>(segmented.gray.at(from + n));
        };
        return inputs::load_pore_space(source, "segmented scan", options);
    });
}

py::list stones_of(const Segmented& segmented) {
    py::list stones;
    if (!segmented.library) return stones;
    for (const geometry::TriangleSurface& surface : segmented.library->surfaces)
        stones.append(py::make_tuple(rows_of(surface.points), rows_of(surface.triangles)));
    return stones;
}

}  // namespace

void bind_scans(py::module_& module) {
    py::class_<Segmented, std::shared_ptr<Segmented>>(module, "Segmented")
        .def_property_readonly("report", [](const Segmented& found) { return to_python(found.outcome.result); })
        .def_property_readonly("grains", [](const Segmented& found) { return found.outcome.files.tables.front().second.csv(); })
        .def_property_readonly("labels", [](const Segmented& found) { return array_of(std::vector(found.labels), found.gray.grid); })
        .def_property_readonly("phases",
                               [](const Segmented& found) { return array_of(std::vector(found.phases.phase), found.phases.grid); })
        .def_property_readonly("stones", &stones_of)
        .def("pore_space", &space_of_segmented)
        .def("write", [](const Segmented& found, const std::string& folder) {
            run_in_thread([&] {
                core::make_folder(folder);
                (void)analysis::written(found, folder);
            });
        });
    module.def("segment", &segment);
    module.def("fit", &fit);
}

}  // namespace porepack::python
