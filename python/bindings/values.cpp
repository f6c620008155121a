#include "bindings/values.hpp"

#include <cmath>

#include "core/error.hpp"

namespace porepack::python {
using core::Json;

py::object python_of(const Json& json) {
    switch (json.type()) {
        case Json::value_t::boolean:
            return py::bool_(json.get<bool>());
        case Json::value_t::number_integer:
        case Json::value_t::number_unsigned:
            return py::int_(json.get<long long>());
        case Json::value_t::number_float:
            return py::float_(json.get<double>());
        case Json::value_t::string:
            return py::str(json.get_ref<const std::string&>());
        case Json::value_t::array: {
            py::list list;
            for (const Json& entry : json) list.append(python_of(entry));
            return list;
        }
        case Json::value_t::object: {
            py::dict dict;
            for (const auto& [key, entry] : json.items()) dict[key.c_str()] = python_of(entry);
            return dict;
        }
        default:
            return py::none();
    }
}

Json json_of(const py::handle& value, const std::string& key) {
    if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
    if (py::isinstance<py::int_>(value)) return value.cast<long long>();
    if (py::isinstance<py::float_>(value)) {
        const double number = value.cast<double>();
        if (!std::isfinite(number)) throw core::UserError("`" + key + "` is not finite", {.allowed = "a finite number"});
        return number;
    }
    if (py::isinstance<py::str>(value)) return value.cast<std::string>();
    if (py::hasattr(value, "tolist")) return json_of(value.attr("tolist")(), key);  // an array, or a number of NumPy
    if (py::hasattr(value, "__fspath__")) return value.attr("__fspath__")().cast<std::string>();
    if (py::isinstance<py::dict>(value)) {
        Json object = Json::object();
        for (const auto& [name, entry] : py::reinterpret_borrow<py::dict>(value))
            if (!entry.is_none()) object[py::str(name).cast<std::string>()] = json_of(entry, key);
        return object;
    }
    if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
        Json list = Json::array();
        for (const py::handle entry : value) list.push_back(json_of(entry, key));
        return list;
    }
    throw core::UserError("`" + key + "` is of the type " + py::str(py::type::of(value).attr("__name__")).cast<std::string>(),
                          {.allowed = "bool, int, float, str, a list or a dict of them, an array of NumPy, a path"});
}

Json json_of_keys(const py::dict& keys) {
    Json values = Json::object();
    for (const auto& [name, value] : keys)
        if (!value.is_none()) {
            const auto key = py::str(name).cast<std::string>();
            values[key] = json_of(value, key);
        }
    return values;
}

}  // namespace porepack::python
