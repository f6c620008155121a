// Structs with members (core/members.hpp) to JSON and back.
#pragma once

#include <cmath>
#include <concepts>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "core/choice.hpp"
#include "core/interval.hpp"
#include "core/json.hpp"
#include "core/members.hpp"

namespace porepack::inline core {

namespace members_detail {
template <typename T>
concept List = requires(const T& list) {
    list.begin();
    list.size();
}
&&!std::is_convertible_v<T, std::string_view> && !std::is_same_v<T, Json>;
template <typename T>
concept EigenVector = requires {
    typename T::PlainObject;
};

/// Where a value stands in a document: a chain of keys on the stack.
struct Place {
    const Place* within = nullptr;
    std::string_view key;  ///< of the outermost: the document
    long entry = -1;       ///< of a list, from 0; -1: the value of a key
};
[[noreturn]] void refuse_missing(const Place& place);
[[noreturn]] void refuse_value(const Place& place, const Json& json, const char* expected);
}  // namespace members_detail

/// Numbers, text, enums with names, optionals, intervals ([low, high]), vectors, lists, objects by name, and structs with members.
template <typename T>
[[nodiscard]] Json json_of(const T& value) {
    if constexpr (std::is_same_v<T, Json>) {
        return value;
    } else if constexpr (std::is_floating_point_v<T>) {
        return std::isfinite(value) ? Json(value) : Json(nullptr);
    } else if constexpr (std::is_same_v<T, Interval>) {
        return {json_of(value.low), json_of(value.high)};
    } else if constexpr (members_detail::IsOptional<T>::value) {
        return value ? json_of(*value) : Json(nullptr);
    } else if constexpr (NamedEnum<T>) {
        return std::string(name_of(value));
    } else if constexpr (HasMembers<T>) {
        Json json = Json::object();
        visit_members(value, [&]<typename Member>(const char* key, const Member& member) {
            if constexpr (members_detail::IsOptionalKey<Member>::value)
                if (!member) return;
            const Json part = json_of(member);
            if (*key == 0)
                json.update(part);
            else
                json[key] = part;
        });
        return json;
    } else if constexpr (members_detail::IsByName<T>::value) {
        Json json = Json::object();
        for (const auto& [key, entry] : value) json[key] = json_of(entry);
        return json;
    } else if constexpr (members_detail::EigenVector<T>) {
        Json json = Json::array();
        for (decltype(value.size()) i = 0; i < value.size(); ++i) json.push_back(json_of(value[i]));
        return json;
    } else if constexpr (members_detail::List<T>) {
        Json json = Json::array();
        for (const auto& entry : value) json.push_back(json_of(entry));
        return json;
    } else {
        return value;
    }
}

template <typename T>
void read_members(const Json& json, T& value, const members_detail::Place& place);

namespace members_detail {
// A part whose members stand among those of a struct; an optional one is there with all keys that it must have, or not at all.
template <typename T>
void read_part(const Json& json, T& part, const Place& place) {
    if constexpr (IsOptionalKey<T>::value) {
        if constexpr (HasMembers<typename T::value_type>) {
            const typename T::value_type example{};
            bool all = true;
            visit_members(example, [&]<typename Member>(const char* key, const Member&) {
                all = all && (IsOptionalKey<Member>::value || json.contains(key));
            });
            part.reset();
            if (all) read_members(json, part.emplace(), place);
        }
    } else if constexpr (HasMembers<T>) {
        read_members(json, part, place);
    }
}
}  // namespace members_detail

/// The inverse. Throws UserError with document and key where a key is missing or its value is of another type; keys that the struct does
/// not have are ignored. JSON has no infinity and no NaN: both are written as null, and null is read as NaN.
template <typename T>
void read_members(const Json& json, T& value, const members_detail::Place& place) {
    using members_detail::Place;
    if constexpr (std::is_same_v<T, Json>) {
        value = json;
    } else if constexpr (members_detail::IsOptional<T>::value) {
        value.reset();
        if (!json.is_null()) read_members(json, value.emplace(), place);
    } else if constexpr (std::is_same_v<T, Interval>) {
        const auto is_bound = [](const Json& bound) { return bound.is_number() || bound.is_null(); };
        if (!json.is_array() || json.size() != 2 || !is_bound(json[0]) || !is_bound(json[1]))
            members_detail::refuse_value(place, json, "two numbers");
        constexpr double none = std::numeric_limits<double>::infinity();  // null: there is no bound
        value = {json[0].is_null() ? -none : json[0].template get<double>(), json[1].is_null() ? none : json[1].template get<double>()};
    } else if constexpr (NamedEnum<T>) {
        const auto found = json.is_string() ? choice_named<T>(json.template get_ref<const std::string&>()) : std::nullopt;
        if (!found) members_detail::refuse_value(place, json, "one of its names");
        value = *found;
    } else if constexpr (HasMembers<T>) {
        if (!json.is_object()) members_detail::refuse_value(place, json, "an object");
        visit_members(value, [&]<typename Member>(const char* key, Member& member) {
            const Place here{&place, key};
            if (*key == 0) {
                members_detail::read_part(json, member, place);
                return;
            }
            const auto found = json.find(key);
            if constexpr (members_detail::IsOptionalKey<Member>::value) {
                member.reset();
                if (found != json.end()) read_members(*found, member.emplace(), here);
            } else {
                if (found == json.end()) members_detail::refuse_missing(here);
                read_members(*found, member, here);
            }
        });
    } else if constexpr (members_detail::IsByName<T>::value) {
        if (!json.is_object()) members_detail::refuse_value(place, json, "an object");
        value.clear();
        for (const auto& [key, entry] : json.items()) {
            value.emplace_back(key, typename T::value_type::second_type{});
            read_members(entry, value.back().second, Place{&place, key});
        }
    } else if constexpr (members_detail::EigenVector<T> || requires { std::tuple_size<T>::value; }) {
        if (!json.is_array() || json.size() != static_cast<std::size_t>(std::size(value)))
            members_detail::refuse_value(place, json, "a list of another length");
        std::size_t i = 0;
        for (auto& entry : value) {
            read_members(json[i], entry, Place{&place, {}, static_cast<long>(i)});
            ++i;
        }
    } else if constexpr (members_detail::List<T>) {
        if (!json.is_array()) members_detail::refuse_value(place, json, "a list");
        value.clear();
        for (const Json& entry : json) {
            const auto i = static_cast<long>(value.size());
            read_members(entry, value.emplace_back(), Place{&place, {}, i});
        }
    } else {
        constexpr bool text = std::is_same_v<T, std::string>, flag = std::is_same_v<T, bool>;
        if constexpr (std::is_floating_point_v<T>)
            if (json.is_null()) {
                value = std::numeric_limits<T>::quiet_NaN();
                return;
            }
        if (!(text ? json.is_string() : flag ? json.is_boolean() : json.is_number()))
            members_detail::refuse_value(place, json, text ? "text" : flag ? "true or false" : "a number");
        json.get_to(value);
    }
}

/// A function whose result is written as JSON: a struct with members, or Json.
template <typename... Arguments>
struct JsonFunction : std::function<Json(Arguments...)> {
    JsonFunction() = default;
    template <typename Function>
    requires(!std::same_as<std::remove_cvref_t<Function>, JsonFunction>)
        JsonFunction(Function compute)  // NOLINT: it stands where the function does
        : std::function<Json(Arguments...)>(
              [f = std::move(compute)](Arguments... arguments) { return json_of(f(std::forward<Arguments>(arguments)...)); }) {}
};

/// `document`: for messages.
template <typename T>
[[nodiscard]] T from_json_members(const Json& json, std::string_view document = {}) {
    T value{};
    read_members(json, value, members_detail::Place{nullptr, document});
    return value;
}

}  // namespace porepack::inline core
