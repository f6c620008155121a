#include "core/data_file.hpp"

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "core/error.hpp"

namespace porepack::inline core {
namespace fs = std::filesystem;
namespace {

Path& host_folder() {
    static Path folder;
    return folder;
}

// In the source tree, whose path is empty in a package, the templates are beside the code that uses them.
Path found_in(const Path& root, const Path& name) {
    for (const Path& path : {root / name, root / "src" / "report" / name})
        if (fs::exists(path)) return path;
    return {};
}

}  // namespace

void set_data_folder(const Path& folder) {
    host_folder() = folder;
}

Path data_file(const Path& name) {
    if (const char* home = std::getenv("POREPACK_HOME")) {
        if (const Path path = found_in(home, name); !path.empty()) return path;
        throw UserError(name.string() + " is not in " + home,
                        {.where = "POREPACK_HOME", .fix = "set it to porepack's folder, or unset it"});
    }
    std::error_code none;
    const Path program = fs::read_symlink("/proc/self/exe", none);
    for (const Path& root :
         {host_folder(), program.parent_path() / ".." / "share" / "porepack", Path(POREPACK_INSTALLED_DATA), Path(POREPACK_SOURCE_FOLDER)})
        if (!root.empty())
            if (const Path path = found_in(root, name); !path.empty()) return path;
    throw UserError("porepack's own files are not found: " + name.string(),
                    {.fix = "set POREPACK_HOME to the folder that holds liggghts_templates/, openfoam_cases/ and templates/"});
}

}  // namespace porepack::inline core
