// Dimensionless numbers of the bed, the part of the wall, and the friction factor beside correlations.
#include "core/table.hpp"
#include "report/plot.hpp"
#include "report/section.hpp"

namespace porepack::report {
using namespace core;
namespace fs = std::filesystem;

ReportSection descriptors_section(const ReportInput& input) {
    ReportSection section{.title = "Dimensionless numbers and the wall"};
    section.intro =
        "d_v: diameter of the sphere with the mean volume of a grain. d_32: 6 volume / area of the grains. S: area per volume of the "
        "section, eps: its porosity. The Kozeny constant is 2 in a circular pipe, 3 in a slit, and about 5 in beds of spheres.";
    section.header = {"quantity", "value", "with the container's wall in S"};
    const auto number = [&](const char* key) -> const Json& { return result_at(input, std::string("descriptors/numbers/") + key); };
    const auto add = [&](const std::string& name, const std::string& value, const std::string& with_wall = "") {
        if (value != "–") section.rows.push_back({name, value, with_wall});
    };
    const auto with_unit = [](const Json& value, const char* unit) {
        return value.is_number() ? number_text(value) + " " + unit : std::string("–");
    };
    const auto metres = [&](const Json& value) { return with_unit(value, "m"); };
    add("d_v", metres(result_at(input, "descriptors/equivalent_diameter_m")));
    add("d_32", metres(number("sauter_diameter_m")));
    add("area per volume of the solid", with_unit(result_at(input, "descriptors/surface_per_solid_per_m"), "1/m"));
    add("area per volume of the bed, S", with_unit(number("surface_per_bed_per_m"), "1/m"),
        with_unit(number("surface_per_bed_with_wall_per_m"), "1/m"));
    add("hydraulic diameter 4 eps / S", metres(number("hydraulic_diameter_m")), metres(number("hydraulic_diameter_with_wall_m")));
    add("k / d_v² (Darcy number)", number_text(number("permeability_over_equivalent_diameter2")));
    add("k / d_32²", number_text(number("permeability_over_sauter_diameter2")));
    add("Kozeny constant eps³ / (k S²)", number_text(number("kozeny_constant"), "{:.3f}"),
        number_text(number("kozeny_constant_with_wall"), "{:.3f}"));
    add("k of the core / k (mean velocity more than one d_v from the wall; the core is usually denser)",
        number_text(result_at(input, "descriptors/wall/core_over_tube_permeability"), "{:.3f}"));
    add("k of an infinitely wide bed of the same porosity / k, Carman's wall correction",
        number_text(number("carman_wall_factor"), "{:.3f}"));
    const auto vertical = [&](const char* key) {
        const Json& tensor = result_at(input, std::string("descriptors/structure/") + key);
        return tensor.is_array() ? number_text(tensor[2][2], "{:.3f}") : std::string("–");
    };
    add("capsule axes: mean of cos² of the angle to z (1/3: no direction preferred)", vertical("orientation_tensor"));
    add("contact normals: mean of cos² of the angle to z", vertical("contact_orientation_tensor"));
    add("neighbours in contact per grain", number_text(result_at(input, "descriptors/structure/mean_neighbours"), "{:.2f}"));
    if (!result_at(input, "descriptors/numbers").is_object()) section.rows.clear();
    return section;
}

void add_descriptor_pictures(const ReportInput& input, const Path& folder, ReportSection& section) {
    for (const char* file : {"radial.csv", "friction.csv", "contacts.csv", "radial_distribution.csv"}) {
        const Path made = input.stage_folders / "descriptors" / file;
        if (fs::exists(made)) fs::copy_file(made, folder / file, fs::copy_options::overwrite_existing);
    }
    if (fs::exists(folder / "radial.csv") && draw_plot(folder / "radial.svg", "radial"))
        section.pictures.emplace_back("radial.svg",
                                      "Against the distance from the wall: porosity, and superficial velocity over that of the tube.");
    if (fs::exists(folder / "contacts.csv") && draw_plot(folder / "structure.svg", "structure", {}, {.width = 760, .height = 300}))
        section.pictures.emplace_back(
            "structure.svg",
            "Left: grains by their number of neighbours in contact. Right: radial distribution of the centres of mass, "
            "over that of random points at the same distances from the walls.");
    if (fs::exists(folder / "friction.csv") && draw_plot(folder / "friction.svg", "friction"))
        section.pictures.emplace_back(
            "friction.svg",
            "Friction factor of the computed flows beside correlations for beds: Ergun 1952, Carman 1937, and Eisfeld & "
            "Schnitzlein 2001, which corrects for the wall.");
}

}  // namespace porepack::report
