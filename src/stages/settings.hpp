// The tables of case.toml.
#pragma once

#include <string>
#include <vector>

#include "converters/config.hpp"
#include "core/json_fwd.hpp"
#include "core/members.hpp"
#include "falling_head/config.hpp"
#include "imaging/config.hpp"
#include "lbm/config.hpp"
#include "openfoam/config.hpp"
#include "permeability/config.hpp"
#include "pipeline/config.hpp"
#include "pore_space/config.hpp"
#include "pouring/config.hpp"
#include "pouring/protocol.hpp"
#include "record/config.hpp"
#include "report/config.hpp"
#include "shapes/config.hpp"
#include "tortuosity/config.hpp"
#include "vessels/config.hpp"

namespace porepack::stages {

/// All tables; a table that is absent has the defaults.
struct Settings {
    shapes::ShapeConfig shape;
    imaging::ImageConfig image;
    vessels::ContainerConfig container;
    pouring::PackingConfig packing;
    pouring::ProtocolConfig protocol;
    pouring::PackingsConfig packings;
    converters::GeometryConfig geometry;
    pore_space::SectionConfig section;
    converters::StlConfig stl;
    lbm::LbmConfig lbm;
    openfoam::FoamConfig openfoam;
    tortuosity::TortuosityConfig tortuosity;
    permeability::ForchheimerConfig forchheimer;
    falling_head::FallingHeadConfig falling_head;
    pipeline::ParallelConfig parallel;
    report::ReportConfig report;

    /// The list of keys of one table.
    [[nodiscard]] record::Describe describe_table(const std::string& table);
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
    visit("protocol", settings.protocol);
    visit("packings", settings.packings);
    visit("geometry", settings.geometry);
    visit("section", settings.section);
    visit("stl", settings.stl);
    visit("lbm", settings.lbm);
    visit("openfoam", settings.openfoam);
    visit("tortuosity", settings.tortuosity);
    visit("forchheimer", settings.forchheimer);
    visit("falling_head", settings.falling_head);
    visit("parallel", settings.parallel);
    visit("report", settings.report);
}

}  // namespace porepack::stages
