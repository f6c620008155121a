// What a design has found, in a few sentences; and what it would begin with.
#pragma once

#include <string>
#include <vector>

#include "design/forecast.hpp"

namespace porepack::design {

/// `out_of_time`: the search ended because its time was over.
[[nodiscard]] std::string answer_of(const DesignGoal& goal, const DesignBed& bed, const std::vector<KnownBed>& known,
                                    const DesignResult& result, bool out_of_time);
/// The first proposal with its cost, how well the beds predict each other, and the values that can be reached.
[[nodiscard]] core::Json plan_of(const DesignGoal& goal, const DesignBed& bed, const Forecaster& forecaster);

}  // namespace porepack::design
