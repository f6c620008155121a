#include "pore_space/gray_solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/median.hpp"
#include "core/parallel.hpp"

namespace porepack::pore_space {
using namespace core;
using namespace geometry;
using namespace packing;
using namespace shapes;

GraySolid::GraySolid(std::shared_ptr<const GrayImage> image, const Container& container)
    : image_(std::move(image)), periodic_(container.periodic), level_(image_->level) {}

GraySolid::Place GraySolid::place(int axis, double coordinate) const {
    const auto a = static_cast<std::size_t>(axis);
    const Grid& grid = image_->grid;
    const int n = grid.cells[a];
    const double at = (coordinate - grid.origin_m[a]) / grid.spacing_m[a] - 0.5, floor = std::floor(at);
    Place place{.low = static_cast<int>(floor), .high = static_cast<int>(floor) + 1, .part = at - floor};
    const auto bring_in = [&](int i) { return periodic_[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1); };
    place.low = bring_in(place.low);
    place.high = bring_in(place.high);
    return place;
}

double GraySolid::value(const Vec3& point) const {
    const Place x = place(0, point.x()), y = place(1, point.y()), z = place(2, point.z());
    const Grid& grid = image_->grid;
    const auto line = [&](int j, int k) {
        return (1.0 - x.part) * image_->at(grid.index(x.low, j, k)) + x.part * image_->at(grid.index(x.high, j, k));
    };
    const auto plane = [&](int k) { return (1.0 - y.part) * line(y.low, k) + y.part * line(y.high, k); };
    return (1.0 - z.part) * plane(z.low) + z.part * plane(z.high);
}

GraySolid GraySolid::with_level(double level) const {
    GraySolid copy = *this;
    copy.level_ = level;
    return copy;
}

Bounds GraySolid::bounds() const {
    const Grid& grid = image_->grid;
    const Vec3 low(grid.origin_m[0], grid.origin_m[1], grid.origin_m[2]);
    const Vec3 size(grid.cells[0] * grid.spacing_m[0], grid.cells[1] * grid.spacing_m[1], grid.cells[2] * grid.spacing_m[2]);
    return {low, low + size};
}

// Along a vertical line the values are linear between the centres of the layers.
void GraySolid::column(double x, double y, std::vector<Interval>& parts) const {
    parts.clear();
    const Grid& grid = image_->grid;
    const Place px = place(0, x), py = place(1, y);
    const int n = grid.cells[2];
    const double h = grid.spacing_m[2], level = level_;
    const auto in_layer = [&](int k) {
        return (1.0 - py.part) *
                   ((1.0 - px.part) * image_->at(grid.index(px.low, py.low, k)) + px.part * image_->at(grid.index(px.high, py.low, k))) +
               py.part *
                   ((1.0 - px.part) * image_->at(grid.index(px.low, py.high, k)) + px.part * image_->at(grid.index(px.high, py.high, k)));
    };
    const double bottom = grid.origin_m[2], top = bottom + n * h;
    double before = periodic_[2] ? in_layer(n - 1) : in_layer(0), z = bottom - 0.5 * h;
    if (before > level) parts.push_back({bottom, top});
    for (int k = 0; k <= n; ++k, z += h) {
        const double value = k < n ? in_layer(k) : periodic_[2] ? in_layer(0) : before;
        if ((before > level) != (value > level)) {
            const double at = std::clamp(z + h * (level - before) / (value - before), bottom, top);
            if (value > level)
                parts.push_back({at, top});
            else
                parts.back().high = at;
        }
        before = value;
    }
    std::erase_if(parts, [](const Interval& part) { return part.high <= part.low; });
}

// Interpolated values do not exceed those of the voxels around: the layers in which one of these is above the level, and those beside them.
void GraySolid::near_column(double x, double y, double length, std::vector<Interval>& parts) const {
    parts.clear();
    const Grid& grid = image_->grid;
    const double reach = 0.5 * length, h = grid.spacing_m[2];
    const auto cells = [&](int axis, double from) {
        const auto a = static_cast<std::size_t>(axis);
        const int n = grid.cells[a];
        const auto at = [&](double value) { return static_cast<int>(std::floor((value - grid.origin_m[a]) / grid.spacing_m[a] - 0.5)); };
        std::vector<int> found;
        for (int i = at(from - reach); i <= at(from + reach) + 1; ++i)
            found.push_back(periodic_[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1));
        return found;
    };
    const std::vector<int> xs = cells(0, x), ys = cells(1, y);
    const int n = grid.cells[2];
    for (int k = 0; k < n; ++k) {
        const bool above = std::any_of(ys.begin(), ys.end(), [&](int j) {
            return std::any_of(xs.begin(), xs.end(), [&](int i) { return image_->at(grid.index(i, j, k)) > level_; });
        });
        if (!above) continue;
        const double z = grid.centre(2, k), margin = h + reach;
        parts.push_back({k == 0 ? -1e300 : z - margin, k + 1 == n ? 1e300 : z + margin});
        if (periodic_[2] && k == 0) parts.push_back({z + n * h - margin, 1e300});
        if (periodic_[2] && k + 1 == n) parts.push_back({-1e300, z - n * h + margin});
    }
    unite(parts);
}

class GraySolid::Probe : public SolidProbe {
public:
    explicit Probe(const GraySolid& solid) : solid_(solid) {}
    // Interpolated values do not exceed those of the voxels around: where none is above the level, nothing is hit.
    void move_to(const Vec3& point, double reach) override {
        const GrayImage& image = *solid_.image_;
        const Grid& grid = image.grid;
        std::array<std::array<int, 16>, 3> cells;
        std::array<std::size_t, 3> count;
        for (std::size_t a = 0; a < 3; ++a) {
            const int n = grid.cells[a];
            const auto cell = [&](double coordinate) {
                return static_cast<int>(std::floor((coordinate - grid.origin_m[a]) / grid.spacing_m[a] - 0.5));
            };
            const double at = point[static_cast<int>(a)];
            const int low = cell(at - reach), high = cell(at + reach) + 1;
            if (high - low >= static_cast<int>(cells[a].size())) {
                near_ = true;
                return;
            }
            count[a] = static_cast<std::size_t>(high - low + 1);
            for (int i = low; i <= high; ++i)
                cells[a][static_cast<std::size_t>(i - low)] = solid_.periodic_[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1);
        }
        std::uint16_t largest = 0;
        for (std::size_t k = 0; k < count[2]; ++k)
            for (std::size_t j = 0; j < count[1]; ++j)
                for (std::size_t i = 0; i < count[0]; ++i)
                    largest = std::max(largest, image.packed[grid.index(cells[0][i], cells[1][j], cells[2][k])]);
        near_ = largest >= GrayImage::pack(solid_.level_);
    }
    // Along a segment through one voxel the values are a cubic polynomial: steps of a quarter of a voxel find its roots.
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        if (!near_) return std::nullopt;
        const double level = solid_.level_;
        const int steps = std::max(1, static_cast<int>(std::ceil(4.0 * step.norm() / solid_.image_->grid.spacing_m[0])));
        double before = solid_.value(from), at = 0.0;
        if (before > level) return 0.0;
        for (int i = 1; i <= steps; ++i) {
            const double next = static_cast<double>(i) / steps, value = solid_.value(from + next * step);
            if (value > level) return root(from, step, {at, before}, {next, value});
            at = next;
            before = value;
        }
        return std::nullopt;
    }

private:
    struct End {
        double at, value;
    };
    [[nodiscard]] double root(const Vec3& from, const Vec3& step, End outside, End inside) const {
        const double level = solid_.level_;
        double at = inside.at;
        for (int i = 0; i < 3; ++i) {
            at = outside.at + (inside.at - outside.at) * (level - outside.value) / (inside.value - outside.value);
            const double value = solid_.value(from + at * step);
            (value > level ? inside : outside) = {at, value};
        }
        return at;
    }
    const GraySolid& solid_;
    bool near_ = false;
};

