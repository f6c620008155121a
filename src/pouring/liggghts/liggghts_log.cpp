#include "pouring/liggghts/liggghts_log.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

namespace porepack::pouring::liggghts {

// True when the line contains information.
bool PourLog::read_line(const std::string& line) {
    Batch batch{};
    if (std::sscanf(line.c_str(), "POREPACK batch %ld spheres %ld", &batch.number, &batch.spheres) == 2) {
        batches.push_back(batch);
    } else if (std::sscanf(line.c_str(), "POREPACK poured %ld", &poured) == 1) {
        settling_J.clear();
    } else if (std::sscanf(line.c_str(), "POREPACK after %ld %ld", &finished, &row) == 2 ||
               std::sscanf(line.c_str(), "POREPACK restless %ld energy %lf limit %lf", &restless, &end_energy_J, &end_limit_J) == 3 ||
               std::sscanf(line.c_str(), "POREPACK short %ld %lf", &short_step, &plate_m) == 2) {
        return true;
    } else if (std::sscanf(line.c_str(), "POREPACK done step %ld spheres %ld energy %lf limit %lf", &end_step, &end_spheres, &end_energy_J,
                           &end_limit_J) == 4) {
        done = true;
    } else {
        // step, spheres, kinetic and rotational energy, height of the bed, top of the highest sphere, seconds of the processor
        std::istringstream words(line);
        std::array<double, 7> values{};
        std::string word;
        std::size_t n = 0;
        for (; words >> word && n < values.size(); ++n) {
            char* end = nullptr;
            values[n] = std::strtod(word.c_str(), &end);
            if (*end != '\0') return false;
        }
        if (n != values.size() || words >> word) return false;
        batch_then = batches.empty() ? 0 : batches.back().number;
        step = static_cast<long>(values[0]);
        spheres = static_cast<long>(values[1]);
        kinetic_J = values[2];
        rotational_J = values[3];
        bed_m = values[4];
        if (poured > 0) settling_J.push_back(kinetic_J + rotational_J);
    }
    return true;
}

void PourLog::read_on(const std::function<void()>& after_line) {
    std::ifstream in(file_);
    in.seekg(read_);
    for (std::string line; std::getline(in, line);) {
        if (in.eof()) break;  // an incomplete line
        read_ = in.tellg();
        if (read_line(line)) after_line();
    }
}

}  // namespace porepack::pouring::liggghts
