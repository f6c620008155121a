// Whether a step uses threads, by measurement.
#pragma once

namespace porepack::pouring::dem {

/// Threads that synchronise three times in a step of a millisecond are faster than one thread on an idle machine, and much slower where
/// another program uses a core. So both are tried for some steps from time to time, and the faster one is used. Results do not depend on
/// it.
class ThreadChoice {
public:
    [[nodiscard]] bool parallel() const { return parallel_; }
    /// Tells how long the step took that has just been made.
    void add(double seconds);

private:
    enum class Phase { one_thread, all_threads, decided };
    void begin(Phase phase);
    void decide();

    Phase phase_ = Phase::one_thread;
    bool parallel_ = false;
    long steps_ = 0;           // of this phase
    double seconds_ = 0.0;     // of this phase, without its first steps
    double one_thread_ = 0.0;  // seconds per step, when it was tried last
    long until_trial_ = 0;
};

}  // namespace porepack::pouring::dem