std::unique_ptr<SolidProbe> GraySolid::probe() const {
    return std::make_unique<Probe>(*this);
}

namespace {

// Columns of voxels inside the container, at most about `most` of them, evenly spread.
using Columns = std::vector<std::array<int, 2>>;
Columns columns_in(const Grid& grid, const Container& container, double margin_voxels, std::size_t most) {
    const bool round = container.kind == Container::Kind::cylinder;
    const double radius = 0.5 * container.diameter_m - margin_voxels * grid.spacing_m[0];
    Columns all;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i)
            if (!round || std::hypot(grid.centre(0, i), grid.centre(1, j)) < radius) all.push_back({i, j});
    if (all.empty()) throw UserError("the image is too small: no voxel lies away from the container's wall");
    if (all.size() <= most) return all;
    Columns some;
    const double step = static_cast<double>(all.size()) / static_cast<double>(most);
    for (double at = 0.5 * step; at < static_cast<double>(all.size()); at += step) some.push_back(all[static_cast<std::size_t>(at)]);
    return some;
}

constexpr std::size_t most_columns = 20000;

// Fraction of the columns' voxels inside the level set, on four lines per voxel.
double solid_fraction(const GraySolid& solid, const Columns& columns) {
    const Grid& grid = solid.image()->grid;
    const double h = grid.spacing_m[0];
    std::vector<double> lengths(columns.size());
    parallel_for(lengths.size(), [&](std::size_t c) {
        thread_local std::vector<Interval> parts;
        for (const double dx : {-0.25, 0.25})
            for (const double dy : {-0.25, 0.25}) {
                solid.column(grid.centre(0, columns[c][0]) + dx * h, grid.centre(1, columns[c][1]) + dy * h, parts);
                for (const Interval& part : parts) lengths[c] += 0.25 * (part.high - part.low);
            }
    });
    double sum = 0.0;
    for (const double length : lengths) sum += length;
    return sum / (static_cast<double>(lengths.size()) * grid.cells[2] * grid.spacing_m[2]);
}

