// Measured falling-head curves, evaluated as in the paper and by least squares: each separately, and those of one packing together.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "falling_head/least_squares.hpp"
#include "falling_head/paper_evaluation.hpp"

namespace porepack::falling_head {

struct CurveAnalysis {
    LevelCurve curve;  ///< its window
    PaperEvaluation as_paper;
    FallingHeadFit fit;
    bool doubtful = false;  ///< a warning gives the reason why its numbers may be meaningless
};

struct PackingAnalysis {
    std::string packing;
    std::vector<std::size_t> curves;  ///< indices of its curves
    FallingHeadFit fit;               ///< common fit of all of them
    bool doubtful = false;
};

/// Of 1/k and 1/k_in, because the errors are additive in these.
struct Scatter {
    double mean = 0.0;                       ///< over the packings
    std::optional<double> within_packings;   ///< standard deviation of single curves' fits about their packing's mean
    std::optional<double> between_packings;  ///< standard deviation of the packings' means
};

struct FallingHeadAnalysis {
    std::vector<CurveAnalysis> curves;
    std::vector<PackingAnalysis> packings;  ///< by name
    std::vector<std::string> warnings;
    Scatter inverse_permeability_per_m2, inverse_inertial_permeability_per_m;
    /// Mean and standard deviation of the paper's evaluation over the curves for which it gives a k.
    std::size_t curves_with_paper_k = 0;
    std::optional<double> paper_mean_m2, paper_deviation_m2;
};

/// `curves` are windows (take_window). Throws UserError when one is given twice, NumericalError when a fit fails.
[[nodiscard]] FallingHeadAnalysis analyse_curves(const std::vector<LevelCurve>& curves, const FallingHeadConfig& config);

}  // namespace porepack::falling_head
