#include "support/inertial_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <random>
#include <utility>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "lbm/inertia.hpp"
#include "packing/packing.hpp"
#include "pore_space/pore_space.hpp"
#include "support/known_flows.hpp"
#include "vessels/config.hpp"

namespace porepack::test {
using namespace lbm;
using namespace packing;
using namespace pore_space;
using namespace shapes;
namespace {

struct Bed {
    std::string name;
    PoreSpace space;
    double diameter;
};

class Generator {
public:
    explicit Generator(unsigned seed) : random_(seed) {}

    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_()) / 4294967296.0; }
    Vec3 point() {
        Vec3 at;
        for (double& x : at) x = uniform(0.0, 1.0);
        return at;
    }

    Bed next(int kind) {
        if (kind == 0) return cubic_array();
        if (kind == 1) return spheres();
        if (kind == 2) return tetrapods();
        return layers();
    }

private:
    Bed cubic_array() {
        const std::array<std::pair<std::vector<Vec3>, double>, 3> arrays = {
            std::pair{simple_cubic(), 0.52}, {body_centred(), 0.67}, {face_centred(), 0.73}};
        const auto& [centres, closest] = arrays[random_() % 3];
        const double solid_fraction = closest * uniform(0.5, 1.0);
        const KnownFlow array = sphere_array(solid_fraction, 1.0, centres, point());
        return {"cubic array of spheres", array.space(), array.diameter_m};
    }
    Bed spheres() {
        const double d = uniform(0.3, 0.4);
        Packing packing{.container = vessels::make_box({1.0, 1.0, 1.0}, {true, true, true}),
                        .shapes = {make_preset(ShapeKind::sphere, d, 0.0)},
                        .bodies = {}};
        for (int attempt = 0; attempt < 3000; ++attempt) {
            const Vec3 at = point();
            const bool free = std::all_of(packing.bodies.begin(), packing.bodies.end(), [&](const Body& other) {
                const Vec3 apart = at - other.position_m, nearest = apart - apart.array().round().matrix();
                return nearest.norm() > d;
            });
            if (free) packing.bodies.push_back({.shape = 0, .position_m = at});
        }
        return {"random spheres", pore_space_of(packing), d};
    }
    Bed tetrapods() {
        const double d = uniform(0.15, 0.2);
        Packing packing{.container = vessels::make_box({1.0, 1.0, 1.0}, {true, true, true}),
                        .shapes = {make_preset(ShapeKind::tetrapod, d, d)},
                        .bodies = {}};
        for (int i = 0; i < 14; ++i) {
            Eigen::Vector4d q;
            for (const int part : {3, 2, 1, 0}) q[part] = uniform(-0.5, 0.5);
            packing.bodies.push_back({.shape = 0, .position_m = point(), .orientation = Quaternion(q[0], q[1], q[2], q[3]).normalized()});
        }
        return {"overlapping tetrapods", pore_space_of(packing), 2.0 * d};
    }
    Bed layers() {
        const KnownFlow array = three_layers(uniform(0.25, 0.5), 1.0);
        PoreSpace space = pore_space_of(array.packing).with_section({2.0, 3.0}).with_ends(Ends::in_situ, 2.0);
        space.reservoir_m = 1.0;
        return {"layers of spheres between water", std::move(space), array.diameter_m};
    }

    std::mt19937 random_;
};

}  // namespace

std::vector<InertialRun> random_inertial_runs(unsigned seed, int series, double finest_nodes_per_diameter, double tolerance) {
    std::vector<std::vector<InertialRun>> of_series(static_cast<std::size_t>(series));
    parallel_for(of_series.size(), [&](std::size_t i) {
        Generator random(seed + 1000U * static_cast<unsigned>(i));
        const Bed bed = random.next(static_cast<int>(i % 4));
        const double nodes = random.uniform(8.0, finest_nodes_per_diameter);
        std::array<double, 3> reynolds{std::exp(random.uniform(std::log(0.5), std::log(5.0)))};
        for (std::size_t j = 1; j < 3; ++j) reynolds[j] = reynolds[j - 1] * random.uniform(2.0, 4.0);
        try {
            const InertialSeries found =
                lbm_inertial_flows(bed.space, bed.diameter / nodes, reynolds, bed.diameter, {.tolerance = tolerance, .max_steps = 60000});
            for (const InertialFlow& flow : found.flows)
                of_series[i].push_back({.name = bed.name,
                                        .reynolds = flow.reynolds,
                                        .run = {.nodes = found.nodes,
                                                .steps = flow.steps,
                                                .constant = true,
                                                .steady_permeability_lu = flow.history.back().permeability_lu,
                                                .history = flow.history}});
        } catch (const NumericalError&) {
            return;  // closed, or never steady
        }
    });
    std::vector<InertialRun> all;
    for (auto& runs : of_series) std::move(runs.begin(), runs.end(), std::back_inserter(all));
    return all;
}

}  // namespace porepack::test
