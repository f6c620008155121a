#include "study/study_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/data_file.hpp"
#include "core/owned_names.hpp"
#include "study/uses.hpp"

namespace porepack::study {

// What is written into it may become old, except for the list of points: a point that is done ends at once.
Path write_snakefile(const Study& study) {
    std::string points;
    double memory = 0.0;
    for (const Point& point : study.points) {
        points += fmt::format("    \"{}\",\n", point.name);
        if (&point == &study.points.front() || &point == &study.points.back())
            memory = std::max(memory, expectation_of(study, point).memory_bytes);
    }
    const std::string text = fmt::format(
        "# Written by `porepack study export --snakemake`. It runs in this folder: snakemake --cores 2\n"
        "# On a cluster with Slurm: docs/cluster.md.\n"
        "points = [\n{}]\n"
        "threads_each = int(config.get(\"threads\", 1))\n"
        "memory_mb = int(config.get(\"memory_mb\", {:.0f}))\n",
        points, std::max(500.0, 1.25 * memory / 1e6));
    Path file = study.folder / "Snakefile";
    write_own_text(file, text + read_text(data_file("templates/Snakefile")));
    return file;
}

}  // namespace porepack::study
