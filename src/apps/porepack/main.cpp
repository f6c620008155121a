// The program `porepack`.
#include <fmt/format.h>

#include <cstdio>
#include <new>
#include <string>

#include "apps/porepack/command_line.hpp"
#include "core/interrupt.hpp"
#include "core/passive_waiting.hpp"

namespace {

int report(const std::string& message, porepack::core::ExitCode code) {
    const std::string line = fmt::format("error: {}\n", message);
    (void)std::fwrite(line.data(), 1, line.size(), stderr);  // a log that cannot be written is not an error
    return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv) {
    using porepack::core::ExitCode;
    porepack::core::install_signal_handlers();
    try {
        return porepack::apps::CommandLine().run(argc, argv);
    } catch (const porepack::core::Error& error) {
        return report(error.what(), error.code());
    } catch (const std::bad_alloc&) {
        return report("out of memory\n  fix:     use a larger voxel size or a shorter section", ExitCode::machine);
    } catch (const std::exception& fault) {
        return report(fault.what(), ExitCode::machine);
    }
}
