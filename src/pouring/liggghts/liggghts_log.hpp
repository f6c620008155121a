// Reads the log of a running or finished LIGGGHTS pour. Only for the sources of this folder.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/files.hpp"

namespace porepack::pouring::liggghts {

// LIGGGHTS does not report lost grains and ends with exit code 0: the script prints additional lines ("POREPACK ...").
struct PourLog {
    struct Batch {
        long number, spheres;  // number of spheres just after its creation
    };
    std::vector<Batch> batches;
    long poured = 0;  // batches, known when pouring has ended
    long step = 0, spheres = 0, batch_then = 0;
    double kinetic_J = 0.0, rotational_J = 0.0, bed_m = 0.0;  // of the last line
    std::vector<double> settling_J;                           // kinetic energy of each line after the end of pouring
    long finished = 0, row = 0;                               // last step of [protocol], and its part, whose bed was written
    long restless = -1;                                       // step after which the bed did not come to rest; 0: the pour
    long short_step = 0;                                      // step whose plate would not touch the bed, and the height of its top
    double plate_m = 0.0;
    bool done = false;
    long end_step = 0, end_spheres = 0;
    double end_energy_J = 0.0, end_limit_J = 0.0;

    explicit PourLog(core::Path file) : file_(std::move(file)) {}
    // Reads the lines written since the last call, and calls `after_line` after each line that contains information.
    void read_on(const std::function<void()>& after_line);

private:
    bool read_line(const std::string& line);
    core::Path file_;
    std::streamoff read_ = 0;
};

}  // namespace porepack::pouring::liggghts
