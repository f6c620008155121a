// The coarsest scan that is good enough: `porepack image plan`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::results {

/// A simulated scan, its grains fitted; errors of the fitted packing.
struct ScanTrial {
    double voxel_size_m = 0.0;
    double voxels_per_diameter = 0.0;
    long views = 0;
    double counts = 0.0;
    long whole_grains_found = 0;
    long false_grains = 0;
    std::optional<double> porosity_error{};      ///< none where no grain was found
    std::optional<double> permeability_error{};  ///< relative
    std::size_t doubts = 0;
    bool good = false;  ///< the error of k is within the wanted one
    double fit_s = 0.0;
};
template <core::MembersOf<ScanTrial> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("voxel_size_m", found.voxel_size_m);
    visit("voxels_per_diameter", found.voxels_per_diameter);
    visit("views", found.views);
    visit("counts", found.counts);
    visit("whole_grains_found", found.whole_grains_found);
    visit("false_grains", found.false_grains);
    visit("porosity_error", found.porosity_error);
    visit("permeability_error", found.permeability_error);
    visit("doubts", found.doubts);
    visit("good", found.good);
    visit("fit_s", found.fit_s);
}

struct ScanPlan {
    core::Interval section_m;  ///< that no end of the scan cuts
    long whole_grains = 0;
    double porosity_exact = 0.0;  ///< of the true packing on the same voxels
    double permeability_exact_m2 = 0.0;
    double within = 0.0;
    std::vector<ScanTrial> rows;
    std::optional<double> coarsest_good_voxel_size_m{};
    std::string meaning =
        "errors of porosity and k of the fitted packing in a section that no end of the scan cuts; exact: of the true packing on the same "
        "voxels; good: the error of k is within the wanted one; one noise per row, so rows near the limit can change with --seed";
};
template <core::MembersOf<ScanPlan> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("section_m", found.section_m);
    visit("whole_grains", found.whole_grains);
    visit("porosity_exact", found.porosity_exact);
    visit("permeability_exact_m2", found.permeability_exact_m2);
    visit("within", found.within);
    visit("rows", found.rows);
    visit("coarsest_good_voxel_size_m", found.coarsest_good_voxel_size_m);
    visit("meaning", found.meaning);
}

}  // namespace porepack::results
