// The stages behind the flow, and what all stages share.
#include "apps/stages.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/process.hpp"

namespace porepack {

std::string expect_text(const Expectation& expected) {
    return fmt::format("{}; memory about {}, time about {}", expected.text, human_bytes(expected.memory_bytes),
                       human_time(expected.wall_time_s));
}

Path home_folder() {
    const char* home = std::getenv("POREPACK_HOME");
    const Path folder = home != nullptr ? Path(home) : Path(POREPACK_SOURCE_FOLDER);
    if (!std::filesystem::exists(folder / "liggghts_templates"))
        throw UserError("the folder liggghts_templates/ is not in " + folder.string(),
                        {.mend = "set POREPACK_HOME to the project's folder"});
    return folder;
}

bool draw_picture(const Path& stl, const Path& png, const std::vector<std::string>& more) {
    std::vector<std::string> command = {std::filesystem::read_symlink("/proc/self/exe").string(), "picture",
                                        std::filesystem::absolute(stl).string(), "--output", std::filesystem::absolute(png).string()};
    command.insert(command.end(), more.begin(), more.end());
    const Path log = png.parent_path() / "log.picture";
    const bool drawn = run_program({.command = command, .folder = png.parent_path(), .log = log}).exit_code == 0;
    if (drawn) std::filesystem::remove(log);
    return drawn;
}

}  // namespace porepack
