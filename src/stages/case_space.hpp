// Container, packing and pore space of a case, as far as they exist; and what its stages share.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pore_space/pore_space.hpp"
#include "stages/case.hpp"
#include "uncertainty/section_scatter.hpp"

namespace porepack::stages {

/// [falling_head] of a case, with the inertia coefficient m of its sample if that is known.
[[nodiscard]] falling_head::FallingHeadConfig case_apparatus(const Case& c);
/// The pore space of the geometry and flow stages.
[[nodiscard]] pore_space::PoreSpace case_pore_space(const Case& c);
/// The grains of [shape], meshes read from their files.
[[nodiscard]] std::vector<shapes::ShapeShare> case_shapes(const Case& c);
/// The packing of this configuration has been made.
[[nodiscard]] bool has_packing(const Case& c);
/// The pore space before a packing exists: the expected container and section, for dry runs. Its porosity is
/// expected_porosity().
[[nodiscard]] pore_space::PoreSpace expected_pore_space(const Case& c);
[[nodiscard]] double expected_porosity(const Case& c);
/// Scatter of k of sections of this length, from the gradient along z of the lbm stage; none without one.
[[nodiscard]] std::optional<uncertainty::SectionScatter> section_scatter_of(const Case& c);
/// That of [container]; of a packing found in a scan its own, and before the fit the box of the scan.
[[nodiscard]] vessels::Container case_container(const Case& c);
/// [container] of a case with an image; none if the image names it, or fills a box.
[[nodiscard]] std::optional<vessels::Container> container_of_image(const Case& c);
/// Name of the file that stage `image` writes: gray.vti with gray walls, else pore.vti.
[[nodiscard]] std::string image_file(const Case& c);
/// The stage that makes the solid: "pack", "stl" of a user's surface, or "image".
[[nodiscard]] std::string solid_stage(const Case& c);
/// Whole tables, and of [geometry] only the keys that determine a stage's result: slices do not become stale when the voxel size changes.
[[nodiscard]] core::Json deciding_keys(const Case& c, const std::vector<std::string>& tables, std::set<std::string> geometry_keys,
                                       bool with_section);

}  // namespace porepack::stages
