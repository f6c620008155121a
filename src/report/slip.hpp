// A gas in narrow pores: its molecules slip on the walls.
#pragma once

#include <optional>
#include <string>

#include "report/config.hpp"
#include "report/report.hpp"

namespace porepack::report {

/// For a report whose fluid is a gas with a mean free path that is not small beside the pores; else none.
[[nodiscard]] std::optional<std::string> slip_note(const ReportInput& input, const ReportConfig& config);

}  // namespace porepack::report
