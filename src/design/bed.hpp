// The bed that `porepack design` pours for a proposal: that of the base case of the study, in units of its grain.
#pragma once

#include <map>
#include <string>

#include "core/files.hpp"
#include "design/design.hpp"
#include "record/config.hpp"

namespace porepack::design {

/// A container wider than this, in d_v, is replaced by one of this width: its beds would be as large as it, and the wall matters little.
constexpr double widest_bed = 12.0;

/// The stage up to which a proposal runs.
constexpr const char* last_stage = "seeds";

class DesignBed {
public:
    /// `goal` must outlive it.
    DesignBed(const DesignGoal& goal, const study::Study& study);

    [[nodiscard]] double density_kg_per_m3() const { return settings_.packing.density_kg_per_m3; }

    /// Diameter of the container of the finished bed as the poured one has it, for grains of this size; of a box, the scale of its sides.
    [[nodiscard]] double shrink(double size_m) const;
    /// d_v over the diameter of the bed that is poured.
    [[nodiscard]] double wall(double size_m) const { return wall_ratio(size_m, goal_.container) / shrink(size_m); }

    /// case.toml of a proposal. The bed is that of the base case, magnified with the grain, with all that keeps its motion similar: times
    /// grow as the square root of lengths, stiffness as their square.
    [[nodiscard]] std::string case_text(const SizedCandidate& grain, bool full, long packings) const;
    /// The same as a case that is not written: for its expected cost.
    [[nodiscard]] stages::Case planned(const SizedCandidate& grain, long packings) const;

private:
    [[nodiscard]] std::map<std::string, record::Flags> keys(const SizedCandidate& grain, bool full, long packings) const;
    [[nodiscard]] bool too_high(double drop_height_m, const SizedCandidate& grain, bool full) const;
    [[nodiscard]] double fill_height() const;
    [[nodiscard]] record::Flags container_flags(double shrunk, double height_m) const;

    const DesignGoal& goal_;
    core::Path base_;
    stages::Settings settings_;
    double size_m_;  // d_v of the base case's grain
};

}  // namespace porepack::design
