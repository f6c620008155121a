// The pressure drop that a flow rate needs.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "analysis/pressure_drop.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "packing/film.hpp"
#include "results/read.hpp"
#include "stages/case_space.hpp"

namespace porepack::apps {
namespace {

struct Options {
    double flow_rate_m3_per_s = 0.0, velocity_m_per_s = 0.0, length_m = 0.0, viscosity_Pa_s = 0.0, density_kg_per_m3 = 0.0;
    std::string fluid;
    double temperature_C = NAN;
};

void set_fluid(const Options& options, const Case& c, analysis::PressureDropQuestion& question) {
    for (const auto& [value, flag] : {std::pair(options.viscosity_Pa_s, "--viscosity"), std::pair(options.density_kg_per_m3, "--density")})
        if (value < 0.0 || !std::isfinite(value)) throw UserError(fmt::format("{} is {:g}", flag, value), {.allowed = "a number above 0"});
    if (options.temperature_C < 0.0 || options.temperature_C > 100.0)
        throw UserError(fmt::format("--temperature is {:g}", options.temperature_C), {.allowed = "0 to 100 (degrees Celsius)"});
    const bool own = options.viscosity_Pa_s > 0.0 || options.density_kg_per_m3 > 0.0;
    if (own && (!(options.viscosity_Pa_s > 0.0 && options.density_kg_per_m3 > 0.0) || !options.fluid.empty() ||
                !std::isnan(options.temperature_C)))
        throw UserError(
            "a fluid is named, or has both a viscosity and a density",
            {.where = "--fluid, --viscosity, --density", .fix = "--viscosity 1.8e-5 --density 1.2, or --fluid air --temperature 20"});
    if (own) {
        question.fluid = fmt::format("viscosity {:g} Pa s, density {:g} kg/m3", options.viscosity_Pa_s, options.density_kg_per_m3);
        question.properties = {options.density_kg_per_m3, options.viscosity_Pa_s};
        return;
    }
    const auto& report = c.settings.report;
    const auto named = core::choice_named<permeability::FluidName>(options.fluid);
    if (!options.fluid.empty() && !named)
        throw UserError("there is no fluid `" + options.fluid + "`", {.where = "--fluid", .allowed = "water, air"});
    const auto name = named.value_or(report.fluid);
    const double temperature = std::isnan(options.temperature_C) ? report.temperature_C : options.temperature_C;
    question.fluid = fmt::format("{} at {:g} degrees Celsius", core::name_of(name), temperature);
    question.properties = permeability::fluid_at(name, temperature);
}

// With a film, the grains are larger; with menisci, their area is not known.
void set_grains(const Case& c, const results::CaseResults& found, analysis::PressureDropQuestion& question) {
    if (c.from_image() || c.from_surface()) return;
    packing::Packing grains{.container = stages::case_container(c), .shapes = {}, .bodies = {}};
    std::vector<double> shares;
    for (const auto& [shape, share] : stages::case_shapes(c)) {
        grains.shapes.push_back(shape);
        shares.push_back(share);
    }
    const bool by_volume = c.settings.geometry.film_volume_fraction > 0.0;
    if (by_volume && (!found.voxelise || !found.voxelise->film_thickness_m)) return;
    const double film = by_volume ? *found.voxelise->film_thickness_m : c.settings.geometry.film_thickness_m;
    if (film > 0.0) grains = packing::coated(std::move(grains), film);
    double volume = 0.0, area = 0.0;
    for (std::size_t n = 0; n < shares.size(); ++n) {
        const shapes::ShapeMeasures measures = shapes::measure(grains.shapes[n], 1e-4);
        volume += shares[n] * measures.volume_m3;
        area += shares[n] * measures.surface_area_m2;
    }
    question.equivalent_diameter_m = std::cbrt(6.0 * volume / std::numbers::pi);
    if (c.settings.geometry.closing_radius_m == 0.0) question.sauter_diameter_m = 6.0 * volume / area;
}

void pressure_drop(const Common& common, const Options& options) {
    if (!is_case(common.input)) throw UserError("not a case: " + common.input, {.allowed = "a folder with case.toml and results"});
    const auto positive = [](double value, const char* flag) {
        if (value < 0.0 || !std::isfinite(value)) throw UserError(fmt::format("{} is {:g}", flag, value), {.allowed = "a number above 0"});
        return value > 0.0 ? std::optional(value) : std::nullopt;
    };
    Common of_case = common;
    of_case.output.clear();
    const Case c = open_case(of_case);
    analysis::PressureDropQuestion question{.flow_rate_m3_per_s = positive(options.flow_rate_m3_per_s, "--flow-rate"),
                                            .superficial_velocity_m_per_s = positive(options.velocity_m_per_s, "--velocity"),
                                            .length_m = positive(options.length_m, "--length"),
                                            .name = common.input};
    if (question.flow_rate_m3_per_s.has_value() == question.superficial_velocity_m_per_s.has_value())
        throw UserError("one of --flow-rate and --velocity is needed", {.fix = "--flow-rate 1.4e-4 (m3/s)"});
    set_fluid(options, c, question);
    if (common.dry_run) return print_result(common, {{"fluid", question.fluid}, {"expected", "seconds"}});
    const results::CaseResults found = results::read_results(c.results(), [](const auto& stage) {
        return std::set<std::string>{"pack", "stl", "voxelise", "lbm", "forchheimer", "uncertainty"}.contains(stage);
    });
    set_grains(c, found, question);
    if (found.lbm)
        question.area_m2 =
            (c.from_image() ? stages::case_pore_space(c).container : stages::case_container(c)).vessel().mean_area(found.lbm->section_m);
    const core::Json result = core::json_of(analysis::pressure_drop(found, question));
    if (!common.output.empty()) write_text(common.output, result.dump(2) + "\n");
    print_result(common, result);
}

}  // namespace

void add_pressure_drop_command(CommandLine& line) {
    const auto options = std::make_shared<Options>();
    auto command =
        line.add("pressure-drop", "pressure drop of a case's bed at a flow rate, with its interval, from results that are there",
                 "porepack pressure-drop cases/quickstart --flow-rate 2e-8", [&line, options] { pressure_drop(line.common, *options); });
    command.add_option("input", line.common.input, "a case with results").type_name("path").required();
    command.add_option("--flow-rate", options->flow_rate_m3_per_s, "flow rate").type_name("number [m3/s]");
    command.add_option("--velocity", options->velocity_m_per_s, "or the superficial velocity, flow rate over the container's area")
        .type_name("number [m/s]");
    command.add_option("--length", options->length_m, "length of the bed; default: its height").type_name("number [m]");
    command.add_option("--fluid", options->fluid, "water or air; default: [report] fluid");
    command.add_option("--temperature", options->temperature_C, "of it; default: [report] temperature_C")
        .type_name("number [degrees Celsius]");
    command.add_option("--viscosity", options->viscosity_Pa_s, "of another fluid").type_name("number [Pa s]");
    command.add_option("--density", options->density_kg_per_m3, "of another fluid").type_name("number [kg/m3]");
}

}  // namespace porepack::apps
