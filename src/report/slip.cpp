#include "report/slip.hpp"

#include <fmt/format.h>

#include <cmath>

#include "permeability/fluid.hpp"

namespace porepack::report {

std::optional<std::string> slip_note(const ReportInput& input, const ReportConfig& config) {
    if (!input.results.lbm) return std::nullopt;
    const double k = input.results.lbm->permeability.m2, eps = input.results.lbm->porosity;
    const auto knudsen = permeability::knudsen_number(config.fluid, config.temperature_C, k, eps);
    if (!knudsen || *knudsen <= permeability::max_knudsen_number) return std::nullopt;
    return fmt::format(
        "{}: the mean free path of its molecules is {:.2g} times the pore size (sqrt(32 k/porosity) = {:.2g} m). The k of this report is "
        "that of a liquid. Slip on the walls makes k of this gas about {:.2g} % larger, if the pores are like straight tubes; above a "
        "ratio of "
        "0.1 this is a rough estimate.",
        input.fluid_text, *knudsen, std::sqrt(32.0 * k / eps), 800.0 * *knudsen);
}

}  // namespace porepack::report
