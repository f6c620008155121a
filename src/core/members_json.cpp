#include "core/members_json.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "core/error.hpp"

namespace porepack::core::members_detail {
namespace {

// "grids[2].permeability_m2", and the document that it is in.
std::pair<std::string, std::string> text_of(const Place& place) {
    if (place.within == nullptr) return {std::string(), std::string(place.key)};
    auto [path, document] = text_of(*place.within);
    if (place.entry >= 0)
        path += fmt::format("[{}]", place.entry);
    else
        path += (path.empty() ? "" : ".") + std::string(place.key);
    return {path, document};
}

constexpr const char* fix = "it is of another version or was edited: compute it again";

}  // namespace

void refuse_missing(const Place& place) {
    const auto [path, document] = text_of(place);
    throw UserError(fmt::format("the key `{}` is missing", path), {.where = document, .fix = fix});
}

void refuse_value(const Place& place, const Json& json, const char* expected) {
    const auto [path, document] = text_of(place);
    std::string found = json.dump();
    constexpr std::size_t longest = 60;
    if (found.size() > longest) found = found.substr(0, longest) + "...";
    throw UserError(fmt::format("`{}` is {}", path.empty() ? "the document" : path, found),
                    {.where = document, .allowed = expected, .fix = fix});
}

}  // namespace porepack::core::members_detail
