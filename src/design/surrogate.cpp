#include "design/surrogate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/error.hpp"
#include "design/uses.hpp"
#include "study/study_fits.hpp"
#include "study/study_table.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::design {
namespace {

Eigen::VectorXd coordinates(const GrainForm& form, double wall) {
    Eigen::VectorXd x(5);
    x << form.sphericity, form.convexity, form.thickness, form.feret, wall;
    return x;
}

Eigen::MatrixXd coordinates(const std::vector<KnownBed>& beds) {
    Eigen::MatrixXd x(static_cast<Eigen::Index>(beds.size()), 5);
    for (std::size_t i = 0; i < beds.size(); ++i) x.row(static_cast<Eigen::Index>(i)) = coordinates(beds[i].form, beds[i].wall);
    return x;
}

// eps^3 / S^2, in units of d_v^2: S = (1 - eps) 6 / (sphericity d_v).
double log_hydraulic(double porosity, double sphericity) {
    return 3.0 * std::log(porosity) - 2.0 * std::log(6.0 * (1.0 - porosity) / sphericity);
}

Eigen::VectorXd values(const std::vector<KnownBed>& beds, double (*value)(const KnownBed&)) {
    Eigen::VectorXd y(static_cast<Eigen::Index>(beds.size()));
    for (std::size_t i = 0; i < beds.size(); ++i) y[static_cast<Eigen::Index>(i)] = value(beds[i]);
    return y;
}

double porosity_of(const KnownBed& bed) {
    return bed.porosity;
}
double log_kozeny_of(const KnownBed& bed) {
    return log_hydraulic(bed.porosity, bed.form.sphericity) - std::log(bed.permeability);
}

// The table has the sizes of presets of capsules, whose search takes a while. None of surfaces and mixtures.
std::optional<Shape> grain_of(const ShapeConfig& config, double diameter_m, double length_m) {
    if (config.kind == ShapeKind::surface || config.kind == ShapeKind::mesh || config.kind == ShapeKind::library ||
        config.kind == ShapeKind::mixture)
        return std::nullopt;
    if (has_faces(config.kind) || config.kind == ShapeKind::capsules) return make_shape(config);
    return make_preset(config.kind, diameter_m, length_m, config.arms);
}

// NaN where something is missing.
KnownBed bed_of(const StudyRow& row, const Point& point) {
    const stages::Settings& settings = point.planned.settings;
    const double size = number_in(row, "equal_volume_diameter_m"), k = number_in(row, "permeability_m2");
    const auto grain = grain_of(settings.shape, number_in(row, "capsule_diameter_m"), number_in(row, "capsule_length_m"));
    KnownBed bed{.name = point.name,
                 .form = {.sphericity = number_in(row, "sphericity"),
                          .convexity = number_in(row, "convexity"),
                          .thickness = grain ? smallest_diameter(*grain) / size : std::nan(""),
                          .feret = grain ? maximum_feret_diameter(*grain) / size : std::nan("")},
                 .wall = wall_ratio(size, make_container(settings.container)),
                 .packings = std::lround(number_in(row, "packings")),
                 .porosity = number_in(row, "porosity"),
                 .permeability = k / (size * size)};
    if (bed.packings > 1) {
        const double t = uncertainty::students_t(static_cast<double>(bed.packings) - 1.0);
        const double half_width = 0.5 * (number_in(row, "porosity_high") - number_in(row, "porosity_low"));
        bed.porosity_deviation = half_width * std::sqrt(static_cast<double>(bed.packings)) / t;
        bed.permeability_deviation = number_in(row, "permeability_standard_deviation_m2") / k;
    }
    return bed;
}

bool complete(const KnownBed& bed) {
    return (coordinates(bed.form, bed.wall).array().isFinite()).all() && bed.porosity > 0.0 && bed.porosity < 1.0 &&
           bed.permeability > 0.0 && std::isfinite(bed.porosity_deviation + bed.permeability_deviation);
}

std::vector<BedScatter> scatters(const std::vector<KnownBed>& beds, double KnownBed::*deviation) {
    std::vector<BedScatter> list;
    for (const KnownBed& bed : beds) list.push_back({bed.*deviation, bed.packings});
    return list;
}

}  // namespace

double wall_ratio(double equal_volume_diameter_m, const Container& container) {
    return 0.25 * equal_volume_diameter_m * container.vessel().side_per_volume();
}

std::vector<KnownBed> known_beds(const Study& study) {
    std::vector<KnownBed> beds;
    const std::vector<StudyRow> rows = read_rows(study);
    for (const Point& point : study.points)
        for (const StudyRow& row : rows)  // the first of a point is the current one
            if (row.at("point") == point.name) {
                if (const KnownBed bed = bed_of(row, point); complete(bed)) beds.push_back(bed);
                break;
            }
    if (beds.size() < 2)
        throw UserError(
            "there are not two beds to learn from",
            {.where = study.table().string(),
             .allowed = "rows with sphericity, convexity, equal_volume_diameter_m, porosity, permeability_m2; of presets of capsules also "
                        "capsule_diameter_m and capsule_length_m",
             .fix = "porepack study run " + study.folder.string()});
    return beds;
}

ScatterOfBeds permeability_scatter(const std::vector<KnownBed>& beds) {
    return ScatterOfBeds(scatters(beds, &KnownBed::permeability_deviation));
}

ScatterOfBeds porosity_scatter(const std::vector<KnownBed>& beds) {
    return ScatterOfBeds(scatters(beds, &KnownBed::porosity_deviation));
}

Surrogate::Surrogate(const std::vector<KnownBed>& beds)
    : beds_(beds),
      low_(coordinates(beds).colwise().minCoeff()),
      high_(coordinates(beds).colwise().maxCoeff()),
      porosity_(coordinates(beds), values(beds, porosity_of)),
      log_kozeny_(coordinates(beds), values(beds, log_kozeny_of)) {}

// Small changes of the porosity change ln k by 3/eps + 2/(1 - eps) times as much. The errors of porosity and Kozeny constant are taken as
// independent.
Prediction Surrogate::combined(const Estimate& porosity, const Estimate& log_kozeny, double sphericity) const {
    const double eps = std::clamp(porosity.value, 0.05, 0.98);
    const double slope = log_permeability_per_porosity(eps) * porosity.standard_deviation;
    return {.porosity = porosity,
            .log_permeability = {log_hydraulic(eps, sphericity) - log_kozeny.value, std::hypot(slope, log_kozeny.standard_deviation)}};
}

Prediction Surrogate::at(const GrainForm& form, double wall) const {
    const Eigen::VectorXd x = coordinates(form, wall), margin = 0.05 * (high_ - low_).array() + 1e-3;
    Estimate porosity = porosity_.at(x);
    const double outside = std::max({0.0, low_[4] - wall, wall - high_[4]});
    porosity.standard_deviation = std::hypot(porosity.standard_deviation, porosity_per_wall * outside);
    Prediction prediction = combined(porosity, log_kozeny_.at(x), form.sphericity);
    prediction.extrapolated = ((x.array() < (low_ - margin).array()) || (x.array() > (high_ + margin).array())).any();
    return prediction;
}

Prediction Surrogate::leave_one_out(std::size_t i) const {
    const auto row = static_cast<Eigen::Index>(i);
    return combined(porosity_.leave_one_out(row), log_kozeny_.leave_one_out(row), beds_[i].form.sphericity);
}

}  // namespace porepack::design
