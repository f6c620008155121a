#include "lbm/permeability.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "lbm/checkpoint.hpp"
#include "lbm/start.hpp"

namespace porepack {
namespace {

constexpr double water_viscosity_Pa_s = 1e-3;
constexpr double body_force_lu = 1e-3;  // any: Stokes flow is linear, and populations are deviations from rest
constexpr double first_nodes_a_grain = 6.0, tolerance_ratio = std::numbers::sqrt2;

FlowSection flow_section(const PhaseImage& image, const Container& container, const Section& section, const Drive& drive) {
    const auto axis = static_cast<std::size_t>(drive.axis);
    const Grid& grid = image.grid;
    const double h = grid.spacing_m[axis];
    FlowSection flow{.last_layer = grid.cells[axis] - 1};
    if (drive.axis == 2) {
        flow.area_cells = container.inner_area_m2() / (h * h);
        flow.first_layer = std::max(0, static_cast<int>(std::lround((section.z0 - grid.origin_m[2]) / h)));
        flow.last_layer = std::min(flow.last_layer, static_cast<int>(std::lround((section.z1 - grid.origin_m[2]) / h)) - 1);
    } else {
        flow.area_cells = container.size_m[1 - drive.axis] * container.size_m.z() / (h * h);
    }
    return flow;
}

// Scales to water at the superficial velocity asked for: in Stokes flow everything is proportional. The pressure is zero at the
// outlet; of a periodic cell it is what is left of it without the driving gradient.
FlowImage flow_image(const PhaseImage& image, const Domain& domain, const Flow& flow, const LbmGridResult& result, double force,
                     double superficial_velocity) {
    FlowImage picture{.grid = image.grid,
                      .velocity_m_per_s = std::vector<float>(3 * image.grid.size(), 0.0F),
                      .pressure_Pa = std::vector<float>(image.grid.size(), 0.0F),
                      .phase = image.phase,
                      .notes = image.notes};
    const double speed = superficial_velocity / result.run.superficial_velocity_lu;
    const double gradient = water_viscosity_Pa_s * superficial_velocity / result.permeability_m2;
    const double pressure = gradient * result.voxel_size_m / result.run.gradient_lu;
    const double slope = domain.drive.by_pressure() ? force : 0.0;
    const auto axis = static_cast<std::size_t>(domain.drive.axis);
#pragma omp parallel for schedule(static)
    for (std::size_t first = 0; first < domain.nodes(); first += Flow::chunk) {
        std::array<Moments, Flow::chunk> moments;
        const std::size_t count = std::min(Flow::chunk, domain.nodes() - first);
        flow.moments(first, std::span(moments).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            const auto cell = static_cast<std::size_t>(domain.cell[first + i]);
            for (std::size_t a = 0; a < 3; ++a) picture.velocity_m_per_s[3 * cell + a] = static_cast<float>(speed * moments[i].velocity[a]);
            const double to_outlet = domain.grid.cells[axis] - place_in_grid(domain.grid, cell)[axis] - 0.5;
            picture.pressure_Pa[cell] = static_cast<float>(pressure * (moments[i].density / 3.0 + slope * to_outlet));
        }
    }
    picture.notes["state"] =
        fmt::format("water (1e-3 Pa s) at a superficial velocity of {:g} m/s along {}", superficial_velocity, "xyz"[domain.drive.axis]);
    picture.notes["direction"] = std::string(1, "xyz"[domain.drive.axis]);
    return picture;
}

std::vector<SubsectionResult> subsections(const LbmGridResult& grid, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                                          const Section& planes, long parts) {
    std::vector<SubsectionResult> results;
    const double force = scheme.force[static_cast<std::size_t>(domain.drive.axis)], h = grid.voxel_size_m;
    const long layers = section.last_layer - section.first_layer + 1;
    if (domain.drive.axis != 2) return results;
    for (long part = 0; part < std::min(parts, layers); ++part) {
        const auto first = static_cast<std::size_t>(section.first_layer + layers * part / parts),
                   end = static_cast<std::size_t>(section.first_layer + layers * (part + 1) / parts);
        if (first == end) continue;
        double flow = 0.0;
        for (std::size_t layer = first; layer < end; ++layer) flow += grid.run.layers.flow[layer];
        flow /= static_cast<double>(end - first);
        const double gradient = gradient_between(force, domain, grid.run.layers, first, end - 1);
        const double z0 = planes.z0 - section.first_layer * h;
        results.push_back({z0 + static_cast<double>(first) * h, z0 + static_cast<double>(end) * h,
                           flow * scheme.viscosity_lu() / (section.area_cells * gradient) * h * h});
    }
    return results;
}

std::string digest_of(const LbmScene& scene, const LbmConfig& config, const Domain& domain) {
    LbmConfig same = config;
    same.max_time_s = same.checkpoint_minutes = 0.0;
    std::string text =
        to_json([&](ConfigVisitor& v) { describe(v, same); }).dump() + fmt::format("{} {}", scene.section.z0, scene.section.z1);
    const auto add = [&](const auto& list) { text += sha256({reinterpret_cast<const char*>(list.data()), list.size() * sizeof(list[0])}); };
    add(domain.cell);
    std::vector<std::uint16_t> distances;
    for (const WallLink& link : domain.walls) distances.push_back(link.distance);
    add(distances);
    return sha256(text);
}

// Solves grid after grid.
class Sequence {
public:
    Sequence(const LbmScene& scene, const LbmConfig& config, bool with_flow) : scene_(scene), config_(config), with_flow_(with_flow) {
        if (!scene.checkpoint.empty() && std::filesystem::exists(scene.checkpoint)) {
            saved_ = read_checkpoint_header(scene.checkpoint);
            for (const Json& grid : saved_->at("grids")) result_.grids.push_back(grid_from_json(grid));
            log_info("lattice Boltzmann: goes on from {} at step {} of grid {}", scene.checkpoint.string(), saved_->at("steps").get<long>(),
                     result_.grids.size() + 1);
        }
    }

