#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "core/context.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "tortuosity/tortuosity.hpp"
#include "tortuosity/uses.hpp"

namespace porepack::tortuosity {
namespace {

using Vec2 = Eigen::Vector2d;

// Closest void point to a point of slice `slice`; nothing if there is none within reach.
using ClosestVoid = std::function<std::optional<Vec2>(const Vec2& from, int slice)>;

// A narrow container, for instance that of a small image, gets dots that are closer.
double spacing_of_dots(const Container& container, const TortuosityConfig& config) {
    constexpr double min_across = 3.0, across_narrow = 8.0;
    const double width = (container.high() - container.low()).head<2>().minCoeff();
    if (config.dot_spacing_m * min_across <= width) return config.dot_spacing_m;
    const double spacing = width / across_narrow;
    log_info("the container is {:.4g} m wide: the dots of geometric_paper are {:.4g} m apart, not {:.4g} m", width, spacing,
             config.dot_spacing_m);
    return spacing;
}

// A square grid of half-offset dots, those inside the container.
std::vector<Vec2> grid_of_dots(const Container& container, const TortuosityConfig& config) {
    const double spacing = spacing_of_dots(container, config);
    std::vector<Vec2> dots;
    const Vec3 low = container.low(), high = container.high();
    const Vec3 middle = 0.5 * (low + high);
    constexpr double max_dots = 1e7;
    if ((high.x() - low.x()) / spacing * ((high.y() - low.y()) / spacing) > max_dots)
        throw UserError(fmt::format("a dot spacing of {:g} m makes too many dots", spacing),
                        {.allowed = "at most 1e7 dots", .fix = "the spacing is in metres"});
    const int nx = static_cast<int>(std::ceil((high.x() - low.x()) / spacing)),
              ny = static_cast<int>(std::ceil((high.y() - low.y()) / spacing));
    for (int j = -ny; j <= ny; ++j)
        for (int i = -nx; i <= nx; ++i) {
            const Vec2 dot(middle.x() + (i + 0.5) * spacing, middle.y() + (j + 0.5) * spacing);
            const bool wanted = config.dot_radius_m == 0.0 || (dot - middle.head<2>()).norm() < config.dot_radius_m;
            if (wanted && container.contains_column(dot.x(), dot.y())) dots.push_back(dot);
        }
    return dots;
}

struct DotPath {
    double excess = 0.0;  // length minus height, summed without cancellation: exactly 0 for a straight path
    double height = 0.0;
    double straight = 0.0;
    long points = 0, rejected = 0;
    bool complete = true;
    std::vector<Vec3> path;
};

// Follows one dot from slice to slice. `shift` is the line dot -> moved dot.
// In each slice the path goes through the void point closest to the dot. Where the line from the dot to this point makes more than the
// largest angle with the line to the point in the slice before, the closest point has changed to another side of a grain: it is rejected,
// and the search begins again halfway between the dot and the previous point.
DotPath follow(const Vec2& dot, int slices, double z0, double spacing, double largest_angle, const ClosestVoid& closest_void) {
    DotPath path;
    Vec2 before = Vec2::Zero(), first = Vec2::Zero();
    for (int s = 0; s < slices; ++s) {
        auto point = closest_void(dot, s);
        if (point && s > 0) {
            const Vec2 shift = *point - dot, last = before - dot;
            const double product = shift.norm() * last.norm();
            if (product > 0.0 && shift.dot(last) < std::cos(largest_angle) * product - 1e-12 * product) {
                ++path.rejected;
                point = closest_void(0.5 * (dot + before), s);
            }
        }
        if (!point) {
            path.complete = false;
            return path;
        }
        ++path.points;
        if (s == 0)
            first = *point;
        else
            path.excess += (*point - before).squaredNorm() / (spacing + std::hypot((*point - before).norm(), spacing));
        before = *point;
        path.path.emplace_back(before.x(), before.y(), z0 + s * spacing);
    }
    path.height = (slices - 1) * spacing;
    path.straight = std::hypot((before - first).norm(), path.height);
    return path;
}

GeometricPaperResult average(const std::vector<Vec2>& dots, int slices, double z0, double spacing, double angle_deg,
                             const ClosestVoid& closest_void) {
    if (slices < 2) throw UserError("one slice does not make a path", {.fix = "use a longer section or a smaller slice spacing"});
    if (dots.empty()) throw UserError("no dot is inside the container", {.fix = "use a smaller dot_spacing_m"});
    std::vector<double> values;
    GeometricPaperResult result{.slices = slices};
    result.paths_m.resize(dots.size());
    long points = 0, rejected = 0, done = 0;
    Progress progress("tortuosity (geometric_paper)");
    // No exception may leave a parallel loop: an interrupt ends the loop early and is thrown after it.
    const Context& run = context();
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t d = 0; d < dots.size(); ++d) {
        const ContextScope here(run);
        if (interrupted()) continue;
        DotPath path = follow(dots[d], slices, z0, spacing, angle_deg * std::numbers::pi / 180.0, closest_void);
#pragma omp critical
        {
            if (path.complete) {
                values.push_back((path.height + path.excess) / path.straight);
                result.paths_m[d] = std::move(path.path);
            }
            points += path.points;
            rejected += path.rejected;
            progress.update(static_cast<double>(++done) / static_cast<double>(dots.size()));
        }
    }
    check_interrupt();
    if (values.empty())
        throw NumericalError("no path crosses the packing: some slices have no void point near any dot",
                             {.fix = "use a smaller dot_spacing_m or slice_spacing_m, or the shortest path, which needs no dots"});
    std::sort(values.begin(), values.end());  // the sum does not depend on the order in which threads finish
    std::erase_if(result.paths_m, [](const auto& path) { return path.empty(); });
    result.paths = static_cast<long>(values.size());
    for (const double value : values) result.value += (value - 1.0) / static_cast<double>(values.size());
    result.value += 1.0;
    double squares = 0.0;
    for (const double value : values) squares += (value - result.value) * (value - result.value);
    if (values.size() > 1) result.standard_deviation = std::sqrt(squares / static_cast<double>(values.size() - 1));
    result.standard_error = result.standard_deviation / std::sqrt(static_cast<double>(values.size()));
    result.rejections_per_point = static_cast<double>(rejected) / static_cast<double>(points);
    return result;
}

// The solid near a point: capsules, and as a whole the grains with faces and those that enclose a filled cavity. Such a cavity is solid: no
// dot moves into it.
struct NearSolid {
    const Grains& grains;
    std::vector<const Capsule*> capsules = {};
    std::vector<const Grains::Image*> whole = {};

