// A packing as a page shows it.
#pragma once

#include <array>
#include <optional>

#include "core/files.hpp"
#include "core/interval.hpp"
#include "imaging/volume.hpp"
#include "packing/packing.hpp"
#include "report/bed_view.hpp"

namespace porepack::analysis {

/// The grains exactly as they lie; those within a thousandth of their thickness touch. Their surfaces are within a hundredth of their
/// thickness (of more than 300 grains, three hundredths).
[[nodiscard]] report::BedView bed_view_of(const packing::Packing& packing, std::optional<core::Interval> section_m = {});
/// Adds some streamlines of flow.vti, along the direction that it names, and speed and pressure on the plane through its middle. Nothing
/// where the file is missing, or too large to be looked at.
void add_flow(report::BedView& bed, const core::Path& flow_vti);

/// A scan alone. `low_m`: lowest corner of its first voxel.
[[nodiscard]] report::BedView scan_view_of(const imaging::VolumeSource& scan, const std::array<double, 3>& low_m);
/// Adds its gray values, binned to some six million voxels; `low_m` in the packing's frame. UserError for a thin image of many more.
void add_scan(report::BedView& bed, const imaging::VolumeSource& scan, const std::array<double, 3>& low_m);

}  // namespace porepack::analysis
