// What a running or ended LIGGGHTS pour has said in its log. Only for the sources of this room.
#pragma once

#include <functional>
#include <vector>

#include "core/files.hpp"

namespace porepack::packing::liggghts {

// LIGGGHTS itself says nothing of grains that it loses and ends with exit code 0: the script prints lines of its own ("POREPACK ...").
struct PourLog {
    struct Batch {
        long number, spheres;  // all spheres present just after its creation
    };
    std::vector<Batch> batches;
    long poured = 0;  // batches, once pouring is over
    long step = 0, spheres = 0, batch_then = 0;
    double kinetic_J = 0.0, rotational_J = 0.0, bed_m = 0.0;  // of the last line
    std::vector<double> settling_J;                           // kinetic energy of each line since pouring was over
    bool done = false;
    long end_step = 0, end_spheres = 0;
    double end_energy_J = 0.0, end_limit_J = 0.0;

    explicit PourLog(core::Path file) : file_(std::move(file)) {}
    // Reads what was written since the last call, and calls `after_line` after each line that says something.
    void read_on(const std::function<void()>& after_line);

private:
    bool read_line(const std::string& line);
    core::Path file_;
    std::streamoff read_ = 0;
};

}  // namespace porepack::packing::liggghts
