#include "scans/scanner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/parallel.hpp"
#include "scans/projection_filters.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
using shapes::Capsule;
using shapes::Vec3;
namespace {

constexpr int rows_of_block = 16, rays_of_pixel = 2;
constexpr double margin_voxels = 4.0;
// Shares of the photons, and attenuation relative to the mean, of plastics at about 40, 60 and 90 keV.
constexpr std::array<double, 3> shares = {0.30, 0.45, 0.25}, hardness = {1.27, 0.93, 0.80};

double outer_radius(const Container& container, const ScannerConfig& config) {
    if (const auto tube = container.tube_diameter()) return 0.5 * *tube + config.tube_wall_m;
    return 0.5 * std::hypot(container.size().x(), container.size().y());
}

int pixels_of(const Container& container, const ScannerConfig& config) {
    return 2 * static_cast<int>(std::ceil(outer_radius(container, config) / config.voxel_size_m + margin_voxels));
}

long views_of(const Container& container, const ScannerConfig& config) {
    return config.views > 0 ? config.views : std::lround(1.6 * pixels_of(container, config));
}

Grid grid_of(const Container& container, const Section& part, const ScannerConfig& config) {
    const double h = config.voxel_size_m;
    const Vec3 middle = 0.5 * (container.low() + container.high());
    Grid grid;
    for (const int axis : {0, 1}) {
        const auto a = static_cast<std::size_t>(axis);
        const double half = container.tube_diameter() ? outer_radius(container, config) : 0.5 * container.size()[axis];
        // An even number, so that the axis lies between two voxels.
        grid.cells[a] = 2 * static_cast<int>(std::ceil(half / h + margin_voxels - 1.0));
        grid.origin_m[a] = middle[axis] - 0.5 * grid.cells[a] * h;
    }
    grid.cells[2] = static_cast<int>(std::floor(part.length() / h + 1e-9));
    grid.origin_m[2] = part.z0_m;
    grid.spacing_m = {h, h, h};
    return grid;
}

// One direction of view in the scanner's frame, which is the container's, with its middle in the origin.
struct View {
    Vec3 along, across;  ///< of the beam, of the detector's rows
    View(long number, long views) {
        const double angle = std::numbers::pi * static_cast<double>(number) / static_cast<double>(views);
        along = Vec3(std::cos(angle), std::sin(angle), 0.0);
        across = Vec3(-std::sin(angle), std::cos(angle), 0.0);
    }
};

// The detector's pixels of a block of rows, each with several rays.
struct Detector {
    int columns, rows;  ///< of rays
    double step, z0;    ///< between rays; lower edge
    [[nodiscard]] double u(int column) const { return (column + 0.5 - 0.5 * columns) * step; }
    [[nodiscard]] double z(int row) const { return z0 + (row + 0.5) * step; }
};

// A grain that encloses a filled cavity, in the scanner's frame.
struct HollowGrain {
    std::vector<Capsule> capsules;
    shapes::PlacedShape grain;
};

// The grains in the scanner's frame, or those near a block of rows.
struct ScannedGrains {
    std::vector<Capsule> capsules;
    std::vector<HollowGrain> hollow;
    std::vector<shapes::PlacedShape> faced;
};

// Length of each ray in the grains.
// The intervals of a ray in all capsules are united before their lengths are summed, so that overlaps of capsules count once. Grains with a
// filled cavity are united on their own first, to join the parts on both sides of their cavities.
class Chords {
public:
    explicit Chords(const Detector& detector) : detector_(detector), parts_(static_cast<std::size_t>(detector.columns * detector.rows)) {}

