// Structs that name their members in one list, from which their JSON is written and read (core/members_json.hpp): a struct has a function
//     template <MembersOf<Struct> Self, typename Visit> void visit_members(Self& self, const Visit& visit)
// beside it, which calls visit("key", self.member) for each. Keys end in their unit. visit("", self.part): the members of the part stand
// among those of the struct. A local variable instead of a member is written; when read, its key must be there too.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace porepack::inline core {

/// `Self` is T or const T.
template <typename Self, typename T>
concept MembersOf = std::same_as<std::remove_const_t<Self>, T>;

/// A member whose key is left out when it is empty. (The key of an empty std::optional is there, with null.)
template <typename T>
struct OptionalKey : std::optional<T> {
    using std::optional<T>::optional;
    template <typename U = T>
    requires(!std::same_as<std::remove_cvref_t<U>, OptionalKey> && std::is_constructible_v<T, U>) OptionalKey& operator=(U&& value) {
        this->emplace(std::forward<U>(value));
        return *this;
    }
    OptionalKey(std::optional<T> value) : std::optional<T>(std::move(value)) {}  // NOLINT: both are an optional value
};

/// An object whose keys are not known beforehand, as the names of shapes, in the order of its entries.
template <typename T>
using ByName = std::vector<std::pair<std::string, T>>;
/// The entry of this name, or nullptr.
template <typename T>
[[nodiscard]] const T* find(const ByName<T>& entries, std::string_view name) {
    for (const auto& [key, value] : entries)
        if (key == name) return &value;
    return nullptr;
}

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
struct IsOptional<OptionalKey<T>> : std::true_type {};
template <typename T>
struct IsOptionalKey : std::false_type {};
template <typename T>
struct IsOptionalKey<OptionalKey<T>> : std::true_type {};
template <typename T>
struct IsByName : std::false_type {};
template <typename T>
struct IsByName<ByName<T>> : std::true_type {};
}  // namespace members_detail

template <typename T>
concept HasMembers = requires(const T& value) {
    visit_members(value, members_detail::Ignore{});
};

}  // namespace porepack::inline core
