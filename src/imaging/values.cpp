// Values of any type in single precision.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "core/error.hpp"
#include "imaging/file_axes.hpp"

namespace porepack::imaging {
namespace {

constexpr double largest_whole = 16777216.0;  // 2^24: beyond it, single precision leaves whole numbers out

template <typename Value>
void convert(const void* bytes, std::span<float> values, const Path& file) {
    const auto* from = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < values.size(); ++i) {
        Value value;
        std::memcpy(&value, from + i * sizeof(Value), sizeof(Value));
        if constexpr (std::is_floating_point_v<Value>) {
            if (!std::isfinite(static_cast<float>(value)))
                throw UserError(fmt::format("the image has the value {} in voxel {} of those read together", value, i),
                                {.where = file.string(), .allowed = "finite values"});
        } else if constexpr (sizeof(Value) == 4) {
            if (std::abs(static_cast<double>(value)) > largest_whole)
                throw UserError(fmt::format("the image has the value {}", value),
                                {.where = file.string(), .allowed = "whole numbers up to 16777216", .fix = "number the labels from 1 on"});
        }
        values[i] = static_cast<float>(value);
    }
}

}  // namespace

void to_float(const void* bytes, ValueType type, std::span<float> values, const Path& file) {
    switch (type) {
        case ValueType::uint8:
            return convert<std::uint8_t>(bytes, values, file);
        case ValueType::int8:
            return convert<std::int8_t>(bytes, values, file);
        case ValueType::uint16:
            return convert<std::uint16_t>(bytes, values, file);
        case ValueType::int16:
            return convert<std::int16_t>(bytes, values, file);
        case ValueType::uint32:
            return convert<std::uint32_t>(bytes, values, file);
        case ValueType::int32:
            return convert<std::int32_t>(bytes, values, file);
        case ValueType::float32:
            return convert<float>(bytes, values, file);
        case ValueType::float64:
            return convert<double>(bytes, values, file);
    }
}

void swap_bytes(void* bytes, std::size_t size, std::size_t count) {
    auto* at = static_cast<unsigned char*>(bytes);
    for (std::size_t i = 0; i < count; ++i, at += size) std::reverse(at, at + size);
}

}  // namespace porepack::imaging
