// Results of several cases side by side.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/json_fwd.hpp"

namespace porepack::study {

/// A quantity in one result, with its interval of 95 %; `low` and `high` are NaN where that is not known.
struct ComparedValue {
    double value, low, high;
};
struct Comparison {
    std::vector<std::string> names;  ///< of the results
    struct Row {
        std::string quantity, unit;
        std::vector<ComparedValue> values;  ///< by result; NaN where a result does not have the quantity
    };
    std::vector<Row> rows;
};

/// Reads result.json of folders of results, or of cases. Throws UserError for a folder without results.
[[nodiscard]] Comparison compare_results(const std::vector<core::Path>& folders);
[[nodiscard]] core::Json to_json(const Comparison& comparison);
/// One line per quantity, one column per result.
[[nodiscard]] std::string text_of(const Comparison& comparison);
/// compare.csv; compare.svg: the quantities with an uncertainty, relative to those of the first result; compare.html: both, and the beds.
void write_comparison(const Comparison& comparison, const core::Path& folder);

}  // namespace porepack::study
