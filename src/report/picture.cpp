#include "report/picture.hpp"

#include <filesystem>
#include <optional>

#include "core/process.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace fs = std::filesystem;

bool draw_picture(const Path& stl, const Path& png, const std::vector<std::string>& more) {
    const std::optional<Path> program = porepack_program();
    if (!program) return false;
    std::vector<std::string> command = {program->string(), "picture", fs::absolute(stl).string(), "--output", fs::absolute(png).string()};
    command.insert(command.end(), more.begin(), more.end());
    const Path log = png.parent_path() / "log.picture";
    const bool drawn = run_program({.command = command, .folder = png.parent_path(), .log = log}).exit_code == 0;
    if (drawn) fs::remove(log);
    return drawn;
}

}  // namespace porepack::report
