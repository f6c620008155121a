// Table [report] of case.toml.
#pragma once

#include "core/config.hpp"

namespace porepack::report {

struct ReportConfig {
    std::string title;
    bool pictures = true;
};

inline void describe(core::ConfigVisitor& v, ReportConfig& c) {
    v.text("title", c.title, "title of the report; default: the folder's name");
    v.boolean("pictures", c.pictures, "render the packing (needs xvfb-run if there is no display)");
}

}  // namespace porepack::report