    void project(const ScannedGrains& grains, const View& view, std::vector<double>& lengths) {
        for (auto& parts : parts_) parts.clear();
        for (const Capsule& capsule : grains.capsules)
            for_rays_near(capsule, view, [&](std::size_t ray, const Vec3& origin) {
                if (const auto part = line_interval(capsule, origin, view.along)) parts_[ray].push_back(*part);
            });
        std::vector<Interval> of_body;
        for (const shapes::PlacedShape& grain : grains.faced) {
            const shapes::RoundedBody& body = *grain.shape.body;
            const shapes::Quaternion to_shape = grain.orientation.conjugate();
            const auto extent = [&](const Vec3& axis) {
                const double middle = axis.dot(grain.position_m);
                return Interval{middle - body.support(to_shape * -axis), middle + body.support(to_shape * axis)};
            };
            for_rays_within(extent(view.across), extent(Vec3::UnitZ()), view, [&](std::size_t ray, const Vec3& origin) {
                body.line(grain.to_shape(origin), to_shape * view.along, 0.0, of_body);
                parts_[ray].insert(parts_[ray].end(), of_body.begin(), of_body.end());
            });
        }
        std::map<std::size_t, std::vector<Interval>> own;  // by ray
        for (const HollowGrain& hollow : grains.hollow) {
            own.clear();
            for (const Capsule& capsule : hollow.capsules)
                for_rays_near(capsule, view, [&](std::size_t ray, const Vec3& origin) {
                    if (const auto part = line_interval(capsule, origin, view.along)) own[ray].push_back(*part);
                });
            for (auto& [ray, parts] : own) {
                unite(parts);
                join_over_cavities(hollow.grain.shape, hollow.grain.to_shape(origin_of(ray, view)),
                                   hollow.grain.orientation.conjugate() * view.along, parts);
                parts_[ray].insert(parts_[ray].end(), parts.begin(), parts.end());
            }
        }
        lengths.assign(parts_.size(), 0.0);
        for (std::size_t ray = 0; ray < parts_.size(); ++ray) {
            if (parts_[ray].empty()) continue;
            unite(parts_[ray]);
            for (const Interval& part : parts_[ray]) lengths[ray] += part.high - part.low;
        }
    }

private:
    [[nodiscard]] Vec3 origin_of(std::size_t ray, const View& view) const {
        const auto columns = static_cast<std::size_t>(detector_.columns);
        return detector_.u(static_cast<int>(ray % columns)) * view.across + Vec3(0.0, 0.0, detector_.z(static_cast<int>(ray / columns)));
    }
    template <typename Use>
    void for_rays_near(const Capsule& capsule, const View& view, const Use& use) const {
        const double ua = capsule.a.dot(view.across), ub = capsule.b.dot(view.across), r = capsule.radius;
        for_rays_within({std::min(ua, ub) - r, std::max(ua, ub) + r},
                        {std::min(capsule.a.z(), capsule.b.z()) - r, std::max(capsule.a.z(), capsule.b.z()) + r}, view, use);
    }
    template <typename Use>
    void for_rays_within(const Interval& u, const Interval& z, const View& view, const Use& use) const {
        const double half_width = 0.5 * detector_.columns * detector_.step;
        const auto [i0, i1] = range(u.low + half_width, u.high + half_width, detector_.columns);
        const auto [j0, j1] = range(z.low - detector_.z0, z.high - detector_.z0, detector_.rows);
        for (int j = j0; j < j1; ++j)
            for (int i = i0; i < i1; ++i) {
                const auto ray = static_cast<std::size_t>(j * detector_.columns + i);
                use(ray, origin_of(ray, view));
            }
    }
    [[nodiscard]] std::pair<int, int> range(double low, double high, int count) const {
        return {std::max(0, static_cast<int>(std::floor(low / detector_.step))),
                std::min(count, static_cast<int>(std::ceil(high / detector_.step)) + 1)};
    }
    const Detector detector_;
    std::vector<std::vector<Interval>> parts_;
};

// Length of a ray in an endless cylinder about `axis` through the origin.
double chord_of_cylinder(const Vec3& axis, double radius, const Vec3& origin, const Vec3& direction) {
    // Both projected onto the plane normal to the axis, in which the cylinder is a circle; the ray's parameter remains its length.
    const Vec3 d = direction - direction.dot(axis) * axis, o = origin - origin.dot(axis) * axis;
    const double a = d.squaredNorm(), b = d.dot(o), c = o.squaredNorm() - radius * radius;
    const double square = b * b - a * c;
    return square > 0.0 ? 2.0 * std::sqrt(square) / a : 0.0;
}

class Scanner {
public:
    Scanner(const Packing& packing, const Section& part, const ScannerConfig& config)
        : config_(config),
          container_(packing.container),
          grid_(grid_of(container_, part, config)),
          pixels_(pixels_of(container_, config)),
          views_(views_of(container_, config)),
          halo_(static_cast<int>(std::ceil(4.0 * config.blur_voxels))),
          size_(2 * pixels_),
          filter_(filter_of(size_)) {
        const Vec3 low = container_.low(), high = container_.high();
        attenuation_ = config.thickness_attenuation / (high.x() - low.x());
        const Vec3 middle(0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), 0.5 * (part.z0_m + part.z1_m));
        const Eigen::Matrix3d tilt(Eigen::AngleAxisd(config.tilt_deg * std::numbers::pi / 180.0, Vec3::UnitX()));
        axis_ = tilt * Vec3::UnitZ();
        const Vec3 back(0.0, 0.0, middle.z());
        for (const Body& body : packing.bodies) {
            const shapes::Shape& shape = packing.shapes[body.shape];
            const shapes::PlacedShape grain{shape, tilt * (body.position_m - middle) + back, shapes::Quaternion(tilt) * body.orientation};
            if (shape.body != nullptr) {
                grains_.faced.push_back(grain);
                continue;
            }
            std::vector<Capsule> own;
            for (const Capsule& capsule : world_capsules(packing, body))
                own.push_back({tilt * (capsule.a - middle) + back, tilt * (capsule.b - middle) + back, capsule.radius});
            if (has_filled_cavity(shape))
                grains_.hollow.push_back({std::move(own), grain});
            else
                grains_.capsules.insert(grains_.capsules.end(), own.begin(), own.end());
        }
        middle_z_ = middle.z();
    }

