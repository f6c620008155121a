// Runs a case as far as its permeability, or resumes it, without the program porepack.
#include <cstdio>
#include <string>

#include <porepack/core/context.hpp>
#include <porepack/core/data_file.hpp>
#include <porepack/core/error.hpp>
#include <porepack/core/json.hpp>
#include <porepack/study/case_pipeline.hpp>

using namespace porepack;

int main(int argc, char** argv) try {
    if (argc != 2) return std::fprintf(stderr, "usage: resume_a_case FOLDER\n"), 2;
    core::set_data_folder(POREPACK_DATA);
    const core::Context run{.log = [](core::LogLevel, std::string_view line) { std::printf("| %s\n", std::string(line).c_str()); },
                            .progress = [](std::string_view, double, double, std::string_view) {},
                            .interrupted = {}};
    const core::ContextScope scope(run);
    const pipeline::Pipeline chain = study::case_pipeline(stages::read_case(argv[1]));
    const core::Json result = pipeline::run_pipeline(chain, "lbm");
    std::printf("k = %.6g m2\n", result.at("permeability_m2").get<double>());
    return 0;
} catch (const core::Error& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return static_cast<int>(error.code());
}
