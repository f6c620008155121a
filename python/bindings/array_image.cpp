#include "bindings/array_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <type_traits>

#include "core/error.hpp"

namespace porepack::python {
namespace {

// A whole number that single precision does not hold is refused.
template <typename T>
float value_of(T value, const std::string& where) {
    if constexpr (std::is_integral_v<T> && sizeof(T) >= 4)
        if (constexpr T largest = 1 << 24; value > largest || (std::is_signed_v<T> && value < T{0} - largest))
            throw core::UserError(fmt::format("the array holds the value {}", value),
                                  {.where = where, .allowed = "whole numbers up to 16777216", .fix = "a mask: array == value"});
    return static_cast<float>(value);
}
// Of an array [x, y, z] of any strides.
template <typename T>
void copy_layer(const py::buffer_info& array, std::int64_t z, std::int64_t nx, std::int64_t ny, float* out, const std::string& where) {
    const auto* base = static_cast<const char*>(array.ptr) + z * array.strides[2];
    for (std::int64_t y = 0; y < ny; ++y)
        for (std::int64_t x = 0; x < nx; ++x)
            *out++ = value_of(*reinterpret_cast<const T*>(base + y * array.strides[1] + x * array.strides[0]), where);
}

struct ArrayType {
    const char* name;
    imaging::ValueType type;
    void (*copy)(const py::buffer_info&, std::int64_t, std::int64_t, std::int64_t, float*, const std::string&);
};
constexpr std::array<ArrayType, 11> array_types = {{{"bool", imaging::ValueType::uint8, &copy_layer<bool>},
                                                    {"uint8", imaging::ValueType::uint8, &copy_layer<std::uint8_t>},
                                                    {"int8", imaging::ValueType::int8, &copy_layer<std::int8_t>},
                                                    {"uint16", imaging::ValueType::uint16, &copy_layer<std::uint16_t>},
                                                    {"int16", imaging::ValueType::int16, &copy_layer<std::int16_t>},
                                                    {"uint32", imaging::ValueType::uint32, &copy_layer<std::uint32_t>},
                                                    {"int32", imaging::ValueType::int32, &copy_layer<std::int32_t>},
                                                    {"uint64", imaging::ValueType::uint32, &copy_layer<std::uint64_t>},
                                                    {"int64", imaging::ValueType::int32, &copy_layer<std::int64_t>},
                                                    {"float32", imaging::ValueType::float32, &copy_layer<float>},
                                                    {"float64", imaging::ValueType::float64, &copy_layer<double>}}};

void require_finite(std::span<const float> values, std::int64_t z, std::int64_t nx, const std::string& where) {
    for (std::size_t n = 0; n < values.size(); ++n)
        if (!std::isfinite(values[n])) {
            const auto at = static_cast<std::int64_t>(n);
            throw core::UserError("the array holds a value that is not finite",
                                  {.where = fmt::format("{}: array[{}, {}, {}] in the order x, y, z", where, at % nx, at / nx, z),
                                   .fix = "replace NaN and infinity before, for instance by numpy.nan_to_num"});
        }
}

}  // namespace

std::string type_of(const py::array& array) {
    return py::str(array.dtype().attr("name")).cast<std::string>();
}

imaging::VolumeSource source_of(const py::buffer_info& array, const std::string& type_name, double voxel_size_m, const std::string& where) {
    const auto type = std::find_if(array_types.begin(), array_types.end(), [&](const ArrayType& one) { return type_name == one.name; });
    if (type == array_types.end())
        throw core::UserError(
            "the array is of the type " + type_name,
            {.where = where, .allowed = "bool, int8 to int64, uint8 to uint64, float32, float64", .fix = "array.astype(...)"});
    const std::int64_t nx = array.shape[0], ny = array.shape[1], nz = array.shape[2];
    imaging::VolumeSource source{.header = {.voxels = {nx, ny, nz},
                                            .spacing_m = {voxel_size_m, voxel_size_m, voxel_size_m},
                                            .type = type->type,
                                            .format = fmt::format("NumPy array, {}", type_name),
                                            .orientation = "array[x, y, z]",
                                            .size_source = "given"}};
    source.read = [&array, copy = type->copy, nx, ny, where](std::int64_t first, std::span<float> values) {
        const auto layer = static_cast<std::size_t>(nx * ny);
        for (std::size_t n = 0; n * layer < values.size(); ++n) {
            const std::int64_t z = first + static_cast<std::int64_t>(n);
            copy(array, z, nx, ny, values.data() + n * layer, where);
            require_finite(values.subspan(n * layer, layer), z, nx, where);
        }
    };
    return source;
}

}  // namespace porepack::python
