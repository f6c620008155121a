// What the tests that cross components share: the whole library in view, and the program.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/process.hpp"
#include "geometry/grid.hpp"
#include "support/basics.hpp"
#include "support/whole_library.hpp"

namespace porepack::test {

/// A flow image as the writer of flow.vti takes it. It must outlive the result.
inline LayeredFlow as_layers(const FlowImage& flow) {
    return {.grid = flow.grid, .own = {0, flow.grid.cells[2]}, .notes = flow.notes, .layers = [&flow](int first, int end) {
                FlowImage part{.grid = flow.grid, .velocity_m_per_s = {}, .pressure_Pa = {}, .phase = {}, .notes = {}};
                part.grid.cells[2] = end - first;
                part.grid.origin_m[2] = flow.grid.origin_m[2] + first * flow.grid.spacing_m[2];
                const std::size_t begin = flow.grid.index(0, 0, first), last = flow.grid.index(0, 0, end);
                part.velocity_m_per_s.assign(flow.velocity_m_per_s.data() + 3 * begin, flow.velocity_m_per_s.data() + 3 * last);
                part.pressure_Pa.assign(flow.pressure_Pa.data() + begin, flow.pressure_Pa.data() + last);
                part.phase.assign(flow.phase.data() + begin, flow.phase.data() + last);
                return part;
            }};
}

struct Output {
    int exit_code;
    std::string out, err;
    [[nodiscard]] Json json() const { return Json::parse(out); }
};

/// Runs the program through a shell: `before` is put in front (for instance "ulimit -f 1;").
inline Output porepack(const std::string& arguments, const std::string& before = "") {
    const Path base = std::filesystem::temp_directory_path() / ("porepack_output_" + std::to_string(getpid()));
    const std::string command =
        before + " " + quoted(POREPACK_PROGRAM) + " " + arguments + " > " + base.string() + ".out 2> " + base.string() + ".err";
    const int status = std::system(command.c_str());
    Output output{.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128, .out = {}, .err = {}};
    output.out = read_text(base.string() + ".out");
    output.err = read_text(base.string() + ".err");
    std::filesystem::remove(base.string() + ".out");
    std::filesystem::remove(base.string() + ".err");
    return output;
}

/// True if jsonschema is installed for Debian's Python.
inline bool has_schema_validator() {
    static const bool has = std::system("/usr/bin/python3 -c 'import jsonschema' > /dev/null 2>&1") == 0;
    return has;
}

/// Faults of the results of a case against docs/schema, one per line; nothing without a validator, which test Schemas.AreChecked reports.
inline std::string schema_faults(const Path& results) {
    if (!has_schema_validator()) return {};
    const Path output = results.parent_path() / "schema_faults", source = POREPACK_SOURCE_FOLDER;
    const std::string command = "/usr/bin/python3 -W ignore " + quoted(source / "tests/system/validate.py") + " " +
                                quoted(source / "docs/schema") + " " + quoted(results) + " > " + quoted(output) + " 2>&1";
    const int status = std::system(command.c_str());
    return read_text(output) + (status == 0 ? "" : "validate.py failed");
}

/// Skips a test, visibly, when a package of packages.apt or packages-test.apt is not installed. In CI (.ci/run sets
/// POREPACK_PACKAGES=required) the test fails.
inline bool packages_are_required() {
    const char* const packages = std::getenv("POREPACK_PACKAGES");
    return packages != nullptr && std::string(packages) == "required";
}
#define REQUIRE_INSTALLED(installed, name)                                                    \
    if (!(installed)) {                                                                       \
        if (::porepack::test::packages_are_required()) FAIL() << name << " is not installed"; \
        GTEST_SKIP() << name << " is not installed";                                          \
    }
#define REQUIRE_PROGRAM(name) REQUIRE_INSTALLED(::porepack::find_program(name), name)

}  // namespace porepack::test
