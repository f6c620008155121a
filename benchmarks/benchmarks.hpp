// Measurements: they report values without pass or fail.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/json.hpp"
#include "openfoam/foam.hpp"
#include "support/whole_library.hpp"

namespace porepack::benchmarks {

/// Coverage of the intervals of LbmConfig::tolerance; one row per tolerance and flow.
[[nodiscard]] core::Json coverage_benchmark(const std::vector<unsigned>& seeds, const std::vector<double>& tolerances);
/// Of each kind of interval, `count` cases of known answer that `seed` draws: how many intervals hold it, and which do not.
[[nodiscard]] core::Json coverage_seed_benchmark(unsigned seed, int count);
/// coverage_benchmark() on random packings: rows in `file`, to which the missing ones are added if asked for (about two hours for all), and
/// a fit of the interval's constants to those of the fit. Pours work in `folder` (or ./coverage_beds).
[[nodiscard]] core::Json coverage_random_benchmark(const core::Path& file, bool compute_missing, const core::Path& folder);
/// Checks of the references of these rows by other walls, another grid position, OpenFOAM, and on wider beds; kept in `file` as they come.
[[nodiscard]] core::Json coverage_checks_benchmark(const core::Path& rows, const core::Path& file, const core::Path& folder);
/// Gray walls on simulated scans of arrays of known answer: error, interval, coverage; half-way walls beside them.
[[nodiscard]] core::Json gray_benchmark(bool quick);
/// Poses fitted to simulated X-ray scans of settled beds, written into `folder` (or ./fit_scans).
[[nodiscard]] core::Json fit_benchmark(bool quick, const core::Path& folder);
/// Segmentation of simulated scans of two settled beds, written into `folder` (or ./segment_scans).
[[nodiscard]] core::Json segment_benchmark(bool quick, const core::Path& folder);
/// Speed of the kernels against their limits, steps of the schemes to the same tolerance, error against seconds. Quick: speed alone.
[[nodiscard]] core::Json lbm_benchmark(bool quick, const core::Path& folder);
/// Memory of runs on two grids, flow.vti included, as predicted and as used; time of their set-up. With a number of fluid nodes, one run
/// of this size at porosity 0.7 in single precision, without flow.vti.
[[nodiscard]] core::Json memory_benchmark(bool quick, const std::vector<std::string>& nodes, const core::Path& folder);
/// Steps of lattice Boltzmann with and without corrections from a coarser grid, on the settled beds or on `packings`.
[[nodiscard]] core::Json multigrid_benchmark(const std::vector<std::string>& packings, bool quick);
/// Runs both flow solvers of the cases if not yet done, and compares k, cost and mean profiles of the speed.
[[nodiscard]] core::Json cross_check_benchmark(const std::vector<core::Path>& cases, const core::Path& folder);
/// OpenFOAM on flows of known answer; its cases are in `folder` (or ./foam_verification).
[[nodiscard]] core::Json foam_benchmark(const core::Path& folder);
/// A packing as input for OpenFOAM; `deviation` is that of its surface over the grain size.
[[nodiscard]] openfoam::FoamScene foam_scene_of(const packing::Packing& packing, const packing::Section& section, double grain_size_m,
                                                double deviation = 0.003);
/// Pours: the paper's grains by both engines (porosity of several packings, seconds against the clumps' surface tolerance; writes
/// packing_engines.svg into `folder`), grains with faces, spheres as polyhedra. `parts`: engines, grains_with_faces, spheres_of_320_faces;
/// none: all.
[[nodiscard]] core::Json packing_benchmark(const std::vector<std::string>& parts, bool quick, const core::Path& folder);
/// Flows that are not steady: stability of the collisions, and the friction of arrays of spheres; writes stability.csv and friction.csv
/// into `folder` (or ./inertia_study).
[[nodiscard]] core::Json inertia_benchmark(bool quick, const core::Path& folder);
/// The estimated iteration error of k against the true one, on random flows that are slow to become steady, without and with
/// inertia; writes into `folder` (or ./iteration_study).
[[nodiscard]] core::Json iteration_benchmark(bool quick, const core::Path& folder);
/// k of a section in its bed: pressure on a plane, length of the buffers, k against the length of the section; writes section_length.svg
/// into `folder` (or ./section_study).
[[nodiscard]] core::Json section_benchmark(const std::vector<std::string>& parts, bool quick, const core::Path& folder);
/// The paper's tortuosity against all its parameters, error against seconds of the others; writes tortuosity_study.svg into `folder`.
[[nodiscard]] core::Json tortuosity_benchmark(bool quick, const core::Path& folder);
/// Error against cost of both solvers and the paper's scheme; writes speed_error.svg and .csv into `folder` (or ./speed_error).
[[nodiscard]] core::Json speed_error_benchmark(bool quick, const core::Path& folder);
/// Two slabs with one thread each against one part with two threads, and with messages that take a millisecond: rates, bytes, waiting.
[[nodiscard]] core::Json slabs_benchmark(bool quick);
/// Error and time of the measures of shapes against tolerance, of the inverse, and of CGAL's surfaces against their number of triangles.
[[nodiscard]] core::Json shapes_benchmark();

/// Scatter of k between in-situ slices of the settled beds against their length; writes section_scatter.svg and .csv into `folder` (or
/// ./section_scatter).
[[nodiscard]] core::Json section_scatter_benchmark(const core::Path& folder);
/// The rule of --until-sure on 10,000 simulated sequences of packings, and on those of `seeds_csv` (permeability_m2 in the third column).
[[nodiscard]] core::Json stopping_benchmark(const std::vector<std::string>& seeds_csv);
/// The intervals of `porepack design` on simulated beds of unequal scatter, and of the beds of studies' tables.
[[nodiscard]] core::Json design_scatter_benchmark(const std::vector<std::string>& study_csv);

}  // namespace porepack::benchmarks
