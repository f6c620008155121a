// Cases: a folder with case.toml is run as by the program, and results are read.
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <string>

#include "bindings/host.hpp"
#include "bindings/objects.hpp"
#include "core/error.hpp"
#include "results/read.hpp"
#include "study/case_pipeline.hpp"
#include "study/study_run.hpp"

namespace porepack::python {
namespace {

stages::Case read_case(const std::string& folder, const std::string& output, const py::dict& set) {
    std::map<std::string, record::Flags> values;
    for (const auto& [name, value] : set) {
        const auto key = py::str(name).cast<std::string>();
        const std::size_t point = key.find('.');
        if (point == std::string::npos)
            throw core::UserError("`" + key + "` names no table",
                                  {.where = "run_case(set=...)", .allowed = "{\"table.key\": value}", .fix = "as \"packing.grains\""});
        values[key.substr(0, point)][key.substr(point + 1)] = record::toml_text(json_of(value, key));
    }
    if (!values.empty() && output.empty())
        throw core::UserError("changed keys need a folder of their own for the results",
                              {.where = "run_case()", .fix = "output = \"...\""});
    stages::Case c = stages::read_case(folder, {}, {}, values);
    if (!output.empty()) c.output = output;
    return c;
}

std::string run_case(const std::string& folder, const std::string& up_to, const std::string& output, const py::dict& set) {
    const stages::Case c = read_case(folder, output, set);
    run_in_thread([&] { (void)pipeline::run_pipeline(study::case_pipeline(c), up_to); });
    return c.results().string();
}

// The results folder itself, or that of a case.
core::Path results_folder(const core::Path& folder) {
    if (std::filesystem::exists(folder / "case.toml")) return folder / "results";
    return folder;
}

py::dict read_result(const std::string& folder_name) {
    const core::Path folder = results_folder(folder_name);
    results::CaseResults found;
    bool any = false;
    visit_members(found, [&]<typename Member>(const char* stage, Member& member) {
        if (!std::filesystem::exists(folder / stage / "result.json")) return;
        member = results::read_result<typename Member::value_type>(folder);
        any = true;
    });
    if (!any)
        throw core::UserError("there are no results",
                              {.where = folder.string(), .allowed = "a case, or its folder results", .fix = "run_case(folder)"});
    return to_python(found);
}

py::dict run_study(const std::string& folder, const std::string& points, double max_time_s) {
    const study::Study the_study = study::read_study(folder);
    return to_python(run([&] { return study::run_study(the_study, {.points = points, .max_time_s = max_time_s}); }));
}

}  // namespace

void bind_cases(py::module_& module) {
    module.def("run_case", &run_case);
    module.def("read_result", &read_result);
    module.def("run_study", &run_study);
    module.def("study_status", [](const std::string& folder) { return to_python(study::status_of(study::read_study(folder))); });
    module.def("study_table", [](const std::string& folder) { return study::read_study(folder).table().string(); });
}

}  // namespace porepack::python