double gray_fraction(const GrayImage& image, const Columns& columns) {
    double sum = 0.0;
    for (const auto& [i, j] : columns)
        for (int k = 0; k < image.grid.cells[2]; ++k) sum += image.at(image.grid.index(i, j, k));
    return sum / (static_cast<double>(columns.size()) * image.grid.cells[2]);
}

// A wall that a Gaussian blurs has there the slope 1 / (sigma sqrt(2 pi)). The voxels add the variance 1/12, differences of neighbours at a
// distance of two voxels add 1/3.
double blur_of(const GraySolid& solid, const Columns& columns) {
    const GrayImage& image = *solid.image();
    const Grid& grid = image.grid;
    const double level = solid.level();
    std::vector<double> slopes;
    for (const auto& [i, j] : columns) {
        if (i == 0 || j == 0 || i + 1 == grid.cells[0] || j + 1 == grid.cells[1]) continue;
        for (int k = 1; k + 2 < grid.cells[2]; ++k) {
            const std::size_t cell = grid.index(i, j, k);
            const double here = image.at(cell), above = image.at(grid.index(i, j, k + 1));
            if ((here > level) == (above > level)) continue;
            const auto slope_at = [&](int l) {
                const double x = image.at(grid.index(i + 1, j, l)) - image.at(grid.index(i - 1, j, l));
                const double y = image.at(grid.index(i, j + 1, l)) - image.at(grid.index(i, j - 1, l));
                const double z = image.at(grid.index(i, j, l + 1)) - image.at(grid.index(i, j, l - 1));
                return 0.5 * std::sqrt(x * x + y * y + z * z);
            };
            const double part = (level - here) / (above - here);
            slopes.push_back((1.0 - part) * slope_at(k) + part * slope_at(k + 1));
        }
    }
    if (slopes.empty()) return 0.0;
    const double width = 1.0 / (median(slopes) * std::sqrt(2.0 * std::numbers::pi));
    return std::sqrt(std::max(0.0, width * width - 1.0 / 12.0 - 1.0 / 3.0));
}

