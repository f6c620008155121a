// The report's main numbers: results/report/result.json; and what a stage has cost, of its manifest.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::results {

struct MainNumber {
    std::string label, text;
};
template <core::MembersOf<MainNumber> Self, typename Visit>
void visit_members(Self& number, const Visit& visit) {
    visit("label", number.label);
    visit("text", number.text);
}

struct Report {
    static constexpr const char* stage = "report";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 5;
    std::string report = "report.html";
    std::vector<MainNumber> main_numbers;
    std::vector<std::string> notes;
};
template <core::MembersOf<Report> Self, typename Visit>
void visit_members(Self& report, const Visit& visit) {
    visit("report", report.report);
    visit("main_numbers", report.main_numbers);
    visit("notes", report.notes);
}

/// How sure a value is: of 95 %, and a standard uncertainty where it is from one.
struct QuantityUncertainty {
    core::OptionalKey<std::optional<core::Interval>> interval = {};
    core::OptionalKey<double> standard_uncertainty = {};
};
template <core::MembersOf<QuantityUncertainty> Self, typename Visit>
void visit_members(Self& uncertainty, const Visit& visit) {
    visit("interval", uncertainty.interval);
    visit("standard_uncertainty", uncertainty.standard_uncertainty);
}

/// A main number in merged.json, which becomes result.json of a case.
struct ReportedQuantity {
    std::string name;
    double value = 0.0;
    std::string unit, method;
    std::optional<QuantityUncertainty> uncertainty{};
    std::optional<bool> converged{};
    std::optional<double> cost_s{};
};
template <core::MembersOf<ReportedQuantity> Self, typename Visit>
void visit_members(Self& quantity, const Visit& visit) {
    visit("name", quantity.name);
    visit("value", quantity.value);
    visit("unit", quantity.unit);
    visit("method", quantity.method);
    visit("uncertainty", quantity.uncertainty);
    visit("converged", quantity.converged);
    visit("cost_s", quantity.cost_s);
}

struct StageCost {
    double wall_time_s = 0.0, peak_memory_bytes = 0.0;
    long seed = 0, processes = 1;
};
template <core::MembersOf<StageCost> Self, typename Visit>
void visit_members(Self& cost, const Visit& visit) {
    visit("wall_time_s", cost.wall_time_s);
    visit("peak_memory_bytes", cost.peak_memory_bytes);
    visit("seed", cost.seed);
    visit("processes", cost.processes);
}

}  // namespace porepack::results
