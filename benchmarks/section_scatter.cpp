// Scatter of k between slices of one bed against their length: the exponent beside -1/2 of independent slices.
#include "uncertainty/section_scatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/digamma.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"
#include "core/table.hpp"
#include "lbm/permeability.hpp"
#include "pore_space/pore_space.hpp"
#include "report/plot.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::benchmarks {
namespace {

// Relative resistance of the layers of the bed without its ends, in one flow, without a linear trend.
struct Resistances {
    std::vector<double> layers;
    double layer_m = 0.0;
    double diameter_m = 0.0;  ///< of a grain
    double trend_per_m = 0.0;
};

// Removes the linear trend, keeps the mean; the slope per layer.
double remove_trend(std::vector<double>& layers) {
    const auto middle = 0.5 * (static_cast<double>(layers.size()) - 1.0);
    double slope = 0.0, places = 0.0;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const double place = static_cast<double>(i) - middle;
        slope += place * layers[i];
        places += place * place;
    }
    slope /= places;
    for (std::size_t i = 0; i < layers.size(); ++i) layers[i] -= slope * (static_cast<double>(i) - middle);
    return slope;
}

Resistances resistances_of(const char* file, double voxel_m) {
    const PoreSpace whole = pore_space_of(read_packing(data_file("cases") / "paper_packing" / "settled" / file));
    constexpr double end_m = 0.04;
    const auto on_layer = [&](double z) { return voxel_m * std::round(z / voxel_m); };
    const PoreSpace space =
        whole.with_section({on_layer(whole.bed_bottom_m + end_m), on_layer(whole.bed_top_m - end_m)}).with_ends(Ends::in_situ, end_m);
    const LbmResult result = lbm_permeability(space, voxel_m, {.iteration_tolerance = 2e-4, .grids = 1});
    Resistances found{.layers = {}, .layer_m = voxel_m, .diameter_m = space.equivalent_diameter_m};
    for (const LayerGradient& layer : result.gradients) found.layers.push_back(layer.relative_gradient);
    found.trend_per_m = remove_trend(found.layers) / voxel_m;
    return found;
}

// Standard deviation of the means of adjoining slices of so many layers, relative to the mean of all.
Sample slices_of(const std::vector<double>& layers, std::size_t slice) {
    std::vector<double> means;
    for (std::size_t first = 0; first + slice <= layers.size(); first += slice) {
        double sum = 0.0;
        for (std::size_t i = first; i < first + slice; ++i) sum += layers[i];
        means.push_back(sum / static_cast<double>(slice));
    }
    return sample_of(means);
}

std::vector<std::size_t> slice_lengths(const Resistances& bed) {
    std::vector<std::size_t> lengths;
    for (const double diameters : {0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0}) {
        const auto layers = static_cast<std::size_t>(std::lround(diameters * bed.diameter_m / bed.layer_m));
        if (bed.layers.size() / layers >= 5) lengths.push_back(layers);
    }
    return lengths;
}

// Mean of ln(s / sigma) of normal values.
double bias_of_log(double degrees_of_freedom) {
    return 0.5 * (boost::math::digamma(0.5 * degrees_of_freedom) - std::log(0.5 * degrees_of_freedom));
}

// Slope of log(deviation) against log(length) of slices of one diameter or more; weights: degrees of freedom.
double exponent_of(const std::vector<double>& layers, const Resistances& bed) {
    double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (const std::size_t slice : slice_lengths(bed)) {
        if (static_cast<double>(slice) * bed.layer_m < 0.95 * bed.diameter_m) continue;
        const Sample sample = slices_of(layers, slice);
        const double weight = static_cast<double>(sample.packings) - 1.0, lx = std::log(static_cast<double>(slice)),
                     ly = std::log(sample.relative_deviation()) - bias_of_log(weight);
        w += weight;
        x += weight * lx;
        y += weight * ly;
        xx += weight * lx * lx;
        xy += weight * lx * ly;
    }
    return (xy - x * y / w) / (xx - x * x / w);
}