    // The parts of a ray inside the solid: not joined, those before the origin left out; `parts` is overwritten.
    void ray_parts(const Vec3& origin, const Vec3& direction, std::vector<Interval>& parts) const {
        thread_local std::vector<Interval> own;
        parts.clear();
        for (const Capsule* capsule : capsules)
            if (const auto part = line_interval(*capsule, origin, direction))
                if (part->high > 0.0) parts.push_back(*part);
        for (const Grains::Image* image : whole) {
            grains.line_parts(*image, origin, direction, own);
            for (const Interval& part : own)
                if (part.high > 0.0) parts.push_back(part);
        }
    }
    [[nodiscard]] bool contains(const Vec3& point) const {
        if (std::any_of(capsules.begin(), capsules.end(), [&](const Capsule* c) { return signed_distance(*c, point) < 0.0; })) return true;
        thread_local std::vector<Interval> own;
        return std::any_of(whole.begin(), whole.end(), [&](const Grains::Image* image) {
            grains.line_parts(*image, point, Vec3::UnitX(), own);
            return std::any_of(own.begin(), own.end(), [](const Interval& part) { return part.low < 0.0 && part.high > 0.0; });
        });
    }
};

// Distance along a ray in the slice's plane to the first point outside all grains.
class RayExit {
public:
    RayExit(const NearSolid& solid, const Container& container, const Vec3& origin)
        : solid_(solid), container_(container), origin_(origin) {}
    double operator()(double angle) const {
        const Vec3 direction(std::cos(angle), std::sin(angle), 0.0);
        solid_.ray_parts(origin_, direction, parts_);
        std::sort(parts_.begin(), parts_.end(), [](const Interval& p, const Interval& q) { return p.low < q.low; });
        double at = 0.0;
        for (const auto& part : parts_) {
            if (part.low > at) break;
            at = std::max(at, part.high);
        }
        const Vec3 exit = origin_ + at * direction;
        if (!container_.any_periodic() && !container_.contains_column(exit.x(), exit.y())) return 1e300;
        return at;
    }

private:
    const NearSolid& solid_;
    const Container& container_;
    Vec3 origin_;
    mutable std::vector<Interval> parts_;
};

// Minimum exit distance over all directions: 96 directions, then golden-section search around the local minima among them.
std::optional<Vec2> closest_exit(const RayExit& exit, const Vec2& from) {
    constexpr int directions = 96;
    const double step = 2.0 * std::numbers::pi / directions;
    std::array<double, directions> coarse;
    for (int i = 0; i < directions; ++i) coarse[static_cast<std::size_t>(i)] = exit(i * step);
    if (coarse[0] == 0.0) return from;
    const auto at = [&](int i) { return coarse[static_cast<std::size_t>((i + directions) % directions)]; };
    double best = 1e300, best_angle = 0.0;
    for (int i = 0; i < directions; ++i) {
        if (at(i) > std::min(at(i - 1), at(i + 1)) || at(i) >= 1e300) continue;
        double low = (i - 1) * step, high = low + 2.0 * step;
        // Golden-section search needs no derivative: the exit distance has kinks where the ray passes from one capsule to another.
        constexpr double golden = 0.6180339887498949;
        double p = high - golden * (high - low), q = low + golden * (high - low);
        double fp = exit(p), fq = exit(q);
        while (high - low > 1e-7) {
            if (fp < fq) {
                high = q;
                q = p;
                fq = fp;
                p = high - golden * (high - low);
                fp = exit(p);
            } else {
                low = p;
                p = q;
                fp = fq;
                q = low + golden * (high - low);
                fq = exit(q);
            }
        }
        for (const auto& [value, angle] : {std::pair(std::min(fp, fq), fp < fq ? p : q), std::pair(at(i), i * step)})
            if (value < best) {
                best = value;
                best_angle = angle;
            }
    }
    if (best >= 1e300) return std::nullopt;
    return Vec2(from + best * Vec2(std::cos(best_angle), std::sin(best_angle)));
}

// As on an image: the point itself if the centre of its pixel is void, else the closest void centre.
std::optional<Vec2> closest_pixel(const NearSolid& solid, const Container& container, const Vec3& at, double pixel) {
    const auto is_void = [&](const Vec2& centre) {
        return container.contains_column(centre.x(), centre.y()) && !solid.contains(Vec3(centre.x(), centre.y(), at.z()));
    };
    const Vec2 from = at.head<2>();
    const Vec2 own = pixel * ((from / pixel).array().floor() + 0.5).matrix();
    if (is_void(own)) return from;
    // No void point is nearer than the exact closest point: start there. A ring at distance n has no point closer than (n - 1/2) pixels.
    const auto exact = closest_exit(RayExit(solid, container, at), from);
    if (!exact) return std::nullopt;
    double best = 1e300;
    Vec2 point = from;
    const double span = (container.high() - container.low()).norm();
    for (int n = std::max(1, static_cast<int>((*exact - from).norm() / (1.4143 * pixel) - 1.5)); (n - 0.5) * pixel < std::min(best, span);
         ++n)
        for (int j = -n; j <= n; ++j)
            for (int i = -n; i <= n; i += (j == -n || j == n) ? 1 : 2 * n) {
                const Vec2 centre = own + pixel * Vec2(i, j);
                const double distance = (centre - from).norm();
                if (distance >= best || !is_void(centre)) continue;
                best = distance;
                point = centre;
            }
    if (best >= 1e300) return std::nullopt;
    return point;
}

// What each slice cuts.
std::vector<NearSolid> solid_of_slices(const Grains& grains, const Section& section, int slices, double spacing) {
    std::vector<NearSolid> cut(static_cast<std::size_t>(slices), NearSolid{.grains = grains});
    const auto add = [&](const Bounds& bounds, const auto& to_slice) {
        const int from = std::max(0, static_cast<int>(std::ceil((bounds.low.z() - section.z0_m) / spacing)));
        const int to = std::min(slices - 1, static_cast<int>(std::floor((bounds.high.z() - section.z0_m) / spacing)));
        for (int s = from; s <= to; ++s) to_slice(cut[static_cast<std::size_t>(s)]);
    };
    for (const auto& image : grains.images()) {
        if (has_filled_cavity(grains.shape_of(image)) || grains.shape_of(image).body != nullptr) {
            add(image.bounds, [&](NearSolid& slice) { slice.whole.push_back(&image); });
            continue;
        }
        for (const auto& capsule : image.capsules) add(bounds_of({capsule}), [&](NearSolid& slice) { slice.capsules.push_back(&capsule); });
    }
    return cut;
}

}  // namespace

