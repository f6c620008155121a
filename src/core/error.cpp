#include "core/error.hpp"

namespace porepack::inline core {

std::string with_advice(std::string_view what, const Advice& advice) {
    std::string text(what);
    if (!advice.where.empty()) text += "\n  where:   " + advice.where;
    if (!advice.allowed.empty()) text += "\n  allowed: " + advice.allowed;
    if (!advice.fix.empty()) text += "\n  fix:     " + advice.fix;
    return text;
}

}  // namespace porepack::inline core
