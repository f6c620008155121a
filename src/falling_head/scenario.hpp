// Simulated falling-head tests, evaluated as in the paper; only for the sources of this folder.
#pragma once

#include <functional>
#include <vector>

#include "falling_head/causes.hpp"
#include "falling_head/paper_evaluation.hpp"

namespace porepack::falling_head {

/// The simulated test.
struct Scenario {
    FallingHeadConfig apparatus;
    Resistance resistance;
};

/// One row of a table of causes: how the simulated test differs from a given scenario, and how it is evaluated.
struct ScenarioRow {
    std::string name, what;
    std::function<void(Scenario&)> change = [](Scenario&) {};
    std::vector<double> window_m = {};  ///< window of the evaluation; empty: that of the config
    double noise_m = 0.0;               ///< standard deviation of each level; 0: none, else the median of 400 curves
};

/// Evaluates scenarios of one sample and one apparatus.
class ScenarioStudy {
public:
    ScenarioStudy(const SampleTruth& truth, const FallingHeadConfig& config);

    /// Eq. 18 holds exactly: only the sample.
    [[nodiscard]] Scenario base() const { return {bare_, sample(1.0, 1.0)}; }
    /// The sample with 1/k and 1/k_in times these factors.
    [[nodiscard]] Resistance sample(double viscous, double inertial) const {
        return {viscous / truth_.permeability_m2, inertial / truth_.inertial_permeability_m};
    }
    /// The apparatus with all its effects.
    [[nodiscard]] const FallingHeadConfig& full() const { return full_; }

    /// k true / k by the paper's evaluation, which assumes the bare apparatus, for `from` with the change of the row.
    [[nodiscard]] Cause evaluate(const ScenarioRow& row, const Scenario& from) const;
    /// The level offset that makes `scenario` give this factor: 1/k evaluated is nearly linear in it. None within 30 mm.
    [[nodiscard]] std::optional<double> explaining_offset(Scenario scenario, double factor_wanted) const;

private:
    [[nodiscard]] PaperEvaluation evaluation_of(const Scenario& scenario, const FallingHeadConfig& assumed) const;
    [[nodiscard]] Cause factor(const std::string& name, const std::string& what, const Scenario& scenario,
                               const FallingHeadConfig& assumed) const;
    [[nodiscard]] Cause noise(const std::string& name, const std::string& what, Scenario scenario, double noise_m) const;

    SampleTruth truth_;
    FallingHeadConfig full_, bare_;
};

}  // namespace porepack::falling_head
