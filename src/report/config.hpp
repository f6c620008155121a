// Table [report] of case.toml.
#pragma once

#include "core/config.hpp"

namespace porepack::report {

struct ReportConfig {
    std::string title;
    bool pictures = true;
};

inline void describe(core::ConfigVisitor& v, ReportConfig& c) {
    v.text("title", c.title, "title of the report; the folder's name when left out");
    v.boolean("pictures", c.pictures, "render the packing (needs xvfb-run where no display is)");
}

}  // namespace porepack::report