GeometricPaperResult geometric_paper_exact(const Grains& grains, const Container& container, const Section& section,
                                           const TortuosityConfig& config) {
    constexpr double max_slices = 1e6;
    if (section.length() / config.slice_spacing_m > max_slices)
        throw UserError(fmt::format("a slice spacing of {:g} m makes too many slices", config.slice_spacing_m),
                        {.allowed = "at most 1e6 slices", .fix = "the spacing is in metres"});
    const int slices = 1 + static_cast<int>(std::floor(section.length() / config.slice_spacing_m + 1e-9));
    const std::vector<NearSolid> cut = solid_of_slices(grains, section, slices, config.slice_spacing_m);
    const double reach = (container.high() - container.low()).norm();
    // The first radius of the search below: about a grain's thickness, and some pixels.
    const double nearest_reach = std::max(std::min(reach, finest_diameter(grains.packing())), 4.0 * config.dot_pixel_m);
    const ClosestVoid closest = [&](const Vec2& from, int slice) -> std::optional<Vec2> {
        const Vec3 at(from.x(), from.y(), section.z0_m + slice * config.slice_spacing_m);
        thread_local std::vector<std::pair<double, const Capsule*>> all;
        const NearSolid& of_slice = cut[static_cast<std::size_t>(slice)];
        NearSolid near{.grains = grains};
        all.clear();
        for (const Capsule* capsule : of_slice.capsules) all.emplace_back(signed_distance(*capsule, at), capsule);
        // Points farther than the closest void point have no effect.
        for (double around = nearest_reach; around < 2.0 * reach; around *= 2.0) {
            near.capsules.clear();
            near.whole.clear();
            for (const auto& [distance, capsule] : all)
                if (distance < around) near.capsules.push_back(capsule);
            for (const Grains::Image* image : of_slice.whole)
                if (((image->bounds.low - at).array() < around).all() && ((at - image->bounds.high).array() < around).all())
                    near.whole.push_back(image);
            std::optional<Vec2> found = from;
            if (config.dot_pixel_m > 0.0)
                found = closest_pixel(near, container, at, config.dot_pixel_m);
            else if (near.contains(at))
                found = closest_exit(RayExit(near, container, at), from);
            // Solid that was left out lies at least `around` away: it cannot cover a point found closer than that.
            if (found && (*found - from).norm() + 2.0 * config.dot_pixel_m < around) return found;
        }
        return std::nullopt;
    };
    return average(grid_of_dots(container, config), slices, section.z0_m, config.slice_spacing_m, config.largest_angle_deg, closest);
}