    [[nodiscard]] LbmResult& result() { return result_; }
    [[nodiscard]] std::size_t done() const { return result_.grids.size(); }
    [[nodiscard]] double voxel_size_done() const { return result_.grids.back().voxel_size_m; }

    /// False when the time ran out before the gate was passed; the grid is then left out.
    bool solve(double voxel_size_m, bool coarsest_of_many, double max_seconds) {
        const PhaseImage image = scene_.voxels(voxel_size_m);
        const Drive drive = choose_drive(scene_.container, config_.direction);
        if (config_.ends == "paper") require_paper_ends(drive, image.grid);
        Scheme scheme = scheme_of(config_, scene_.solid != nullptr, drive);
        const Stopwatch set_up;
        std::optional<FlowWalls> walls;
        if (scheme.walls == Walls::interpolated) walls.emplace(FlowWalls{*scene_.solid, scene_.container, scene_.section});
        const double radius = config_.ends == "paper" ? 0.5 * scene_.container.diameter_m / image.grid.spacing_m[2] : 0.0;
        const Domain domain = build_domain(image, drive, walls ? &*walls : nullptr, radius);
        const FlowSection section = flow_section(image, scene_.container, scene_.section, drive);
        const bool tuned = config_.relaxation_time == 0.0 && config_.collision == "trt";
        LbmGridResult grid{.voxel_size_m = image.grid.spacing_m[2],
                           .cells = image.grid.cells,
                           .nodes = domain.nodes(),
                           .isolated_cells = domain.isolated_cells,
                           .wall_links = domain.walls.size(),
                           .narrow_share = domain.narrow_share(),
                           .by_pressure = drive.by_pressure()};
        log_info("lattice Boltzmann: {} x {} x {} voxels of {:.4g} m, {} fluid nodes ({} isolated)", image.grid.cells[0],
                 image.grid.cells[1], image.grid.cells[2], grid.voxel_size_m, grid.nodes, grid.isolated_cells);
        // Modes of viscosity decay with nu / h^2, those of pressure with 1 / (nu L^2): the best nu grows with 1/h.
        if (tuned && !result_.grids.empty())
            scheme.tau = 0.5 + (result_.grids.back().relaxation_time - 0.5) * result_.grids.back().voxel_size_m / grid.voxel_size_m;
        if (saved_) scheme.tau = saved_->at("relaxation_time").get<double>();
        if (config_.relaxation_time == 0.0 && config_.collision == "trt") scheme = with_tau(scheme, std::clamp(scheme.tau, 0.55, 10.0));
        Solved solved = make(domain, scheme);
        grid.set_up_seconds = set_up.seconds();
        const StokesGate gate{.tolerance = iteration_tolerance(), .max_steps = config_.max_steps, .max_seconds = max_seconds};
        if (saved_)
            go_on(solved, domain, section, gate);
        else if (tuned && coarsest_of_many && result_.grids.empty())
            solved = fastest(domain, scheme, section, gate);
        else {
            if (coarse_) start_from(*solved.flow, domain, scheme, *coarse_);
            solved.run = run(solved, domain, section, gate, {});
        }
        saved_.reset();
        if (!solved.run.converged && solved.run.seconds >= max_seconds) return false;
        if (!solved.run.converged)
            throw NumericalError(
                fmt::format("the flow is not steady after {} steps: iteration error {:.1e}, gate {:.1e}; no permeability is given",
                            solved.run.steps, solved.run.iteration_error, gate.tolerance),
                {.mend = "raise max_steps, or loosen the tolerance"});
        grid.run = std::move(solved.run);
        grid.relaxation_time = solved.scheme.tau;
        grid.bytes_per_node = solved.flow->bytes() / static_cast<double>(domain.nodes());
        const double h2 = grid.voxel_size_m * grid.voxel_size_m;
        grid.permeability_m2 = grid.run.permeability_lu * h2;
        grid.permeability_volume_m2 = grid.run.permeability_volume_lu * h2;
        result_.subsections = subsections(grid, domain, solved.scheme, section, scene_.section, config_.subsections);
        const double force = solved.scheme.force[static_cast<std::size_t>(drive.axis)];
        coarse_ = coarse_flow(*solved.flow, domain, solved.scheme);
        if (with_flow_) result_.flow = flow_image(image, domain, *solved.flow, grid, force, config_.superficial_velocity_m_per_s);
        result_.grids.push_back(std::move(grid));
        return true;
    }

private:
    struct Solved {
        Scheme scheme;
        std::unique_ptr<Flow> flow;
        StokesRun run = {};
    };

