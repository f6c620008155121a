#include "pouring/dem/thread_choice.hpp"

#include <algorithm>

#include "core/machine.hpp"

namespace porepack::pouring::dem {
namespace {

constexpr long warm_up = 3, trial = 20;                      // steps
constexpr long often = 2000, seldom = 32000;                 // steps from one trial to the next
constexpr double worth = 1e-4;                               // seconds of a step from which threads are tried: waking them takes some 1e-5
constexpr double clearly_faster = 0.95, clearly_slow = 1.3;  // of the time of one thread

}  // namespace

void ThreadChoice::begin(Phase phase) {
    phase_ = phase;
    parallel_ = phase == Phase::all_threads;
    steps_ = 0;
    seconds_ = 0.0;
}

// After the steps of the trial with all threads.
void ThreadChoice::decide() {
    const bool faster = steps_ > warm_up && seconds_ < clearly_faster * one_thread_ * static_cast<double>(steps_ - warm_up);
    until_trial_ = faster ? often : std::min(seldom, 2 * std::max(often, until_trial_));
    begin(Phase::decided);
    parallel_ = faster;
}

void ThreadChoice::add(double seconds) {
    if (++steps_ > warm_up) seconds_ += seconds;
    const auto counted = static_cast<double>(steps_ - warm_up);
    switch (phase_) {
        case Phase::one_thread:
            if (steps_ < trial) return;
            one_thread_ = seconds_ / counted;
            until_trial_ = std::max(often, until_trial_);
            begin(one_thread_ > worth && core::thread_count() > 1 ? Phase::all_threads : Phase::decided);
            return;
        case Phase::all_threads:
            // Where another program uses a core, one step may take as long as a hundred.
            if (steps_ >= trial || std::max(seconds, seconds_) > one_thread_ * static_cast<double>(trial)) decide();
            return;
        case Phase::decided:
            if (steps_ >= until_trial_) return begin(Phase::one_thread);
            if (!parallel_ || steps_ % trial != 0) return;
            if (seconds_ > clearly_slow * one_thread_ * static_cast<double>(trial)) parallel_ = false;
            seconds_ = 0.0;
    }
}

}  // namespace porepack::pouring::dem
