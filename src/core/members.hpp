// Converts structs to JSON and back from one list of their members: a struct has a function
//     template <MembersOf<Struct> Self, typename Visit> void visit_members(Self& self, const Visit& visit)
// beside it, which calls visit("key", self.member) for each. Keys end in their unit.
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/choice.hpp"
#include "core/files.hpp"
#include "core/interval.hpp"

namespace porepack::core {

/// `Self` is T or const T.
template <typename Self, typename T>
concept MembersOf = std::same_as<std::remove_const_t<Self>, T>;

namespace members_detail {
struct Ignore {
    template <typename T>
    void operator()(const char*, T&&) const {}
};
template <typename T>
struct IsOptional : std::false_type {};
template <typename T>
struct IsOptional<std::optional<T>> : std::true_type {};
template <typename T>
concept List = requires(const T& list) {
    list.begin();
    list.size();
}
&&!std::is_convertible_v<T, std::string_view> && !std::is_same_v<T, Json>;
template <typename T>
concept EigenVector = std::is_base_of_v<Eigen::MatrixBase<T>, T>;
}  // namespace members_detail

template <typename T>
concept HasMembers = requires(const T& value) {
    visit_members(value, members_detail::Ignore{});
};

/// Numbers, text, enums with names, optionals (null when empty), intervals ([low, high]), vectors, lists, and structs with members.
template <typename T>
[[nodiscard]] Json json_of(const T& value) {
    if constexpr (std::is_same_v<T, Json>) {
        return value;
    } else if constexpr (std::is_same_v<T, Interval>) {
        return {value.low, value.high};
    } else if constexpr (members_detail::IsOptional<T>::value) {
        return value ? json_of(*value) : Json(nullptr);
    } else if constexpr (NamedEnum<T>) {
        return std::string(name_of(value));
    } else if constexpr (HasMembers<T>) {
        Json json = Json::object();
        visit_members(value, [&](const char* key, const auto& member) { json[key] = json_of(member); });
        return json;
    } else if constexpr (members_detail::EigenVector<T>) {
        Json json = Json::array();
        for (Eigen::Index i = 0; i < value.size(); ++i) json.push_back(value[i]);
        return json;
    } else if constexpr (members_detail::List<T>) {
        Json json = Json::array();
        for (const auto& entry : value) json.push_back(json_of(entry));
        return json;
    } else {
        return value;
    }
}

/// The inverse. Throws nlohmann::json::exception where a key is missing or of another type.
template <typename T>
void read_members(const Json& json, T& value) {
    if constexpr (members_detail::IsOptional<T>::value) {
        value.reset();
        if (!json.is_null()) read_members(json, value.emplace());
    } else if constexpr (std::is_same_v<T, Interval>) {
        value = {json.at(0).get<double>(), json.at(1).get<double>()};
    } else if constexpr (HasMembers<T>) {
        visit_members(value, [&](const char* key, auto& member) { read_members(json.at(key), member); });
    } else if constexpr (requires {
                             value.resize(0);
                             value[0] = value[0];
                         } &&
                         !std::is_convertible_v<T, std::string_view>) {
        value.clear();
        for (const Json& entry : json) read_members(entry, value.emplace_back());
    } else {
        json.get_to(value);
    }
}

template <typename T>
[[nodiscard]] T from_json_members(const Json& json) {
    T value{};
    read_members(json, value);
    return value;
}

}  // namespace porepack::core
