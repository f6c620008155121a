// What Python holds of the library: a shape with its configuration, a container, a packing, a pore space.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bindings/values.hpp"
#include "core/files.hpp"
#include "packing/packing.hpp"
#include "pore_space/pore_space.hpp"
#include "shapes/config.hpp"

namespace porepack::python {

/// One grain, or a mixture.
struct Shape {
    shapes::ShapeConfig config;  ///< with the grains of meshes
    core::Path folder;           ///< of the files that it names
    std::vector<shapes::ShapeShare> shares;
};

void bind_packings(py::module_& module);
void bind_pore_spaces(py::module_& module);
void bind_flows(py::module_& module);
void bind_scans(py::module_& module);
void bind_falling_heads(py::module_& module);
void bind_cases(py::module_& module);

}  // namespace porepack::python