    SimulatedScan run() {
        SimulatedScan scan{.grid = grid_, .values = {}};
        scan.values.reserve(grid_.size());
        Progress progress("scan");
        for (int first = 0; first < grid_.cells[2]; first += rows_of_block) {
            const int rows = std::min(rows_of_block, grid_.cells[2] - first);
            project_block(first, rows);
            reconstruct_block(rows, scan.values);
            progress.update(static_cast<double>(first + rows) / grid_.cells[2]);
        }
        return scan;
    }

private:
    // Filtered projections of a block of rows, one after another for each view.
    // The order is that of the physics: chords, attenuation, the detector's blur on intensities, and only then counts, gains and the
    // logarithm. The block is projected with a halo of four standard deviations of the blur above and below, so that its rows do not depend
    // on where blocks end.
    void project_block(int first, int rows) {
        const double h = config_.voxel_size_m;
        const int all = rows + 2 * halo_;
        const Detector detector{pixels_ * rays_of_pixel, all * rays_of_pixel, h / rays_of_pixel, grid_.origin_m[2] + (first - halo_) * h};
        const auto is_near = [&](const Capsule& capsule) {
            return std::min(capsule.a.z(), capsule.b.z()) - capsule.radius < detector.z(detector.rows) &&
                   std::max(capsule.a.z(), capsule.b.z()) + capsule.radius > detector.z0;
        };
        ScannedGrains near;
        for (const Capsule& capsule : grains_.capsules)
            if (is_near(capsule)) near.capsules.push_back(capsule);
        for (const HollowGrain& grain : grains_.hollow)
            if (std::any_of(grain.capsules.begin(), grain.capsules.end(), is_near)) near.hollow.push_back(grain);
        for (const shapes::PlacedShape& grain : grains_.faced)
            if (const shapes::Bounds bounds = bounds_of(grain); bounds.low.z() < detector.z(detector.rows) && bounds.high.z() > detector.z0)
                near.faced.push_back(grain);
        // A pixel keeps its gain in all views: that is what makes a ring. Seeds depend on the row, not on the block or the thread.
        std::vector<float> gains(static_cast<std::size_t>(rows * pixels_), 1.0F);
        for (int row = 0; row < rows; ++row) {
            std::mt19937_64 random(static_cast<std::uint64_t>(config_.seed) * 1000003U + static_cast<std::uint64_t>(first + row));
            std::normal_distribution<float> gain(1.0F, static_cast<float>(config_.gain_error));
            if (config_.gain_error > 0.0)
                for (int i = 0; i < pixels_; ++i) gains[static_cast<std::size_t>(row * pixels_ + i)] = gain(random);
        }
        filtered_.resize(static_cast<std::size_t>(views_) * static_cast<std::size_t>(rows * pixels_));
        constexpr std::size_t parts = 8;  // of the views; each has its own buffers
        parallel_for(parts, [&](std::size_t part) {
            Chords chords(detector);
            Eigen::FFT<float> fft;
            std::vector<double> lengths;
            for (long v = static_cast<long>(part); v < views_; v += static_cast<long>(parts)) {
                check_interrupt();
                const View view(v, views_);
                chords.project(near, view, lengths);
                std::vector<float> beam = intensities(detector, view, lengths, all);
                blur_rows(beam, pixels_, all, config_.blur_voxels);
                for (int row = 0; row < rows; ++row)
                    filter_row(fft, beam.data() + static_cast<std::ptrdiff_t>((row + halo_) * pixels_),
                               gains.data() + static_cast<std::ptrdiff_t>(row * pixels_), v, first + row,
                               filtered_.data() + (static_cast<std::ptrdiff_t>(v) * rows + row) * pixels_);
            }
        });
    }

