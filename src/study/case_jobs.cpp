#include "study/case_jobs.hpp"

#include <fmt/format.h>

#include "core/json.hpp"
#include "record/toml_file.hpp"
#include "study/case_pipeline.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;
std::vector<std::string> set_arguments(const Case& c) {
    const Json in_file = read_case(c.folder).settings.resolved_tables(), wanted = c.settings.resolved_tables();
    std::vector<std::string> arguments;
    for (const auto& [table, keys] : wanted.items())
        for (const auto& [key, value] : keys.items())
            if (!in_file.at(table).contains(key) || in_file[table][key] != value)
                arguments.insert(arguments.end(), {"--set", fmt::format("{}.{}={}", table, key, toml_text(value))});
    return arguments;
}

Case case_of_seed(const Case& c, long seed) {
    Case one = c;
    one.settings.packing.seed = seed;
    one.settings.packings = {};
    one.settings.packing.friction_uncertainty = 0.0;
    one.settings.lbm.fields = lbm::FieldFiles::none;
    one.output = c.results() / fmt::format("seed_{}", seed);
    return one;
}

Job job_of(const Case& c, const std::string& last, const std::string& name) {
    make_folder(c.results());
    Job job{.name = name,
            .arguments = {"run", fs::absolute(c.folder).string(), "--up-to", last, "--output", fs::absolute(c.results()).string()},
            .log = c.results() / "log.porepack"};
    const std::vector<std::string> set = set_arguments(c);
    job.arguments.insert(job.arguments.end(), set.begin(), set.end());
    return job;
}

double expected_memory_bytes(const Case& c, const std::string& last) {
    return pipeline::expected_of(case_pipeline(c), last).memory_bytes;
}

}  // namespace porepack::study
