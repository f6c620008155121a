// Table [lbm] of case.toml.
#pragma once

#include <array>
#include <string>

#include "core/choice.hpp"
#include "lbm/scheme.hpp"
#include "record/config.hpp"

namespace porepack::lbm {

/// Two relaxation times, or one (BGK, as in the paper).
enum class Collision { trt, bgk };
constexpr std::array<core::Choice<Collision>, 2> choices_of(Collision) {
    return {{{Collision::trt, "trt"}, {Collision::bgk, "bgk"}}};
}
/// Number format of the populations.
enum class Precision { double_precision, single_precision };
constexpr std::array<core::Choice<Precision>, 2> choices_of(Precision) {
    return {{{Precision::double_precision, "double"}, {Precision::single_precision, "single"}}};
}
[[nodiscard]] constexpr double bytes_of(Precision precision) {
    return precision == Precision::single_precision ? 4.0 : 8.0;
}
/// Files of the flow field.
enum class FieldFiles { vti, none };
constexpr std::array<core::Choice<FieldFiles>, 2> choices_of(FieldFiles) {
    return {{{FieldFiles::vti, "vti"}, {FieldFiles::none, "none"}}};
}

/// Meaning, unit, range and default of each key: see describe(). 0 means "chosen automatically" where that is allowed.
struct LbmConfig {
    core::Axis direction = core::Axis::z;
    Walls walls = Walls::interpolated;
    Collision collision = Collision::trt;
    Precision precision = Precision::double_precision;
    std::string device = "cpu";
    double relaxation_time = 0.0;
    double magic_parameter = 0.0;
    double tolerance = 0.0;
    double max_time_s = 0.0;
    double iteration_tolerance = 0.0;
    long max_steps = 200000;
    long grids = 3;
    double grid_ratio = 1.5;
    bool tensor = false;
    long subsections = 4;
    FieldFiles fields = FieldFiles::vti;
    double superficial_velocity_m_per_s = 5e-5;
    double checkpoint_minutes = 10.0;
};

inline void describe(record::ConfigVisitor& v, LbmConfig& c) {
    v.choice("direction", c.direction, "direction of the flow; x and y in periodic boxes only");
    v.choice("walls", c.walls, "interpolated: walls at their exact distance, second order; bounce_back: half-way between nodes (paper)");
    v.choice("collision", c.collision, "trt: two relaxation times; bgk: one, as in the paper (k then depends on relaxation_time)");
    v.choice("precision", c.precision, "precision of the populations; single halves memory and time");
    v.text("device", c.device,
           "what computes the flow: cpu, gpu (the first graphics card), or cuda:0, opencl:0, opencl:1 and so on as `porepack devices` "
           "lists them; "
           "results of different devices differ by rounding");
    v.moved_to("section", "ends");
    v.number("relaxation_time", c.relaxation_time, {.low = 0.5, .high = 100.0, .low_open = true, .zero_is_auto = true},
             "tau of the symmetric moments (lattice viscosity (tau - 1/2)/3); with trt, only the number of steps depends on it, and k does "
             "not; auto with trt: the value that needs the smallest number of steps, found on the coarsest grid; auto with bgk: 0.59, as "
             "in the paper");
    v.renamed("magic_number", "magic_parameter");
    v.number("magic_parameter", c.magic_parameter, {.low = 1e-6, .high = 10.0, .zero_is_auto = true},
             "Lambda = (tau+ - 1/2)(tau- - 1/2) of the two relaxation times; auto: 1/12 with interpolated walls, 3/16 with bounce_back");
    v.number("tolerance", c.tolerance, {.low = 1e-4, .high = 0.5, .zero_is_auto = true},
             "requested relative half width of the interval of k: grids are refined from coarse to fine until it is reached; auto: "
             "the voxel size is given, and the interval follows from it");
    v.number("max_time_s", c.max_time_s, {.low = 1e-3, .high = 1e9, .zero_is_auto = true},
             "seconds after which a run with a tolerance does not start a finer grid; the first three grids, chosen so coarse that they "
             "should take half "
             "of it, are always finished; auto: no limit");
    v.number("iteration_tolerance", c.iteration_tolerance, {.low = 1e-12, .high = 0.1, .zero_is_auto = true},
             "relative iteration error of k at which the run on a grid stops; auto: a tenth of the tolerance, or 1e-4");
    v.integer("max_steps", c.max_steps, {.low = 1, .high = 1e9}, "a run that is not steady after this number of time steps is an error");
    v.integer("grids", c.grids, record::between(1, 6),
              "number of grids, from coarse to fine; with three or more, an interval is given, and coarser grids (of 5 voxels per "
              "grain diameter or more) are added until the coarsest has at most 6; with fewer than three, no interval is given");
    v.number("grid_ratio", c.grid_ratio, {.low = 1.1, .high = 4.0}, "voxel size of a grid / that of the next finer one");
    v.boolean("tensor", c.tensor, "three runs give the whole permeability tensor; only for a box that is periodic in x, y and z");
    v.integer("subsections", c.subsections, record::between(1, 1000), "number of parts along z whose permeabilities are reported as well");
    v.choice("fields", c.fields, "vti: flow.vti is written; none: it is not written");
    v.number("superficial_velocity_m_per_s", c.superficial_velocity_m_per_s, record::between(1e-12, 1e3),
             "superficial velocity to which flow.vti is scaled; the liquid is water with 1e-6 m2/s and 1000 kg/m3");
    v.number("checkpoint_minutes", c.checkpoint_minutes, {.low = 1e-4, .high = 1e6},
             "minutes between checkpoints; an interrupted run resumes from the last one");
}

}  // namespace porepack::lbm
