// The program `porepack`.
#include <fmt/format.h>

#include <cstdio>
#include <new>

#include "apps/porepack/command_line.hpp"
#include "core/interrupt.hpp"

namespace {

int report(const std::string& message, porepack::ExitCode code) {
    fmt::print(stderr, "error: {}\n", message);
    return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv) {
    using porepack::ExitCode;
    porepack::install_signal_handlers();
    try {
        return porepack::CommandLine().run(argc, argv);
    } catch (const porepack::Error& error) {
        return report(error.what(), error.code());
    } catch (const std::bad_alloc&) {
        return report("out of memory\n  fix:     take a larger voxel size or a shorter section", ExitCode::machine);
    } catch (const std::exception& fault) {
        return report(fault.what(), ExitCode::machine);
    }
}
