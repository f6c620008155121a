// Table [report] of case.toml.
#pragma once

#include <string>

#include "permeability/fluid.hpp"
#include "record/config.hpp"

namespace porepack::report {

struct ReportConfig {
    std::string title;
    bool pictures = true;
    permeability::FluidName fluid = permeability::FluidName::water;
    double temperature_C = 20.0;
};

inline void describe(record::ConfigVisitor& v, ReportConfig& c) {
    v.text("title", c.title, "title of the report; default: the folder's name");
    v.boolean("pictures", c.pictures,
              "show the bed: a rendered picture (needs xvfb-run if there is no display), and one that can be turned (libjs-three)");
    v.choice("fluid", c.fluid, "fluid for which the report states the hydraulic conductivity K = k rho g / mu");
    v.number("temperature_C", c.temperature_C, record::between(0.0, 100.0), "temperature of this fluid");
}

}  // namespace porepack::report
