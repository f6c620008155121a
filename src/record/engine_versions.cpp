#include "record/engine_versions.hpp"

#include "core/json.hpp"
#include "core/process.hpp"

namespace porepack::record {

Json engine_versions() {
    static const Json versions = {{"liggghts", first_line_of("liggghts -log none -h")},
                                  {"openfoam", first_line_of("dpkg-query -W -f '${Version}' openfoam")},
                                  {"mpirun", first_line_of("mpirun --version")},
                                  {"gnuplot", first_line_of("gnuplot --version")}};
    return versions;
}

}  // namespace porepack::record
