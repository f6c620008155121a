// The quantities of which a case says how sure they are: their places in the results of the stages, and how they are shown.
#pragma once

#include <array>

namespace porepack::uncertainty {

struct Quantity {
    const char *name, *value, *interval;  ///< places in {"stage": result}; no interval: an empty text
    const char *label, *format, *unit;    ///< for tables; format of fmt
};

inline constexpr std::array reported_quantities = {
    Quantity{"permeability_m2", "/lbm/permeability_m2", "/lbm/permeability_interval_m2", "permeability k (m²)", "{:.3g}", "m²"},
    Quantity{"porosity", "/lbm/porosity", "", "porosity of the section", "{:.4f}", ""},
    Quantity{"tortuosity_hydraulic", "/tortuosity/hydraulic/tortuosity_hydraulic", "", "tortuosity, hydraulic", "{:.4f}", ""},
    Quantity{"tortuosity_geometric_paper", "/tortuosity/geometric_paper_exact/tortuosity_geometric_paper", "",
             "tortuosity, the paper's dots (exact)", "{:.4f}", ""},
    Quantity{"tortuosity_shortest_path", "/tortuosity/shortest_path/tortuosity_shortest_path", "", "tortuosity, shortest path", "{:.4f}",
             ""},
    Quantity{"tortuosity_factor", "/tortuosity/diffusive/tortuosity_factor", "/tortuosity/diffusive/interval",
             "tortuosity factor (diffusive)", "{:.4f}", ""}};

}  // namespace porepack::uncertainty