    // Share of the photons that reach each pixel.
    [[nodiscard]] std::vector<float> intensities(const Detector& detector, const View& view, const std::vector<double>& lengths,
                                                 int rows) const {
        const bool tube = container_.tube_diameter() && config_.tube_wall_m > 0.0;
        const double inner = 0.5 * container_.tube_diameter().value_or(0.0), outer = inner + config_.tube_wall_m;
        std::vector<float> beam(static_cast<std::size_t>(rows * pixels_), 0.0F);
        for (int j = 0; j < detector.rows; ++j)
            for (int i = 0; i < detector.columns; ++i) {
                double depth = lengths[static_cast<std::size_t>(j * detector.columns + i)];
                if (tube) {
                    const Vec3 origin = detector.u(i) * view.across + Vec3(0.0, 0.0, detector.z(j) - middle_z_);
                    depth += config_.tube_attenuation *
                             (chord_of_cylinder(axis_, outer, origin, view.along) - chord_of_cylinder(axis_, inner, origin, view.along));
                }
                double share = 0.0;
                if (config_.one_energy)
                    share = std::exp(-attenuation_ * depth);
                else
                    for (std::size_t e = 0; e < shares.size(); ++e) share += shares[e] * std::exp(-attenuation_ * hardness[e] * depth);
                // Intensities are averaged over a pixel, not depths: attenuation is not linear.
                beam[static_cast<std::size_t>(j / rays_of_pixel * pixels_ + i / rays_of_pixel)] +=
                    static_cast<float>(share / (rays_of_pixel * rays_of_pixel));
            }
        return beam;
    }

    // Counts, logarithm and filter of one row of one view.
    void filter_row(Eigen::FFT<float>& fft, const float* beam, const float* gain, long view, int row, float* out) const {
        std::mt19937_64 random((static_cast<std::uint64_t>(config_.seed) << 40U) + static_cast<std::uint64_t>(view) * 100003U +
                               static_cast<std::uint64_t>(row));
        std::vector<float> line(static_cast<std::size_t>(size_), 0.0F);
        // A pixel without photons has no logarithm: it counts as half a photon.
        const double minimum = config_.counts > 0.0 ? 0.5 / config_.counts : 1e-9;
        for (int i = 0; i < pixels_; ++i) {
            double share = beam[i];
            if (config_.counts > 0.0)
                share = static_cast<double>(std::poisson_distribution<long>(config_.counts * share)(random)) / config_.counts;
            line[static_cast<std::size_t>(i)] = -std::log(static_cast<float>(std::max(minimum, share * gain[i])));
        }
        std::vector<std::complex<float>> transformed;
        fft.fwd(transformed, line);
        for (std::size_t i = 0; i < transformed.size(); ++i) transformed[i] *= filter_[i];
        fft.inv(line, transformed);
        std::copy_n(line.begin(), pixels_, out);
    }

