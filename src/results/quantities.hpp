// The quantities of which a case says how sure they are: where they stand in the results, and how they are shown.
#pragma once

#include <array>
#include <optional>

#include "core/interval.hpp"
#include "results/results.hpp"

namespace porepack::results {

struct Quantity {
    const char* name;
    std::optional<double> (*value)(const CaseResults&);
    std::optional<core::Interval> (*interval)(const CaseResults&);  ///< numerical
    const char *label, *format, *unit;                              ///< for tables; format of fmt
};

inline constexpr auto no_interval = [](const CaseResults&) -> std::optional<core::Interval> { return std::nullopt; };

inline constexpr std::array reported_quantities = {
    Quantity{"permeability_m2", [](const CaseResults& r) { return r.lbm ? std::optional(r.lbm->permeability.m2) : std::nullopt; },
             [](const CaseResults& r) { return r.lbm ? r.lbm->permeability.interval_m2 : std::nullopt; }, "permeability k (m²)", "{:.3g}",
             "m²"},
    Quantity{"porosity", [](const CaseResults& r) { return r.lbm ? std::optional(r.lbm->porosity) : std::nullopt; }, no_interval,
             "porosity of the section", "{:.4f}", ""},
    Quantity{"tortuosity_hydraulic",
             [](const CaseResults& r) { return r.tortuosity ? std::optional(r.tortuosity->hydraulic.tortuosity) : std::nullopt; },
             no_interval, "tortuosity, hydraulic", "{:.4f}", ""},
    Quantity{"tortuosity_geometric_paper",
             [](const CaseResults& r) {
                 return r.tortuosity && r.tortuosity->geometric_paper_exact ? std::optional(r.tortuosity->geometric_paper_exact->tortuosity)
                                                                            : std::nullopt;
             },
             no_interval, "tortuosity, the paper's dots (exact)", "{:.4f}", ""},
    Quantity{"tortuosity_shortest_path",
             [](const CaseResults& r) {
                 return r.tortuosity && r.tortuosity->shortest_path ? std::optional(r.tortuosity->shortest_path->tortuosity) : std::nullopt;
             },
             no_interval, "tortuosity, shortest path", "{:.4f}", ""},
    Quantity{
        "tortuosity_factor",
        [](const CaseResults& r) {
            return r.tortuosity && r.tortuosity->diffusive ? std::optional(r.tortuosity->diffusive->tortuosity_factor) : std::nullopt;
        },
        [](const CaseResults& r) { return r.tortuosity && r.tortuosity->diffusive ? r.tortuosity->diffusive->interval : std::nullopt; },
        "tortuosity factor (diffusive)", "{:.4f}", ""}};

}  // namespace porepack::results
