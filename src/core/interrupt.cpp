#include "core/interrupt.hpp"

#include <atomic>
#include <csignal>

#include "core/context.hpp"
#include "core/error.hpp"

namespace porepack::inline core {
namespace {

std::atomic<int> received_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

void remember_signal(int number) {
    received_signal = number;
}

}  // namespace

void install_signal_handlers() {
    struct sigaction action {};
    action.sa_handler = remember_signal;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGUSR1, &action, nullptr);
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() {
    return context().interrupted ? context().interrupted() : received_signal != 0;
}

Interrupted::Interrupted()
    : MachineError("interrupted", {.fix = "run the same command again: it resumes at the stage that was interrupted"}) {}

void check_interrupt() {
    if (interrupted()) throw Interrupted();
}

}  // namespace porepack::inline core
