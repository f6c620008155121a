// A case: a folder with case.toml; its results go to results/.
#pragma once

#include <map>

#include "converters/config.hpp"
#include "core/config.hpp"
#include "core/files.hpp"
#include "core/members.hpp"
#include "falling_head/config.hpp"
#include "imaging/config.hpp"
#include "lbm/config.hpp"
#include "openfoam/config.hpp"
#include "packing/container_config.hpp"
#include "permeability/config.hpp"
#include "pore_space/config.hpp"
#include "pouring/config.hpp"
#include "report/config.hpp"
#include "results/results.hpp"
#include "shapes/config.hpp"
#include "tortuosity/config.hpp"

namespace porepack::stages {

/// All tables; a table that is absent has the defaults.
struct Settings {
    shapes::ShapeConfig shape;
    imaging::ImageConfig image;
    packing::ContainerConfig container;
    pouring::PackingConfig packing;
    pouring::PackingsConfig packings;
    converters::GeometryConfig geometry;
    pore_space::SectionConfig section;
    converters::StlConfig stl;
    lbm::LbmConfig lbm;
    openfoam::FoamConfig openfoam;
    tortuosity::TortuosityConfig tortuosity;
    permeability::ForchheimerConfig forchheimer;
    falling_head::FallingHeadConfig falling_head;
    report::ReportConfig report;

    /// The list of keys of one table.
    [[nodiscard]] core::Describe describe_table(const std::string& table);
    [[nodiscard]] static const std::vector<std::string>& tables();
    /// The resolved values, table by table: all of them, or those named.
    [[nodiscard]] core::Json resolved_tables(const std::vector<std::string>& names = tables()) const;
};
template <core::MembersOf<Settings> Self, typename Visit>
void visit_members(Self& settings, const Visit& visit) {
    visit("shape", settings.shape);
    visit("image", settings.image);
    visit("container", settings.container);
    visit("packing", settings.packing);
    visit("packings", settings.packings);
    visit("geometry", settings.geometry);
    visit("section", settings.section);
    visit("stl", settings.stl);
    visit("lbm", settings.lbm);
    visit("openfoam", settings.openfoam);
    visit("tortuosity", settings.tortuosity);
    visit("forchheimer", settings.forchheimer);
    visit("falling_head", settings.falling_head);
    visit("report", settings.report);
}

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
    [[nodiscard]] bool from_stl() const { return settings.shape.kind == shapes::ShapeKind::stl; }
};

/// `path` is the case's folder or its case.toml. `flags` of the table `flag_table`, and those of [geometry] and [section], win over the
/// file. `set`: by table, keys that win over the file too; all of them must exist. Throws UserError with file and line.
[[nodiscard]] Case read_case(const core::Path& path, const std::string& flag_table = {}, const core::Flags& flags = {},
                             const std::map<std::string, core::Flags>& set = {});
/// The case with other values of keys, by table, an empty value to leave a key out: as if its file had been written so.
[[nodiscard]] Case read_changed_case(const core::Path& path, const std::map<std::string, core::Flags>& changes);

}  // namespace porepack::stages