    static Scheme with_tau(Scheme scheme, double tau) {
        scheme.tau = tau;
        return scheme;
    }
    [[nodiscard]] double iteration_tolerance() const {
        return config_.iteration_tolerance > 0.0 ? config_.iteration_tolerance : config_.tolerance > 0.0 ? 0.1 * config_.tolerance : 1e-4;
    }
    [[nodiscard]] Solved make(const Domain& domain, const Scheme& scheme) const {
        return {.scheme = scheme,
                .flow = make_flow(config_.precision == "single" ? Kernel::fast_single : Kernel::fast_double, domain, scheme)};
    }

    void require_paper_ends(const Drive& drive, const Grid& grid) const {
        const bool reservoir = grid.origin_m[2] < scene_.section.z0 - 0.5 * grid.spacing_m[2];
        if (drive.axis != 2 || !drive.by_pressure() || scene_.container.kind != Container::Kind::cylinder || !reservoir)
            throw UserError("the paper's ends need a cylinder with a reservoir before the section",
                            {.mend = "set reservoir_m in [geometry], or ends = \"pressure\""});
    }

    // Keeps a checkpoint every so many minutes, and when the run is interrupted.
    StokesRun run(Solved& solved, const Domain& domain, const FlowSection& section, StokesGate gate, StokesRun before) {
        Stopwatch since;
        const std::string digest = scene_.checkpoint.empty() ? "" : digest_of(scene_, config_, domain);
        if (!scene_.checkpoint.empty())
            gate.checkpoint = [&](const StokesRun& now) {
                if (!interrupted() && since.seconds() < 60.0 * config_.checkpoint_minutes) return;
                since = {};
                Json header = {{"run", digest}, {"relaxation_time", solved.scheme.tau}, {"steps", now.steps}, {"seconds", now.seconds}};
                header["grids"] = Json::array();
                for (const LbmGridResult& grid : result_.grids) header["grids"].push_back(to_json(grid));
                header["history"] = Json::array();
                for (const auto& p : now.history)
                    header["history"].push_back({p.step, p.permeability_lu, p.permeability_volume_lu, p.iteration_error, p.flow_imbalance});
                write_checkpoint(scene_.checkpoint, header, solved.flow->state());
                log_info("lattice Boltzmann: checkpoint at step {} in {}", now.steps, scene_.checkpoint.string());
            };
        return run_to_steady(*solved.flow, domain, solved.scheme, section, gate, std::move(before));
    }

