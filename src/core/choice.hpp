// Choices by name: an enum of the configuration and the names of its values in files and flags.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace porepack::inline core {

template <typename Enum>
struct Choice {
    Enum value;
    std::string_view name;
};

/// An enum with a function `constexpr std::array<Choice<Enum>, n> choices_of(Enum)` beside it, which is found by argument-dependent lookup.
template <typename Enum>
concept NamedEnum = requires(Enum value) {
    choices_of(value)[0].name;
};

template <NamedEnum Enum>
[[nodiscard]] constexpr std::string_view name_of(Enum value) {
    for (const auto& choice : choices_of(value))
        if (choice.value == value) return choice.name;
    return {};
}

template <NamedEnum Enum>
[[nodiscard]] constexpr std::optional<Enum> choice_named(std::string_view name) {
    for (const auto& choice : choices_of(Enum{}))
        if (choice.name == name) return choice.value;
    return std::nullopt;
}

/// Coordinate axes; their values are indices.
enum class Axis { x, y, z };
constexpr std::array<Choice<Axis>, 3> choices_of(Axis) {
    return {{{Axis::x, "x"}, {Axis::y, "y"}, {Axis::z, "z"}}};
}
[[nodiscard]] constexpr std::size_t index_of(Axis axis) {
    return static_cast<std::size_t>(axis);
}

}  // namespace porepack::inline core
