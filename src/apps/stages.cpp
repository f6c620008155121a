// The stages behind the flow, and what all stages share.
#include "apps/stages.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/process.hpp"
#include "permeability/falling_head.hpp"
#include "permeability/permeability.hpp"

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

Json falling_head_stage(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config, const Path* folder) {
    const FallingHead test(permeability_m2, inertial_permeability_m, config);
    Json json = {{"permeability_m2", permeability_m2},
                 {"inertial_permeability_m", std::isfinite(inertial_permeability_m) ? Json(inertial_permeability_m) : Json("infinite")},
                 {"sample_length_m", config.sample_length_m},
                 {"start_level_m", config.start_level_m},
                 {"levels_m", config.levels_m},
                 {"times_s", Json::array()}};
    for (const double level : config.levels_m) {
        const double time = test.time_at(level);
        if (!std::isfinite(time))
            throw UserError(fmt::format("the time at which the level passes {:g} m is beyond all numbers", level),
                            {.mend = "check k, k_in, the viscosity and gravity: SI units"});
        json["times_s"].push_back(time);
    }
    const double speed = test.speed_at(config.start_level_m);
    json["start_speed_m_per_s"] = speed;
    // Water that falls freely from the start level would be no faster than this.
    const double free_fall = std::sqrt(2.0 * config.gravity_m_per_s2 * (config.start_level_m + config.sample_length_m));
    if (speed > free_fall)
        json["warning"] = fmt::format(
            "the water would start at {:.3g} m/s, faster than it can fall ({:.3g} m/s): Darcy's law alone does not hold here; give an "
            "inertial "
            "permeability",
            speed, free_fall);
    json["equation"] = "Eq. 18, closed form, without the inertia of the water column";
    if (folder != nullptr) {
        std::string text = "time_s,level_m\n";
        const double end = test.time_at(0.0);
        for (int i = 0; i <= 200; ++i) text += fmt::format("{:.8g},{:.8g}\n", end * i / 200, std::max(0.0, test.level_at(end * i / 200)));
        write_text(*folder / "falling_head.csv", text);
    }
    return json;
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