    void go_on(Solved& solved, const Domain& domain, const FlowSection& section, const StokesGate& gate) {
        if (saved_->at("run") != digest_of(scene_, config_, domain))
            throw UserError("the checkpoint is of another run: other settings or another geometry",
                            {.where = scene_.checkpoint.string(), .mend = "remove the file to begin anew"});
        read_checkpoint_state(scene_.checkpoint, solved.flow->state(), config_.precision == "single" ? 4 : 8);
        StokesRun before{.steps = saved_->at("steps").get<long>(), .seconds = saved_->at("seconds").get<double>()};
        for (const Json& p : saved_->at("history"))
            before.history.push_back(
                {p.at(0).get<long>(), p.at(1).get<double>(), p.at(2).get<double>(), p.at(3).get<double>(), p.at(4).get<double>()});
        solved.run = run(solved, domain, section, gate, std::move(before));
    }

    // Tries viscosities by factors of two for the least number of steps.
    Solved fastest(const Domain& domain, const Scheme& scheme, const FlowSection& section, StokesGate gate) {
        const auto attempt = [&](double viscosity) {
            Solved solved = make(domain, with_tau(scheme, 0.5 + 3.0 * viscosity));
            solved.run = run_to_steady(*solved.flow, domain, solved.scheme, section, gate);
            return solved;
        };
        Solved best = attempt(scheme.viscosity_lu());
        for (const double factor : {2.0, 0.5}) {
            const double begin = best.scheme.viscosity_lu();
            while (true) {
                const double viscosity = factor * best.scheme.viscosity_lu();
                if (viscosity > 3.2 || viscosity < 0.02) break;
                gate.max_steps = std::min(gate.max_steps, best.run.converged ? best.run.steps : gate.max_steps);
                Solved other = attempt(viscosity);
                if (!other.run.converged || (best.run.converged && other.run.steps >= best.run.steps)) break;
                best = std::move(other);
            }
            if (best.scheme.viscosity_lu() != begin) break;
        }
        return best;
    }