double area_per_volume(const GrayImage& image, double level, const Columns& columns) {
    const Grid& grid = image.grid;
    double crossings = 0.0, pairs = 0.0;
    for (const auto& [i, j] : columns)
        for (int k = 0; k + 1 < grid.cells[2]; ++k) {
            if (i + 1 == grid.cells[0] || j + 1 == grid.cells[1]) continue;
            const bool here = image.at(grid.index(i, j, k)) > level;
            for (const std::size_t next : {grid.index(i + 1, j, k), grid.index(i, j + 1, k), grid.index(i, j, k + 1)})
                crossings += here != (image.at(next) > level) ? 1.0 : 0.0;
            pairs += 3.0;
        }
    return pairs > 0.0 ? 2.0 * crossings / pairs / grid.spacing_m[0] : 0.0;
}

}  // namespace

double solid_fraction(const GraySolid& solid, const Container& container, double margin_voxels) {
    return solid_fraction(solid, columns_in(solid.image()->grid, container, margin_voxels, most_columns));
}

GrayMeasures measure_gray(const GraySolid& solid, const Container& container, double margin_voxels) {
    const GrayImage& image = *solid.image();
    const Columns columns = columns_in(image.grid, container, margin_voxels, most_columns);
    GrayMeasures found{.blur = blur_of(solid, columns),
                       .area_per_volume_m = area_per_volume(image, solid.level(), columns),
                       .solid_fraction = solid_fraction(solid, columns),
                       .gray_fraction = gray_fraction(image, columns)};
    constexpr double apart = 0.05;
    found.slope = (solid_fraction(solid.with_level(solid.level() + apart), columns) -
                   solid_fraction(solid.with_level(solid.level() - apart), columns)) /
                  (2.0 * apart);
    return found;
}

