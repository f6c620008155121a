// The results of a case, read from its files.
#pragma once

#include <filesystem>

#include "core/files.hpp"
#include "core/members_json.hpp"
#include "results/results.hpp"

namespace porepack::results {

/// result.json of the stage in the folder `case_results`, which must exist. Throws UserError with file and key where it is not such a
/// result.
template <typename Result>
[[nodiscard]] Result read_result(const core::Path& case_results) {
    const core::Path file = case_results / Result::stage / "result.json";
    return core::from_json_members<Result>(core::read_json(file), file.string());
}

/// The results that exist of the stages for which wanted(name) is true.
template <typename Wanted>
[[nodiscard]] CaseResults read_results(const core::Path& case_results, const Wanted& wanted) {
    CaseResults found;
    visit_members(found, [&]<typename Key>(const char* stage, Key& result) {
        if (wanted(stage) && std::filesystem::exists(case_results / stage / "result.json"))
            result = read_result<typename Key::value_type>(case_results);
    });
    return found;
}

}  // namespace porepack::results