GeometricPaperResult geometric_paper_on_slices(const SliceStack& slices, const TortuosityConfig& config) {
    const Grid& grid = slices.grid;
    const auto pixel_of = [&](double value, int axis) {
        return static_cast<int>(
            std::floor((value - grid.origin_m[static_cast<std::size_t>(axis)]) / grid.spacing_m[static_cast<std::size_t>(axis)]));
    };
    const auto is_void = [&](int i, int j, int k) {
        return i >= 0 && j >= 0 && i < grid.cells[0] && j < grid.cells[1] && slices.phase[grid.index(i, j, k)] == Phase::pore;
    };
    const ClosestVoid closest = [&](const Vec2& from, int slice) -> std::optional<Vec2> {
        const int i0 = pixel_of(from.x(), 0), j0 = pixel_of(from.y(), 1);
        if (is_void(i0, j0, slice)) return from;
        double best = 1e300;
        Vec2 point = from;
        const int maximum = std::max(grid.cells[0], grid.cells[1]);
        const double pixel = grid.spacing_m[0];
        // Ring by ring; a ring at distance n has no point closer than (n - 1/2) pixels.
        for (int n = 1; n < maximum && (n - 0.5) * pixel < best; ++n)
            for (int j = j0 - n; j <= j0 + n; ++j)
                for (int i = i0 - n; i <= i0 + n; i += (j == j0 - n || j == j0 + n) ? 1 : 2 * n) {
                    if (!is_void(i, j, slice)) continue;
                    const Vec2 centre(grid.centre(0, i), grid.centre(1, j));
                    const double distance = (centre - from).norm();
                    if (distance < best) {
                        best = distance;
                        point = centre;
                    }
                }
        if (best >= 1e300) return std::nullopt;
        return point;
    };
    return average(grid_of_dots(slices.container, config), grid.cells[2], grid.centre(2, 0), grid.spacing_m[2], config.largest_angle_deg,
                   closest);
}

}  // namespace porepack::tortuosity
