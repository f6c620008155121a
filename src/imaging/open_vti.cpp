#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "imaging/file_axes.hpp"
#include "io/vti_volume.hpp"

namespace porepack::imaging {

// PorePack's own images name their container: they are in metres.
FileVolume open_vti(const Path& path, const std::string& field) {
    static const std::map<std::string, ValueType> types = {
        {"UInt8", ValueType::uint8},   {"Int8", ValueType::int8},   {"UInt16", ValueType::uint16},   {"Int16", ValueType::int16},
        {"UInt32", ValueType::uint32}, {"Int32", ValueType::int32}, {"Float32", ValueType::float32}, {"Float64", ValueType::float64}};
    const io::VtiVolume vti = io::open_vti_volume(path, field);
    FileVolume volume{.voxels = vti.values,
                      .type = types.at(vti.type),
                      .spacing = vti.spacing,
                      .origin = vti.origin,
                      .direction = vti.direction,
                      .notes = vti.notes};
    volume.format =
        fmt::format("VTK image, {}, `{}` at {}, {}", name_of(volume.type), vti.field, vti.at_points ? "points" : "cells", vti.storage);
    volume.own_phases = vti.field == "phase" && vti.notes.contains("container");
    volume.own_fractions = vti.field == "solid_fraction" && vti.notes.contains("container") && vti.notes.contains("gray");
    volume.files = {path};
    if (!vti.has_spacing) volume.spacing.reset();
    if (vti.notes.contains("container")) volume.unit_m = 1.0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (vti.direction[i][axis] != (axis == i ? 1.0 : 0.0)) volume.states_direction = true;
    volume.read = [vti, type = volume.type, path](std::int64_t first, std::span<float> values) {
        const std::int64_t layer = vti.values[0] * vti.values[1], layers = static_cast<std::int64_t>(values.size()) / layer;
        std::vector<char> bytes(static_cast<std::size_t>(layer) * vti.bytes);
        for (std::int64_t k = 0; k < layers; ++k) {
            vti.read(first + k, 1, bytes.data());
            to_float(bytes.data(), type, values.subspan(static_cast<std::size_t>(k * layer), static_cast<std::size_t>(layer)), path);
        }
    };
    return volume;
}

}  // namespace porepack::imaging
