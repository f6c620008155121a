#include <string>

#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {

ReportSection tortuosity_section(const ReportInput& input) {
    ReportSection section{
        .title = "Tortuosity",
        .intro =
            "Four different numbers: the path of the paper through dots (exact, and on slice images, where it grows with the pixel size), "
            "the shortest path through the pores, the mean path of the flow, and the tortuosity factor eps D0/D_eff of diffusion."};
    const std::string paper = paper_number(input, "tortuosity");
    if (!paper.empty())
        section.intro += fmt::format(
            " The paper states {} for this grain, by the same dots. It is not reached with exact sections: coarse pixels and thick slices "
            "explain a part of the difference (docs/tortuosity.md).",
            paper);
    section.header = {"kind", "value", "interval (95 %)", "the paper"};
    if (!input.results.tortuosity) return section;
    const results::Tortuosity& found = *input.results.tortuosity;
    const auto add = [&](const std::string& name, double value, const std::string& uncertainty, const std::string& of_paper = "") {
        section.rows.push_back({name, number_text(value, "{:.4f}"), uncertainty, of_paper});
    };
    const auto mean_over = [](double mean, double standard_error, long number, const char* what) {
        const auto interval = interval_of_path_mean(mean, standard_error, number);
        return interval ? fmt::format("{:.4f} to {:.4f} (mean over {})", interval->low, interval->high, what) : std::string("none");
    };
    const auto add_dots = [&](const std::string& name, const results::GeometricPaper& dots) {
        add(name, dots.tortuosity, mean_over(dots.tortuosity, dots.standard_error, dots.paths, "paths"), paper);
    };
    if (const auto& dots = found.geometric_paper_exact) add_dots("the paper's dots, exact", *dots);
    if (const auto& dots = found.geometric_paper_pixels)
        add_dots("the paper's dots, on slices with pixels of " + number_text(dots->pixel_m) + " m", *dots);
    if (const auto& path = found.shortest_path)
        add("shortest path, mean over starting points", path->tortuosity,
            mean_over(path->tortuosity, path->standard_error, path->starts, "starting points"));
    add("hydraulic", found.hydraulic.tortuosity, "none");
    if (const auto& factor = found.diffusive)
        add("tortuosity factor (diffusive)", factor->tortuosity_factor,
            factor->interval ? fmt::format("{:.3f} to {:.3f} (three grids)", factor->interval->low, factor->interval->high) : "none");
    return section;
}

}  // namespace porepack::report
