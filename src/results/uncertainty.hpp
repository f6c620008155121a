// How sure the numbers are: results/uncertainty/result.json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"
#include "uncertainty/budget.hpp"

namespace porepack::results {

struct Statement {
    std::optional<double> value{};
    std::optional<core::Interval> interval{};  ///< of 95 %
    std::size_t packings = 1;                  ///< that it is from
    core::OptionalKey<std::string> why = {};   ///< of a value that is not known
};
template <core::MembersOf<Statement> Self, typename Visit>
void visit_members(Self& statement, const Visit& visit) {
    visit("value", statement.value);
    visit("interval", statement.interval);
    visit("packings", statement.packings);
    visit("why", statement.why);
}

/// k of the bed that exists, from its measured porosity.
struct StatementOfBed {
    Statement statement;
    double measured_porosity = 0.0, measured_standard_uncertainty = 0.0;
    std::string measured_part;  ///< "bed", "section", "between"
};
template <core::MembersOf<StatementOfBed> Self, typename Visit>
void visit_members(Self& bed, const Visit& visit) {
    visit("", bed.statement);
    visit("measured_porosity", bed.measured_porosity);
    visit("measured_standard_uncertainty", bed.measured_standard_uncertainty);
    visit("measured_part", bed.measured_part);
}

struct Statements {
    Statement this_packing, mean_of_such_packings, next_such_packing;
    core::OptionalKey<StatementOfBed> bed_of_measured_porosity = {};
};
template <core::MembersOf<Statements> Self, typename Visit>
void visit_members(Self& statements, const Visit& visit) {
    visit("this_packing", statements.this_packing);
    visit("mean_of_such_packings", statements.mean_of_such_packings);
    visit("next_such_packing", statements.next_such_packing);
    visit("bed_of_measured_porosity", statements.bed_of_measured_porosity);
}

struct Uncertainty {
    static constexpr const char* stage = "uncertainty";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 3;
    std::vector<uncertainty::BudgetRow> budget_of_permeability;
    core::ByName<Statements> statements;  ///< by quantity (results/quantities.hpp)
    std::string meaning;
};
template <core::MembersOf<Uncertainty> Self, typename Visit>
void visit_members(Self& sure, const Visit& visit) {
    visit("budget_of_permeability", sure.budget_of_permeability);
    visit("statements", sure.statements);
    visit("meaning", sure.meaning);
}

}  // namespace porepack::results
