#include <algorithm>
#include <cmath>

#include "report/plot.hpp"
#include "report/section.hpp"

namespace porepack::report {
using namespace core;
namespace fs = std::filesystem;

namespace {

// "n = 0.14 (0.05 to 0.2)"
std::string parameter_text(const char* name, const Json& parameter) {
    return fmt::format("{} = {} ({} to {})", name, number_text(parameter["value"], "{:.3g}"),
                       number_text(parameter["interval"][0], "{:.3g}"), number_text(parameter["interval"][1], "{:.3g}"));
}

// What the flows show of weak and strong inertia.
void add_laws(ReportSection& section, const std::string& solver, const Json& laws) {
    const auto add = [&](const char* key, const std::string& name, const char* exponent) {
        const Json& law = laws[key];
        if (!law.is_object()) return;
        section.rows.push_back(
            {solver,
             fmt::format("{}, Re {} to {}", name, number_text(law["reynolds_from"], "{:.3g}"), number_text(law["reynolds_to"], "{:.3g}")),
             law["exponent"].is_object() ? parameter_text(exponent, law["exponent"]) : parameter_text("b", law["coefficient"]),
             "misfit over error " + number_text(law["misfit"], "{:.2g}")});
    };
    add("weak_inertia", "k/k apparent - 1 = a Re²", "exponent if fitted");
    add("forchheimer", "k/k apparent - 1 = c + b Re", "");
    add("power_law", "k/k apparent - 1 = c + b Re^(1-n)", "n");
}

}  // namespace

ReportSection inertia_section(const ReportInput& input) {
    ReportSection section{.title = "Flow with inertia"};
    section.header = {"solver", "Re = U d/nu", "k apparent (m²)", "k apparent / k"};
    for (const auto& [solver, path] : {std::pair("lattice Boltzmann", "forchheimer/lbm"), std::pair("OpenFOAM", "forchheimer/openfoam")}) {
        const Json& part = result_at(input, path);
        if (!part.is_object() || !part.contains("creeping_permeability_m2")) continue;
        const double k = part["creeping_permeability_m2"].get<double>();
        for (const Json& flow : part.contains("grids") ? part["grids"].back()["flows"] : part["flows"])
            section.rows.push_back({solver, number_text(flow["reynolds"], "{:.3g}"), number_text(flow["permeability_m2"]),
                                    fmt::format("{:.4f}", flow["permeability_m2"].get<double>() / k)});
        const Json& interval = part["inertial_permeability_interval_m"];
        section.rows.push_back(
            {solver, "k_in = " + number_text(part["inertial_permeability_m"]) + " m",
             fmt::format("{} to {} m", number_text(interval[0]), number_text(interval[1])),
             "onset (5 %) at Re " + number_text(part["onset_reynolds"], "{:.2g}") +
                 (part["stopped_by"].is_string() ? "; then " + part["stopped_by"].get<std::string>().substr(0, 60) : "")});
        if (part.contains("laws")) add_laws(section, solver, part["laws"]);
    }
    if (section.rows.empty()) return section;
    section.rows.push_back(
        {"Ergun", "k_in = " + number_text(result_at(input, "forchheimer/ergun_inertial_permeability_m")) + " m", "", ""});
    section.intro = fmt::format("1/k_apparent = 1/k + (U/nu)/k_in (Forchheimer); d = {} m. Beyond the largest steady Re k_in is {}.",
                                number_text(result_at(input, "forchheimer/length_m")),
                                result_at(input, "forchheimer/beyond_largest_reynolds").get<std::string>());
    return section;
}

ReportSection falling_head_section(const ReportInput& input) {
    ReportSection section{.title = "Falling head"};
    section.header = {"water level above the sample (m)", "passed after, Eq. 18 (s)", "with the inertia of the water and the screens (s)"};
    const Json &levels = result_at(input, "falling-head/levels_m"), &times = result_at(input, "falling-head/times_s"),
               &full = result_at(input, "falling-head/times_full_equation_s");
    for (std::size_t i = 0; levels.is_array() && i < levels.size(); ++i)
        section.rows.push_back({number_text(levels[i]), number_text(times[i], "{:.5g}"), number_text(full[i], "{:.5g}")});
    if (result_at(input, "falling-head/inertial_permeability_from").is_string())
        section.intro = fmt::format(
            "With k = {} m² ({}), k_in = {} m ({}), a sample of {} m, a start {} m above it, and the inertia coefficient {}.",
            number_text(result_at(input, "falling-head/permeability_m2")),
            result_at(input, "falling-head/permeability_from").get<std::string>(),
            number_text(result_at(input, "falling-head/inertial_permeability_m")),
            result_at(input, "falling-head/inertial_permeability_from").get<std::string>(),
            number_text(result_at(input, "falling-head/sample_length_m")), number_text(result_at(input, "falling-head/start_level_m")),
            number_text(result_at(input, "falling-head/inertia_coefficient"), "{:.3g}"));
    return section;
}

ReportSection causes_section(const ReportInput& input) {
    ReportSection section{.title = "Measured against computed"};
    section.header = {"cause", "range", "k true / k by the paper's evaluation, at both ends", "range from"};
    const Json &causes = result_at(input, "causes/causes"), &joint = result_at(input, "causes/joint");
    if (!causes.is_array() || !joint.is_array()) return section;
    const auto factor = [](const Json& value) { return value.is_number() ? number_text(value, "{:.2f}") : std::string("no k"); };
    for (const Json& cause : causes) {
        const auto unit = cause["unit"].get<std::string>();
        section.rows.push_back({cause["cause"].get<std::string>() + ": " + cause["what"].get<std::string>(),
                                fmt::format("{} to {}{}", number_text(cause["range"][0], "{:.2g}"),
                                            number_text(cause["range"][1], "{:.2g}"), unit.empty() ? "" : " " + unit),
                                fmt::format("{}, {}", factor(cause["factors"][0]), factor(cause["factors"][1])),
                                (cause["evidence"] == "judged" ? "judged: " : "") + cause["source"].get<std::string>()});
    }
    for (const Json& one : joint) {
        std::string text = fmt::format("{} ({} to {})", factor(one["median"]), factor(one["interval"][0]), factor(one["interval"][1]));
        if (one["reaches"].is_number()) text += fmt::format("; {:.1f} % reach it", 100.0 * one["reaches"].get<double>());
        section.rows.push_back({one["what"].get<std::string>() + ", at random", fmt::format("{} draws", one["draws"].get<long>()), text,
                                fmt::format("no k in {:.0f} %", 100.0 * one["without_k"].get<double>())});
    }
    section.intro = fmt::format(
        "Each test is simulated with the cause and evaluated without correction for it. Where Eq. 18 holds exactly, the evaluation gives "
        "{}. "
        "The viscous loss is only {} of the head.",
        number_text(result_at(input, "causes/evaluation_alone"), "{:.2f}"),
        number_text(result_at(input, "causes/viscous_share_of_head"), "{:.2g}"));
    if (result_at(input, "causes/to_explain").is_number())
        section.intro += fmt::format(" To explain: k computed / k measured = {}.", number_text(result_at(input, "causes/to_explain")));
    return section;
}

void add_falling_head_pictures(const ReportInput& input, const Path& folder, ReportSection& inertia, ReportSection& head,
                               ReportSection& causes) {
    const auto copy = [&](const char* file, ReportSection& section, const char* caption) {
        const Path from = input.stage_folders / file;
        if (!fs::exists(from)) return;
        fs::copy_file(from, folder / from.filename(), fs::copy_options::overwrite_existing);
        section.pictures.emplace_back(from.filename().string(), caption);
    };
    copy("forchheimer/forchheimer.svg", inertia, "Apparent permeability against the Reynolds number.");
    const Path level = input.stage_folders / "falling-head" / "falling_head.csv";
    if (fs::exists(level)) fs::copy_file(level, folder / "falling_head.csv", fs::copy_options::overwrite_existing);
    if (fs::exists(level) && draw_plot(folder / "falling_head.svg", "falling_head"))
        head.pictures.emplace_back("falling_head.svg", "Predicted water level over time.");
    copy("causes/effects.svg", head, "Change of the water level by each effect.");
    copy("causes/causes.svg", causes, "k true / k by the paper's evaluation, for each cause at both ends of its range.");
    copy("causes/joint.svg", causes, "All causes at random: share of the draws with a larger factor.");
}

}  // namespace porepack::report
