#include "core/context.hpp"

#include <utility>

namespace porepack::core {
namespace {

Context& current() {
    static Context context;
    return context;
}

}  // namespace

void set_context(Context context) {
    current() = std::move(context);
}

const Context& context() {
    return current();
}

}  // namespace porepack::core
