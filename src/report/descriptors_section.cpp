// Dimensionless numbers of the bed, the part of the wall, and the friction factor beside correlations.
#include <optional>
#include <string>

#include "report/plot.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace {

void add_pictures(const ReportInput& input, const Path& folder, ReportSection& section) {
    (void)take_file(input, "descriptors/radial_distribution.csv", folder);  // drawn beside the contacts
    if (take_file(input, "descriptors/radial.csv", folder) && draw_plot(folder / "radial.svg", "radial"))
        section.pictures.emplace_back("radial.svg",
                                      "Against the distance from the wall: porosity, and superficial velocity over that of the tube.");
    if (take_file(input, "descriptors/contacts.csv", folder) &&
        draw_plot(folder / "structure.svg", "structure", {}, {.width = 760, .height = 300}))
        section.pictures.emplace_back(
            "structure.svg",
            "Left: grains by their number of neighbours in contact. Right: radial distribution of the centres of mass, "
            "over that of random points at the same distances from the walls.");
    if (take_file(input, "descriptors/friction.csv", folder) && draw_plot(folder / "friction.svg", "friction"))
        section.pictures.emplace_back(
            "friction.svg",
            "Friction factor of the computed flows beside correlations for beds: Ergun 1952, Carman 1937, and Eisfeld & "
            "Schnitzlein 2001, which corrects for the wall.");
}

}  // namespace

ReportSection descriptors_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Dimensionless numbers and the wall"};
    section.intro =
        "d_v: diameter of the sphere with the mean volume of a grain. d_32: 6 volume / area of the grains. S: area per volume of the "
        "section, eps: its porosity. The Kozeny constant is 2 in a circular pipe, 3 in a slit, and about 5 in beds of spheres.";
    section.header = {"quantity", "value", "with the container's wall in S"};
    if (!input.results.descriptors) return section;
    const results::Descriptors& found = *input.results.descriptors;
    const auto& numbers = found.numbers;
    const auto add = [&](const std::string& name, const std::string& value, const std::string& with_wall = "") {
        if (value != dash) section.rows.push_back({name, value, with_wall});
    };
    const auto with_unit = [](std::optional<double> value, const char* unit) {
        const std::string text = number_text(value);
        return text == dash ? text : text + " " + unit;
    };
    add("d_v", with_unit(found.equivalent_diameter_m, "m"));
    add("d_32", with_unit(numbers.sauter_diameter_m, "m"));
    add("area per volume of the solid", with_unit(found.surface_per_solid_per_m, "1/m"));
    add("area per volume of the bed, S", with_unit(numbers.surface_per_bed_per_m, "1/m"),
        with_unit(numbers.surface_per_bed_with_wall_per_m, "1/m"));
    add("hydraulic diameter 4 eps / S", with_unit(numbers.hydraulic_diameter_m, "m"),
        with_unit(numbers.hydraulic_diameter_with_wall_m, "m"));
    add("k / d_v² (Darcy number)", number_text(numbers.permeability_over_equivalent_diameter2));
    add("k / d_32²", number_text(numbers.permeability_over_sauter_diameter2));
    add("Kozeny constant eps³ / (k S²)", number_text(numbers.kozeny_constant, "{:.3f}"),
        number_text(numbers.kozeny_constant_with_wall, "{:.3f}"));
    if (found.wall)
        add("k of the core / k (mean velocity more than one d_v from the wall; the core is usually denser)",
            number_text(found.wall->core_over_tube_permeability, "{:.3f}"));
    add("k of an infinitely wide bed of the same porosity / k, Carman's wall correction",
        number_text(numbers.carman_wall_factor, "{:.3f}"));
    if (const auto& structure = found.structure) {
        const auto vertical = [](const std::optional<results::Tensor>& tensor) {
            return tensor ? number_text((*tensor)[2][2], "{:.3f}") : dash;
        };
        add("capsule axes: mean of cos² of the angle to z (1/3: no direction preferred)", vertical(structure->orientation_tensor));
        add("contact normals: mean of cos² of the angle to z", vertical(structure->contact_orientation_tensor));
        add("neighbours in contact per grain", number_text(structure->mean_neighbours, "{:.2f}"));
    }
    add_pictures(input, folder, section);
    return section;
}

}  // namespace porepack::report