    void reconstruct_block(int rows, std::vector<float>& values) const {
        // Back projection: each voxel sums the filtered projections at the pixel that its centre is projected to, linearly interpolated.
        // Along a row of voxels this place advances by a constant step, so only its beginning is computed.
        const std::size_t layer = grid_.index(0, 0, 1), start = values.size();
        values.resize(start + static_cast<std::size_t>(rows) * layer, 0.0F);
        const double h = config_.voxel_size_m;
        const Vec3 middle = 0.5 * (container_.low() + container_.high());
        const int strips = 4;  // of a layer, so that a few layers keep all threads busy
        parallel_for(static_cast<std::size_t>(rows * strips), [&](std::size_t task) {
            const int row = static_cast<int>(task) / strips, strip = static_cast<int>(task) % strips;
            const int j0 = grid_.cells[1] * strip / strips, j1 = grid_.cells[1] * (strip + 1) / strips;
            float* const to = values.data() + start + static_cast<std::size_t>(row) * layer;
            for (long v = 0; v < views_; ++v) {
                const View view(v, views_);
                const float* from = filtered_.data() + (static_cast<std::ptrdiff_t>(v) * rows + row) * pixels_;
                for (int j = j0; j < j1; ++j) {
                    const double y = grid_.centre(1, j) - middle.y(), x0 = grid_.centre(0, 0) - middle.x();
                    const auto begin = static_cast<float>((x0 * view.across.x() + y * view.across.y()) / h + 0.5 * pixels_ - 0.5);
                    const auto step = static_cast<float>(view.across.x());
                    float* const line = to + static_cast<std::ptrdiff_t>(j) * grid_.cells[0];
                    for (int i = 0; i < grid_.cells[0]; ++i) {
                        const float u = std::clamp(begin + step * static_cast<float>(i), 0.0F, static_cast<float>(pixels_) - 1.001F);
                        const int pixel = static_cast<int>(u);
                        line[i] += from[pixel] + (u - static_cast<float>(pixel)) * (from[pixel + 1] - from[pixel]);
                    }
                }
            }
            // The integral over the angle has the step pi / views; 1 / h because the filter is that of pixels of unit width.
            const auto scale = static_cast<float>(std::numbers::pi / (static_cast<double>(views_) * h));
            for (int j = j0; j < j1; ++j)
                for (int i = 0; i < grid_.cells[0]; ++i) {
                    const double away = std::hypot(grid_.centre(0, i) - middle.x(), grid_.centre(1, j) - middle.y()) / h;
                    // The detector sees a circle; nothing is known outside.
                    to[static_cast<std::ptrdiff_t>(j) * grid_.cells[0] + i] *= away < 0.5 * pixels_ - 1.0 ? scale : 0.0F;
                }
        });
    }

    const ScannerConfig config_;
    const Container container_;
    const Grid grid_;
    const int pixels_;
    const long views_;
    const int halo_, size_;
    const std::vector<float> filter_;
    double attenuation_ = 0.0, middle_z_ = 0.0;
    Vec3 axis_;
    ScannedGrains grains_;
    std::vector<float> filtered_;
};

}  // namespace

double scan_memory_bytes(const Container& container, const Section& part, const ScannerConfig& config) {
    const double rays = static_cast<double>(pixels_of(container, config)) * rows_of_block;
    return 4.0 * (static_cast<double>(grid_of(container, part, config).size()) + rays * static_cast<double>(views_of(container, config)) +
                  60.0 * rays * rays_of_pixel * rays_of_pixel);
}

SimulatedScan scan_packing(const Packing& packing, const Section& part, const ScannerConfig& config) {
    if (packing.container.any_periodic())
        throw UserError("a periodic container cannot be scanned", {.fix = "a container without periodic sides"});
    if (!(config.voxel_size_m > 0.0)) throw UserError("no voxel size", {.where = "--voxel-size"});
    if (grid_of(packing.container, part, config).cells[2] < 1)
        throw UserError("the scanned part is lower than a voxel", {.where = "--part", .fix = "a longer part, or smaller voxels"});
    require_memory(scan_memory_bytes(packing.container, part, config), "the scan", "use larger voxels, or scan a part");
    return Scanner(packing, part, config).run();
}

}  // namespace porepack::scans
