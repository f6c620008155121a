#include "core/context.hpp"

#include <utility>

namespace porepack::inline core {
namespace {

const Context& defaults() {
    static const Context none;
    return none;
}

thread_local const Context* of_this_thread = nullptr;

}  // namespace

const Context& context() {
    return of_this_thread != nullptr ? *of_this_thread : defaults();
}

ContextScope::ContextScope(const Context& context) : before_(std::exchange(of_this_thread, &context)) {}

ContextScope::~ContextScope() {
    of_this_thread = before_;
}

}  // namespace porepack::inline core
