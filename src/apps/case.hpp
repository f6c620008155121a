// A case: a folder with case.toml; its results go to results/.
#pragma once

#include "converters/config.hpp"
#include "lbm/config.hpp"
#include "openfoam/config.hpp"
#include "packing/config.hpp"
#include "packing/container_config.hpp"
#include "permeability/config.hpp"
#include "report/config.hpp"
#include "shapes/config.hpp"
#include "tortuosity/config.hpp"

namespace porepack {

/// All tables; the defaults stand for a table that is left out.
struct Settings {
    ShapeConfig shape;
    ContainerConfig container;
    PackingConfig packing;
    GeometryConfig geometry;
    StlConfig stl;
    LbmConfig lbm;
    FoamConfig openfoam;
    TortuosityConfig tortuosity;
    ForchheimerConfig forchheimer;
    FallingHeadConfig falling_head;
    ReportConfig report;

    /// The list of keys of one table.
    [[nodiscard]] Describe describe_table(const std::string& table);
    [[nodiscard]] static const std::vector<std::string>& tables();
};

struct Case {
    Path folder;
    Settings settings;
    Path output = {};  ///< where results go instead of the case's own folder `results`
    [[nodiscard]] Path results() const { return output.empty() ? folder / "results" : output; }
    /// A file named in case.toml, relative to the case.
    [[nodiscard]] Path resolve(const std::string& file) const { return Path(file).is_absolute() ? Path(file) : folder / file; }
};

/// `path` is the case's folder or its case.toml. `flags` of table `flag_table` win over the file.
[[nodiscard]] Case read_case(const Path& path, const std::string& flag_table = {}, const Flags& flags = {});

}  // namespace porepack
