// The results of the stages as structs. Each stage writes one as result.json, and whoever reads it gets the struct back: one header per
// stage, whose list of members is the list of keys (docs/files.md).
#pragma once

#include <optional>

#include "core/members.hpp"
#include "results/descriptors.hpp"
#include "results/falling_head.hpp"
#include "results/foam.hpp"
#include "results/forchheimer.hpp"
#include "results/geometry.hpp"
#include "results/image.hpp"
#include "results/lbm.hpp"
#include "results/pack.hpp"
#include "results/seeds.hpp"
#include "results/shape.hpp"
#include "results/tortuosity.hpp"
#include "results/uncertainty.hpp"

namespace porepack::results {

/// Those of one case, as far as they exist. Their keys are the names of the stages.
struct CaseResults {
    core::OptionalKey<Shape> shape = {};
    core::OptionalKey<Image> image = {};
    core::OptionalKey<Pack> pack = {};
    core::OptionalKey<Stl> stl = {};
    core::OptionalKey<Voxelise> voxelise = {};
    core::OptionalKey<Slices> slices = {};
    core::OptionalKey<Lbm> lbm = {};
    core::OptionalKey<Foam> foam = {};
    core::OptionalKey<Tortuosity> tortuosity = {};
    core::OptionalKey<Seeds> seeds = {};
    core::OptionalKey<Uncertainty> uncertainty = {};
    core::OptionalKey<Forchheimer> forchheimer = {};
    core::OptionalKey<FallingHead> falling_head = {};
    core::OptionalKey<Causes> causes = {};
    core::OptionalKey<Descriptors> descriptors = {};
};
template <core::MembersOf<CaseResults> Self, typename Visit>
void visit_members(Self& results, const Visit& visit) {
    visit(Shape::stage, results.shape);
    visit(Image::stage, results.image);
    visit(Pack::stage, results.pack);
    visit(Stl::stage, results.stl);
    visit(Voxelise::stage, results.voxelise);
    visit(Slices::stage, results.slices);
    visit(Lbm::stage, results.lbm);
    visit(Foam::stage, results.foam);
    visit(Tortuosity::stage, results.tortuosity);
    visit(Seeds::stage, results.seeds);
    visit(Uncertainty::stage, results.uncertainty);
    visit(Forchheimer::stage, results.forchheimer);
    visit(FallingHead::stage, results.falling_head);
    visit(Causes::stage, results.causes);
    visit(Descriptors::stage, results.descriptors);
}

/// The whole bed, as the stage pack, or stl of a user's surface, describes it.
[[nodiscard]] std::optional<BedPorosity> bed_of(const CaseResults& results);

}  // namespace porepack::results
