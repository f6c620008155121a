// Values of the library as Python objects, and Python's values as configurations.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/choice.hpp"
#include "core/json.hpp"
#include "core/members.hpp"
#include "core/members_json.hpp"
#include "geometry/grid.hpp"
#include "record/toml_file.hpp"

namespace porepack::python {

namespace py = pybind11;

/// None, bool, int, float, str, list and dict.
[[nodiscard]] py::object python_of(const core::Json& json);
/// The same back; arrays and numbers of NumPy, and paths, too. Throws UserError for anything else; `key` names it.
[[nodiscard]] core::Json json_of(const py::handle& value, const std::string& key);
/// Keyword arguments; those that are None are left out.
[[nodiscard]] core::Json json_of_keys(const py::dict& keys);

/// Numbers, text, names of enums, None for an empty optional, a tuple for an interval, lists, and a dict for a struct with members: its
/// keys are those of result.json. Not through JSON: numbers that are not finite, and all bits, are kept.
template <typename T>
[[nodiscard]] py::object to_python(const T& value) {
    namespace detail = core::members_detail;
    if constexpr (std::is_same_v<T, core::Json>) {
        return python_of(value);
    } else if constexpr (std::is_same_v<T, core::Interval>) {
        return py::make_tuple(value.low, value.high);
    } else if constexpr (detail::IsOptional<T>::value) {
        return value ? to_python(*value) : py::none();
    } else if constexpr (core::NamedEnum<T>) {
        return py::str(std::string(core::name_of(value)));
    } else if constexpr (core::HasMembers<T>) {
        py::dict members;
        visit_members(value, [&]<typename Member>(const char* key, const Member& member) {
            if constexpr (detail::IsOptionalKey<Member>::value)
                if (!member) return;
            const py::object part = to_python(member);
            if (*key != 0)
                members[key] = part;
            else
                for (const auto& [name, entry] : py::reinterpret_borrow<py::dict>(part)) members[name] = entry;
        });
        return members;
    } else if constexpr (detail::IsByName<T>::value) {
        py::dict entries;
        for (const auto& [key, entry] : value) entries[key.c_str()] = to_python(entry);
        return entries;
    } else if constexpr (detail::EigenVector<T> || detail::List<T>) {
        py::list list;
        for (const auto& entry : value) list.append(to_python(entry));
        return list;
    } else {
        return py::cast(value);
    }
}

/// Keys of one table. Throws UserError as case.toml does, with `place` instead of file and line.
template <typename Config>
void read_keys(const py::dict& keys, Config& config, const std::string& place) {
    record::read_values(json_of_keys(keys), config, place);
}
template <typename Config>
[[nodiscard]] Config config_of(const py::dict& keys, const std::string& place) {
    Config config;
    read_keys(keys, config, place);
    return config;
}

/// An array (rows, 3) of points or triangles.
template <typename Value>
[[nodiscard]] py::array_t<Value> rows_of(const std::vector<std::array<Value, 3>>& rows) {
    py::array_t<Value> array({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
    if (!rows.empty()) std::copy_n(rows.front().data(), 3 * rows.size(), array.mutable_data());
    return array;
}

/// An array [x, y, z], or [x, y, z, component], of values of a grid's cells, which are not copied: the array owns them.
template <typename T>
[[nodiscard]] py::array_t<T> array_of(std::vector<T> values, const geometry::Grid& grid, py::ssize_t components = 1) {
    auto* owned = new std::vector<T>(std::move(values));
    const py::capsule owner(owned, [](void* data) { delete static_cast<std::vector<T>*>(data); });
    const py::ssize_t nx = grid.cells[0], ny = grid.cells[1], nz = grid.cells[2], cell = components * static_cast<py::ssize_t>(sizeof(T));
    std::vector<py::ssize_t> shape = {nx, ny, nz}, strides = {cell, cell * nx, cell * nx * ny};
    if (components > 1) {
        shape.push_back(components);
        strides.push_back(sizeof(T));
    }
    return py::array_t<T>(shape, strides, owned->data(), owner);
}

}  // namespace porepack::python