// The exponent of beds of the same length whose diameters are independent: not exactly -1/2, because the trend takes more from long slices.
double exponent_of_independent_layers(const Resistances& bed) {
    const auto block = static_cast<std::size_t>(std::lround(bed.diameter_m / bed.layer_m));
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal(1.0, 0.1);
    double sum = 0.0;
    constexpr int beds = 1000;
    for (int i = 0; i < beds; ++i) {
        std::vector<double> layers;
        for (double value = 0.0; layers.size() < bed.layers.size(); layers.push_back(value))
            if (layers.size() % block == 0) value = normal(random);
        (void)remove_trend(layers);
        sum += exponent_of(layers, bed) / beds;
    }
    return sum;
}

// Of 95 %, by resampling blocks of three diameters, beyond which layers are independent, with all wrapped around at the ends.
Interval interval_of_exponent(const Resistances& bed) {
    const auto block = static_cast<std::size_t>(3.0 * bed.diameter_m / bed.layer_m);
    std::mt19937_64 random(1);
    std::uniform_int_distribution<std::size_t> start(0, bed.layers.size() - 1);
    std::vector<double> exponents;
    for (int i = 0; i < 1000; ++i) {
        std::vector<double> layers;
        while (layers.size() < bed.layers.size()) {
            const std::size_t first = start(random);
            for (std::size_t j = 0; j < block && layers.size() < bed.layers.size(); ++j)
                layers.push_back(bed.layers[(first + j) % bed.layers.size()]);
        }
        exponents.push_back(exponent_of(layers, bed));
    }
    std::sort(exponents.begin(), exponents.end());
    return {exponents[25], exponents[974]};
}

}  // namespace

Json section_scatter_benchmark(const Path& output) {
    const Path folder = output.empty() ? Path("section_scatter") : output;
    make_folder(folder);
    struct Bed {
        const char *name, *file;
        double voxel_m;
    };
    Table table({"bed", "length_m", "slices", "deviation", "low", "high"});
    Json json = Json::array();
    int number = 0;
    for (const auto& [name, file, voxel] :
         {Bed{"tetrapods 0.53", "tetrapod_053.json.gz", 9e-4}, Bed{"tetrapods 0.87", "tetrapod_087.json.gz", 1e-3}}) {
        const Resistances bed = resistances_of(file, voxel);
        const double length = static_cast<double>(bed.layers.size()) * bed.layer_m;
        Json rows = Json::array();
        for (const std::size_t slice : slice_lengths(bed)) {
            const Sample sample = slices_of(bed.layers, slice);
            const double deviation = sample.relative_deviation(), slice_m = static_cast<double>(slice) * bed.layer_m;
            const Interval interval = interval_of_deviation(deviation, static_cast<double>(sample.packings) - 1.0);
            table.add(number, slice_m, sample.packings, deviation, interval.low, interval.high);
            rows.push_back({{"length_m", slice_m}, {"slices", sample.packings}, {"deviation", deviation}, {"interval", json_of(interval)}});
        }
        const auto whole = section_scatter(bed.layers, length, bed.diameter_m);
        const double exponent = exponent_of(bed.layers, bed);
        log_info("{}: exponent {:.2f}", name, exponent);
        json.push_back({{"bed", name},
                        {"length_m", length},
                        {"grain_diameter_m", bed.diameter_m},
                        {"trend_over_the_bed", bed.trend_per_m * length},
                        {"exponent", exponent},
                        {"exponent_interval", json_of(interval_of_exponent(bed))},
                        {"exponent_of_independent_layers", exponent_of_independent_layers(bed)},
                        {"scatter_of_the_whole_length", whole ? Json(whole->relative) : Json(nullptr)},
                        {"rows", rows}});
        ++number;
    }
    table.write(folder / "section_scatter.csv");
    report::draw_plot(folder / "section_scatter.svg", "section_scatter", {}, {.width = 640, .height = 420});
    return {{"beds", json}};
}

}  // namespace porepack::benchmarks
