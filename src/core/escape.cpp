#include "core/escape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.hpp"

namespace porepack::inline core {
namespace {

bool is_control(char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == '\x7f';
}

// Letters and digits of ASCII, in every locale.
bool is_alphanumeric(char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

bool is_plain(char c) {
    return is_alphanumeric(c) || c == '_' || c == '-' || c == '+' || c == '.';
}

// A mark of U+061C, U+200E, U+200F, U+202A to U+202E or U+2066 to U+2069 at `at`, in UTF-8: its name and its number of bytes.
std::pair<std::string, std::size_t> direction_mark(std::string_view text, std::size_t at) {
    const auto byte = [&](std::size_t i) { return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U; };
    if (byte(0) == 0xd8 && byte(1) == 0x9c) return {"\\u061c", 2};
    if (byte(0) != 0xe2 || (byte(1) != 0x80 && byte(1) != 0x81)) return {};
    const unsigned code = 0x2000U + ((byte(1) & 0x3fU) << 6U) + (byte(2) & 0x3fU);
    const bool mark = code == 0x200e || code == 0x200f || (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    return mark ? std::pair(fmt::format("\\u{:04x}", code), std::size_t{3}) : std::pair(std::string(), std::size_t{0});
}

// The text with `replaced(c)` for each character; control characters and marks of direction are shown.
template <typename Replaced>
std::string escaped(std::string_view text, const Replaced& replaced) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (const auto [name, bytes] = direction_mark(text, i); bytes > 0) {
            out += name;
            i += bytes - 1;
        } else if (is_control(c) && c != '\n' && c != '\t') {
            out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
        } else {
            out += replaced(c);
        }
    }
    return out;
}

}  // namespace

std::string for_terminal(std::string_view text) {
    return escaped(text, [](char c) { return std::string(1, c); });
}

std::string for_gnuplot(std::string_view text) {
    return "'" + escaped(text, [](char c) { return c == '\'' ? std::string("’") : std::string(1, c == '\n' || c == '\t' ? ' ' : c); }) +
           "'";
}

std::string for_html(std::string_view text) {
    return escaped(text, [](char c) -> std::string {
        switch (c) {
            case '&':
                return "&amp;";
            case '<':
                return "&lt;";
            case '>':
                return "&gt;";
            case '"':
                return "&quot;";
            case '\'':
                return "&#39;";
            default:
                return {c};
        }
    });
}

std::string for_markdown(std::string_view text) {
    constexpr std::string_view special = "\\<|[]";
    return escaped(text, [&](char c) {
        if (c == '\n' || c == '\t') return std::string(" ");
        return special.find(c) == std::string_view::npos ? std::string(1, c) : std::string{'\\', c};
    });
}

std::string for_shell(std::string_view text) {
    constexpr std::string_view harmless = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./,:=";
    if (!text.empty() && text.find_first_not_of(harmless) == std::string_view::npos) return std::string(text);
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

bool is_plain_name(std::string_view name) {
    return !name.empty() && name.size() <= 200 && (is_alphanumeric(name.front()) || name.front() == '_') &&
           std::all_of(name.begin(), name.end(), is_plain);
}

void require_plain_name(std::string_view name, std::string_view what, const std::string& where) {
    if (!is_plain_name(name))
        throw UserError(fmt::format("{} is not a plain file name: \"{}\"", what, name),
                        {.where = where, .allowed = "at most 200 letters, digits and _ - + . ; the first a letter, a digit or _"});
}

std::string as_plain_name(std::string_view text) {
    std::string name(text.substr(0, 200));
    for (char& c : name)
        if (!is_plain(c)) c = '_';
    return is_plain_name(name) ? name : ("_" + name).substr(0, 200);
}

}  // namespace porepack::inline core
