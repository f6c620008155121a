#include "report/paraview.hpp"

#include <filesystem>
#include <string>

#include "core/data_file.hpp"
#include "core/json.hpp"
#include "report/uses.hpp"

namespace porepack::report {

void write_paraview_script(const Path& file, const Path& results) {
    const std::string mark = "@folder@", place = Json(std::filesystem::absolute(results).lexically_normal().string()).dump();
    std::string script = read_text(data_file("templates/view.py"));
    script.replace(script.find(mark), mark.size(), place);
    write_text(file, script);
}

}  // namespace porepack::report