    const LbmScene& scene_;
    const LbmConfig& config_;
    bool with_flow_;
    std::optional<Json> saved_;
    std::optional<CoarseFlow> coarse_;
    LbmResult result_;
};

// Nodes a grain's diameter; where that is not known, what packings of tetrapods have at the same k / h^2.
double nodes_a_grain(const LbmScene& scene, const LbmGridResult& grid) {
    return std::isfinite(scene.grain_size_m) ? scene.grain_size_m / grid.voxel_size_m
                                             : 6.6 * std::sqrt(grid.permeability_m2) / grid.voxel_size_m;
}

void find_interval(const LbmScene& scene, const LbmConfig& config, LbmResult& result) {
    const auto& grids = result.grids;
    const LbmGridResult& fine = grids.back();
    const double k = fine.permeability_m2;
    result.permeability_m2 = k;
    result.half_width.reset();
    IntervalParts parts{.iteration_m2 = 2.0 * fine.run.iteration_error * k,
                        .ends_m2 = fine.by_pressure ? 0.5 * std::abs(k - fine.permeability_volume_m2) : 0.0,
                        .precision_m2 = (config.precision == "single" ? 1e-4 : 1e-9) * k};
    if (scheme_of(config, scene.solid != nullptr, {}).walls == Walls::bounce_back) {
        if (grids.size() < 2) return;
        // Of first order at best and not regular: on spheres with a known answer the error scatters by some 4 % without a sign that
        // few grids could show.
        const LbmGridResult& coarse = grids[grids.size() - 2];
        parts.grid_m2 = std::max(0.04 * k, std::abs(k - coarse.permeability_m2) / (coarse.voxel_size_m / fine.voxel_size_m - 1.0));
    } else {
        if (grids.size() < 3) return;
        std::array<double, 3> nodes{}, values{};
        for (std::size_t i = 0; i < 3; ++i) {
            const LbmGridResult& grid = grids[grids.size() - 3 + i];
            nodes[i] = nodes_a_grain(scene, fine) * fine.voxel_size_m / grid.voxel_size_m;
            values[i] = grid.permeability_m2;
        }
        const Extrapolation found = extrapolate(nodes, values);
        result.permeability_m2 = found.value;
        parts.grid_m2 = found.half_width;
    }
    result.half_width = parts;
}

void refine_to_tolerance(Sequence& sequence, const LbmScene& scene, double voxel_size_m, const LbmConfig& config) {
    const Stopwatch watch;
    LbmResult& result = sequence.result();
    double size = std::isfinite(scene.grain_size_m) ? scene.grain_size_m / first_nodes_a_grain : 3.0 * voxel_size_m;
    if (sequence.done() > 0) size = sequence.voxel_size_done() / tolerance_ratio;
    while (true) {
        const double time_left = config.max_time_s > 0.0 ? config.max_time_s - watch.seconds() : 1e300;
        if (sequence.done() > 0) {
            const LbmGridResult& last = result.grids.back();
            const double cube = std::pow(last.voxel_size_m / size, 3.0);
            const double bytes = lbm_memory_bytes(cube * last.cells[0] * last.cells[1] * last.cells[2],
                                                  cube * static_cast<double>(last.nodes), config.precision == "single" ? 4.0 : 8.0);
            const double seconds = last.run.seconds * std::pow(last.voxel_size_m / size, 5.0) + last.set_up_seconds * cube;
            if (bytes > available_memory_bytes())
                result.stopped_by = fmt::format("memory: the next grid needs {}", human_bytes(bytes));
            else if (seconds > time_left)
                result.stopped_by = fmt::format("time: the next grid needs about {}, {} are left", human_time(seconds),
                                                human_time(std::max(0.0, time_left)));
        }
        if (result.stopped_by.empty() && !sequence.solve(size, true, time_left)) {
            if (sequence.done() == 0)
                throw NumericalError("not even the coarsest grid became steady in max_time_s; no permeability is given",
                                     {.mend = "raise --max-time (seconds)"});
            result.stopped_by = "time: it ran out on the next grid";
        }
        find_interval(scene, config, result);
        const double relative = result.half_width ? result.half_width->sum() / result.permeability_m2 : 1.0;
        if (result.half_width) log_info("lattice Boltzmann: k = {:.4g} m2 +- {:.2g} %", result.permeability_m2, 100.0 * relative);
        if (relative <= config.tolerance) {
            result.stopped_by.clear();
            return;
        }
        if (!result.stopped_by.empty()) {
            log_warning(fmt::format("the tolerance of {:g} is not reached, {}", config.tolerance, result.stopped_by));
            return;
        }
        size = sequence.voxel_size_done() / tolerance_ratio;
    }
}

}  // namespace

std::optional<Interval> LbmResult::interval_m2() const {
    if (!half_width) return std::nullopt;
    return Interval{std::max(0.0, permeability_m2 - half_width->sum()), permeability_m2 + half_width->sum()};
}

Scheme scheme_of(const LbmConfig& config, bool exact_walls, const Drive& drive) {
    const bool bgk = config.collision == "bgk";
    Scheme scheme{.tau = config.relaxation_time > 0.0 ? config.relaxation_time
                         : bgk                        ? 0.59
                                                      : 1.2,
                  .walls = exact_walls && config.walls == "interpolated" ? Walls::interpolated : Walls::bounce_back};
    scheme.magic = bgk                                   ? (scheme.tau - 0.5) * (scheme.tau - 0.5)
                   : config.magic_number > 0.0           ? config.magic_number
                   : scheme.walls == Walls::interpolated ? 1.0 / 12.0
                                                         : 3.0 / 16.0;
    if (config.ends != "paper") scheme.force[static_cast<std::size_t>(drive.axis)] = body_force_lu;
    return scheme;
}

Extrapolation extrapolate(std::span<const double> nodes, std::span<const double> values) {
    const auto richardson = [&](std::size_t coarse, std::size_t fine, double order) {
        return (values[fine] - values[coarse]) / (std::pow(nodes[fine] / nodes[coarse], order) - 1.0);
    };
    const double value = values[2] + richardson(0, 2, 2.0);
    const double late = std::abs(richardson(1, 2, 1.5)), early = std::abs(richardson(0, 1, 1.5)) * std::pow(nodes[1] / nodes[2], 1.5);
    return {value, 1.25 * std::max(late, early) + 0.2 * std::pow(nodes[2], -1.5) * std::abs(value)};
}

LbmResult lbm_permeability(const LbmScene& scene, double voxel_size_m, const LbmConfig& config, bool with_flow) {
    Sequence sequence(scene, config, with_flow && config.fields != "none");
    if (config.tolerance > 0.0) {
        if (scheme_of(config, scene.solid != nullptr, {}).walls == Walls::bounce_back)
            throw UserError("a tolerance needs interpolated walls: bounce-back scatters by some 4 % on any grid",
                            {.mend = "walls = \"interpolated\" and an exact geometry, or no tolerance"});
        refine_to_tolerance(sequence, scene, voxel_size_m, config);
    } else {
        for (long left = config.grids - static_cast<long>(sequence.done()); left-- > 0;) {
            (void)sequence.solve(voxel_size_m * std::pow(config.grid_ratio, static_cast<double>(left)),
                                 config.grids > 1 && sequence.done() == 0, 1e300);
            const auto& grids = sequence.result().grids;
            if (grids.size() > 1 && grids[grids.size() - 2].voxel_size_m < 1.02 * grids.back().voxel_size_m)
                throw UserError("two grids have the same voxel size: the section is too short for this grid_ratio",
                                {.mend = "take smaller voxels, a longer section, a larger grid_ratio, or grids = 1"});
        }
        find_interval(scene, config, sequence.result());
    }
    if (!scene.checkpoint.empty()) std::filesystem::remove(scene.checkpoint);
    return std::move(sequence.result());
}

TensorResult lbm_tensor(const LbmScene& scene, double voxel_size_m, const LbmConfig& config) {
    const auto& periodic = scene.container.periodic;
    if (scene.container.kind != Container::Kind::box || !(periodic[0] && periodic[1] && periodic[2]))
        throw UserError("the permeability tensor needs a box that is periodic in x, y and z", {.mend = "tensor = false"});
    TensorResult result;
    for (std::size_t j = 0; j < 3; ++j) {
        LbmConfig along = config;
        along.direction = std::string(1, "xyz"[j]);
        LbmScene part = scene;
        if (!part.checkpoint.empty()) part.checkpoint += "_" + along.direction;
        result.runs[j] = lbm_permeability(part, voxel_size_m, along, along.direction == config.direction);
        const LbmGridResult& fine = result.runs[j].fine();
        const auto& sum = fine.run.velocity_sum_lu;
        for (std::size_t i = 0; i < 3; ++i)
            result.permeability_m2[i][j] = i == j ? result.runs[j].permeability_m2 : fine.permeability_volume_m2 * sum[i] / sum[j];
    }
    return result;
}

}  // namespace porepack
