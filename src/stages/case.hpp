// A case: a folder with case.toml; its results go to results/.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "record/config.hpp"
#include "results/read.hpp"
#include "stages/settings.hpp"

namespace porepack::stages {

struct Case {
    core::Path folder;
    Settings settings;
    core::Path output = {};  ///< where results go instead of the case's own folder `results`

    [[nodiscard]] core::Path results() const { return output.empty() ? folder / "results" : output; }
    [[nodiscard]] core::Path stage_folder(const std::string& stage) const { return results() / stage; }
    /// result.json of a stage that is done: result<results::Lbm>().
    template <typename Result>
    [[nodiscard]] Result result() const {
        return results::read_result<Result>(results());
    }
    /// A file named in case.toml, relative to the case.
    [[nodiscard]] core::Path resolve(const std::string& file) const {
        return core::Path(file).is_absolute() ? core::Path(file) : folder / file;
    }
    /// The solid is a scan or a segmented image: there are no grains and no shape.
    [[nodiscard]] bool from_image() const { return !settings.image.file.empty() && !settings.image.fit; }
    /// The packing is found in a scan.
    [[nodiscard]] bool from_fit() const { return !settings.image.file.empty() && settings.image.fit; }
    [[nodiscard]] bool from_surface() const { return settings.shape.kind == shapes::ShapeKind::surface; }
};

/// `path` is the case's folder or its case.toml. `flags` of the table `flag_table`, and those of [geometry] and [section], win over the
/// file. `set`: by table, keys that win over the file too; all of them must exist. Throws UserError with file and line.
[[nodiscard]] Case read_case(const core::Path& path, const std::string& flag_table = {}, const record::Flags& flags = {},
                             const std::map<std::string, record::Flags>& set = {});
/// The case with other values of keys, by table, an empty value to leave a key out: as if its file had been written so.
[[nodiscard]] Case read_changed_case(const core::Path& path, const std::map<std::string, record::Flags>& changes);

/// "--set", "table.key=value" for each key whose value is not that of the case's file.
[[nodiscard]] std::vector<std::string> set_arguments(const Case& c);

}  // namespace porepack::stages