Plateaus plateaus(const GraySolid& solid, const Container& container, int depth_voxels, double margin_voxels) {
    const GrayImage& image = *solid.image();
    const Grid& grid = image.grid;
    std::vector<std::uint8_t> counted(static_cast<std::size_t>(grid.cells[0]) * static_cast<std::size_t>(grid.cells[1]), 0);
    for (const auto& [i, j] : columns_in(grid, container, margin_voxels, counted.size())) counted[grid.index(i, j, 0)] = 1;
    // depth[cell]: number of steps from the nearest voxel of the other phase, alternately over faces and over corners too.
    std::vector<std::uint8_t> depth(grid.size(), static_cast<std::uint8_t>(depth_voxels + 1));
    const std::uint16_t level = GrayImage::pack(solid.level());
    const auto neighbour = [&](int a, int i) {
        const int n = grid.cells[static_cast<std::size_t>(a)];
        return container.periodic[static_cast<std::size_t>(a)] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1);
    };
    for (int step = 1; step <= depth_voxels; ++step) {
        const int most = step % 2 == 1 ? 1 : 3;  // of the three coordinates that differ
        const auto near_other = [&](int i, int j, int k, std::size_t cell) {
            const bool phase = image.packed[cell] > level;
            for (int c = -1; c <= 1; ++c)
                for (int b = -1; b <= 1; ++b)
                    for (int a = -1; a <= 1; ++a) {
                        if (std::abs(a) + std::abs(b) + std::abs(c) > most) continue;
                        const std::size_t other = grid.index(neighbour(0, i + a), neighbour(1, j + b), neighbour(2, k + c));
                        if (step == 1 ? (image.packed[other] > level) != phase : depth[other] < step) return true;
                    }
            return false;
        };
        parallel_for(static_cast<std::size_t>(grid.cells[2]), [&](std::size_t layer) {
            const int k = static_cast<int>(layer);
            for (int j = 0; j < grid.cells[1]; ++j)
                for (int i = 0; i < grid.cells[0]; ++i)
                    if (const std::size_t cell = grid.index(i, j, k); depth[cell] > step && near_other(i, j, k, cell))
                        depth[cell] = static_cast<std::uint8_t>(step);
        });
    }
    Plateaus found;
    for (const bool of_solid : {false, true})
        for (int deep = depth_voxels; deep >= 1; --deep) {
            std::array<double, 8> sum{}, count{};
            for (int k = 0; k < grid.cells[2]; ++k)
                for (int j = 0; j < grid.cells[1]; ++j)
                    for (int i = 0; i < grid.cells[0]; ++i) {
                        const std::size_t cell = grid.index(i, j, k);
                        if (counted[grid.index(i, j, 0)] == 0 || depth[cell] <= deep || (image.packed[cell] > level) != of_solid) continue;
                        const std::size_t part =
                            (2 * i >= grid.cells[0] ? 1U : 0U) + (2 * j >= grid.cells[1] ? 2U : 0U) + (2 * k >= grid.cells[2] ? 4U : 0U);
                        sum[part] += image.at(cell);
                        count[part] += 1.0;
                    }
            double all = 0.0, total = 0.0;
            for (std::size_t part = 0; part < 8; ++part) {
                all += count[part];
                total += sum[part];
            }
            if (all < 64.0) continue;
            // Of a mean of parts with different numbers of voxels.
            Plateaus::Mean mean{.value = total / all, .depth_voxels = deep};
            double squares = 0.0, parts = 0.0;
            for (std::size_t part = 0; part < 8; ++part) {
                if (count[part] == 0.0) continue;
                squares += std::pow(count[part] / all * (sum[part] / count[part] - mean.value), 2.0);
                parts += 1.0;
            }
            mean.error = parts > 1.0 ? std::sqrt(squares * parts / (parts - 1.0)) : 0.0;
            (of_solid ? found.solid : found.pores) = mean;
            break;
        }
    return found;
}

void rescale(GrayImage& image, double pores, double solid) {
    parallel_for(static_cast<std::size_t>(image.grid.cells[2]), [&](std::size_t layer) {
        const std::size_t size = image.grid.index(0, 0, 1);
        for (std::size_t cell = layer * size; cell < (layer + 1) * size; ++cell)
            image.packed[cell] = GrayImage::pack((image.at(cell) - pores) / (solid - pores));
    });
}

// The volume falls with the level: regula falsi, kept inside the bracket by bisection.
double volume_keeping_level(const GraySolid& solid, const Container& container, double margin_voxels) {
    const Columns columns = columns_in(solid.image()->grid, container, margin_voxels, most_columns);
    const double wanted = gray_fraction(*solid.image(), columns);
    const auto surplus = [&](double level) { return solid_fraction(solid.with_level(level), columns) - wanted; };
    double low = 0.1, high = 0.9, at_low = surplus(low), at_high = surplus(high);
    if (at_low < 0.0 || at_high > 0.0)
        throw UserError(fmt::format("no level keeps the volume of the gray values: their mean is a solid fraction of {:.4f}", wanted),
                        {.fix = "give the threshold as a number; porepack image info shows the values"});
    for (int i = 0; i < 30 && high - low > 1e-5; ++i) {
        double middle = low + (high - low) * at_low / (at_low - at_high);
        if (i % 3 == 2 || !(middle > low && middle < high)) middle = 0.5 * (low + high);
        const double at_middle = surplus(middle);
        if (std::abs(at_middle) < 1e-7) return middle;
        (at_middle > 0.0 ? low : high) = middle;
        (at_middle > 0.0 ? at_low : at_high) = at_middle;
    }
    return 0.5 * (low + high);
}

