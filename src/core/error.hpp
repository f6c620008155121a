// Errors that a run can end with, and the exit code of each. They are caught once, in main.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace porepack::inline core {

enum class ExitCode { done = 0, user = 2, numerical = 3, engine = 4, machine = 5 };

/// Additional parts of an error message: where, what is allowed, and how to fix it. Empty parts are left out.
struct Advice {
    std::string where = {};
    std::string allowed = {};
    std::string fix = {};
};

[[nodiscard]] std::string with_advice(std::string_view what, const Advice& advice);

class Error : public std::runtime_error {
public:
    Error(ExitCode code, std::string_view what, const Advice& advice = {})
        : std::runtime_error(with_advice(what, advice)), code_(code), parts_(std::make_shared<const Parts>(std::string(what), advice)) {}
    [[nodiscard]] ExitCode code() const { return code_; }
    /// What is wrong, without advice; what() is both as one text.
    [[nodiscard]] const std::string& fault() const { return parts_->first; }
    [[nodiscard]] const Advice& advice() const { return parts_->second; }

private:
    using Parts = std::pair<std::string, Advice>;
    ExitCode code_;
    std::shared_ptr<const Parts> parts_;  // so that copies do not throw
};

/// The input is wrong, and the user can fix it (exit 2).
struct UserError : Error {
    explicit UserError(std::string_view what, const Advice& advice = {}) : Error(ExitCode::user, what, advice) {}
};

/// Not converged, diverged, does not percolate (exit 3).
struct NumericalError : Error {
    explicit NumericalError(std::string_view what, const Advice& advice = {}) : Error(ExitCode::numerical, what, advice) {}
};

/// LIGGGHTS, OpenFOAM or another program is missing or failed (exit 4).
struct EngineError : Error {
    explicit EngineError(std::string_view what, const Advice& advice = {}) : Error(ExitCode::engine, what, advice) {}
};

/// Disk full, out of memory, interrupted (exit 5).
struct MachineError : Error {
    explicit MachineError(std::string_view what, const Advice& advice = {}) : Error(ExitCode::machine, what, advice) {}
};

}  // namespace porepack::inline core
