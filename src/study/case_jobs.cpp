#include "study/case_jobs.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "core/json.hpp"
#include "study/case_pipeline.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;

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