PoreSpace pore_space_of(std::shared_ptr<const GraySolid> solid, const Container& container, const Section& section,
                        const std::string& where) {
    const Grid& grid = solid->image()->grid;
    require_fit(grid, container, section, where, solid->image()->notes.contains("shows_wall"));
    const GrayMeasures found = measure_gray(*solid, container);
    if (!(found.solid_fraction > 0.0 && found.area_per_volume_m > 0.0))
        throw UserError("there is no solid in the image at this threshold",
                        {.where = where, .fix = "porepack image info shows the values"});
    if (found.solid_fraction >= 1.0)
        throw UserError("there are no pores in the image at this threshold",
                        {.where = where, .fix = "porepack image info shows the values"});
    // 4 volume / area is the diameter of a long capsule, as for surfaces.
    PoreSpace space = pore_space::pore_space_of(solid, container, section, 4.0 * found.solid_fraction / found.area_per_volume_m);
    space.gray = std::move(solid);
    space.image_voxel_size_m = grid.spacing_m[2];
    space.bed_bottom_m = grid.origin_m[2];
    space.bed_top_m = grid.origin_m[2] + grid.cells[2] * grid.spacing_m[2];
    return space;
}

GrayImage averaged(const GrayImage& image, int factor) {
    GrayImage coarse{.grid = image.grid, .packed = {}, .level = image.level, .notes = {}};
    for (std::size_t a = 0; a < 3; ++a) {
        coarse.grid.cells[a] = image.grid.cells[a] / factor;
        coarse.grid.spacing_m[a] = image.grid.spacing_m[a] * factor;
    }
    coarse.packed.resize(coarse.grid.size());
    for (int k = 0; k < coarse.grid.cells[2]; ++k)
        for (int j = 0; j < coarse.grid.cells[1]; ++j)
            for (int i = 0; i < coarse.grid.cells[0]; ++i) {
                double sum = 0.0;
                for (int c = 0; c < factor; ++c)
                    for (int b = 0; b < factor; ++b)
                        for (int a = 0; a < factor; ++a) sum += image.at(image.grid.index(factor * i + a, factor * j + b, factor * k + c));
                coarse.packed[coarse.grid.index(i, j, k)] = GrayImage::pack(sum / (factor * factor * factor));
            }
    return coarse;
}

void smooth(GrayImage& image, double sigma_voxels, const std::array<bool, 3>& periodic) {
    if (sigma_voxels <= 0.0) return;
    const int reach = static_cast<int>(std::ceil(4.0 * sigma_voxels));
    std::vector<double> weight;
    for (int i = -reach; i <= reach; ++i) weight.push_back(std::exp(-0.5 * i * i / (sigma_voxels * sigma_voxels)));
    double sum = 0.0;
    for (const double w : weight) sum += w;
    const Grid& grid = image.grid;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
        const int n = grid.cells[a];
        parallel_for(static_cast<std::size_t>(grid.cells[c]), [&](std::size_t second) {
            std::vector<double> line(static_cast<std::size_t>(n + 2 * reach));
            std::array<int, 3> at{};
            at[c] = static_cast<int>(second);
            for (at[b] = 0; at[b] < grid.cells[b]; ++at[b]) {
                const auto cell = [&](int i) {
                    at[a] = i;
                    return grid.index(at[0], at[1], at[2]);
                };
                for (int i = -reach; i < n + reach; ++i)
                    line[static_cast<std::size_t>(i + reach)] = image.at(cell(periodic[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1)));
                for (int i = 0; i < n; ++i) {
                    double value = 0.0;
                    for (int j = 0; j <= 2 * reach; ++j)
                        value += weight[static_cast<std::size_t>(j)] * line[static_cast<std::size_t>(i + j)];
                    image.packed[cell(i)] = GrayImage::pack(value / sum);
                }
            }
        });
    }
}

}  // namespace porepack::pore_space
