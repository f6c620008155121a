// An array of NumPy as an image.
#pragma once

#include <string>

#include "bindings/values.hpp"
#include "imaging/volume.hpp"

namespace porepack::python {

/// "float32"
[[nodiscard]] std::string type_of(const py::array& array);
/// An array [x, y, z] of this type and of any strides, which is read layer by layer, as a file, and must outlive the source. `where` names
/// it in messages. Throws UserError for a type that is not read, and when it is read for a value that is not finite or too large.
[[nodiscard]] imaging::VolumeSource source_of(const py::buffer_info& array, const std::string& type, double voxel_size_m,
                                              const std::string& where);

}  // namespace porepack::python
