#include "analysis/outcome.hpp"

#include "io/image.hpp"
#include "io/stl.hpp"

namespace porepack::analysis {

void write_files(const Files& files, const core::Path& folder) {
    for (const auto& [file, table] : files.tables) table.write(folder / file);
    for (const Plot& plot : files.plots) report::draw_plot(folder / plot.file, plot.script, plot.values, plot.size);
    for (const Picture& picture : files.pictures)
        io::write_colour_png(folder / picture.file, picture.width, picture.height, picture.pixels);
    for (const auto& [file, paths] : files.paths) io::write_vtp(folder / file, paths);
}

}  // namespace porepack::analysis
