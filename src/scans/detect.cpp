#include "scans/detect.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

#include "core/log.hpp"
#include "core/parallel.hpp"
#include "pores/pores.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

constexpr double expected_depth = 0.7;  ///< of an axis, in radii: voxels and rotations are finite

// What a candidate must reach.
struct Demands {
    double score, inside, surface;
    bool only_cut;  ///< grains that reach beyond the ends, by any of their ends as anchor
};

struct Candidate {
    double score;
    Vec3 anchor;
    Pose pose;
};

// The rotated points of the axes in voxels from the anchor, and the depth that each should have.
struct Pattern {
    struct Point {
        int i, j, k;
        float depth_m;
    };
    std::vector<Quaternion> rotations;
    std::vector<std::vector<Point>> of_rotation;
};

// The score of a pose is read from the distance map at the rotated axis points. Rounded to whole voxels once per rotation, these points
// serve every anchor voxel: the search itself neither rotates nor interpolates.
Pattern pattern_of(const ShapePoints& shape, const Vec3& anchor, double step_m, double h) {
    Pattern pattern{.rotations = rotations_of(shape, anchor, step_m), .of_rotation = {}};
    for (const Quaternion& q : pattern.rotations) {
        auto& points = pattern.of_rotation.emplace_back();
        for (const auto& [point, radius] : shape.axis) {
            const Vec3 at = q * (point - anchor) / h;
            points.push_back({static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())),
                              static_cast<int>(std::lround(at.z())), static_cast<float>(expected_depth * radius)});
        }
    }
    return pattern;
}

class Search {
public:
    Search(DistanceMap& map, const std::vector<ShapePoints>& shapes) : map_(map), shapes_(shapes), h_(map.grid.spacing_m[0]) {
        for (const ShapePoints& shape : shapes) of_middle_.push_back(pattern_of(shape, shape.anchor, 0.7 * shape.thinnest_radius_m, h_));
    }

    void pass(std::size_t shape, const Demands& demands) {
        const ShapePoints& points = shapes_[shape];
        const std::size_t before = found_.size();
        const Stopwatch watch;
        std::vector<Candidate> candidates;
        if (!demands.only_cut) add_candidates(points, points.anchor, points.anchor_depth_m, of_middle_[shape], demands, candidates);
        for (const Vec3& end : points.different_ends)
            if (demands.only_cut)
                add_candidates(points, end, points.thinnest_radius_m, pattern_of(points, end, 1.2 * points.thinnest_radius_m, h_), demands,
                               candidates);
        std::stable_sort(candidates.begin(), candidates.end(), [](const auto& one, const auto& other) { return one.score > other.score; });
        const double search_s = watch.seconds();
        take(shape, candidates, demands);
        log_info("grains: {} found ({} candidates with a score of {:.2f} or more{}; {} and {})", found_.size() - before, candidates.size(),
                 demands.score, demands.only_cut ? ", cut by the ends" : "", human_time(search_s), human_time(watch.seconds() - search_s));
    }
    std::vector<Found> found() { return std::move(found_); }

private:
    [[nodiscard]] double top() const { return map_.grid.origin_m[2] + map_.grid.cells[2] * h_; }
    [[nodiscard]] double bottom() const { return map_.grid.origin_m[2]; }

    // Anchors are tried on a coarser lattice of voxels, a fraction of the thinnest radius apart: the least-squares fit removes the rest of
    // the offset. Only voxels nearly as deep as the anchor are scored, and each keeps its best rotation alone. Layers run in parallel and
    // are joined in their order, so the candidates do not depend on the number of threads.
    void add_candidates(const ShapePoints& shape, const Vec3& anchor, double depth, const Pattern& pattern, const Demands& demands,
                        std::vector<Candidate>& candidates) const {
        const std::vector<Quaternion>& rotations = pattern.rotations;
        const Grid& grid = map_.grid;
        const int step = std::max(1, static_cast<int>(std::floor((demands.only_cut ? 0.5 : 0.25) * shape.thinnest_radius_m / h_)));
        // Less than the full depth: the voxel that is tried may lie beside the anchor, and the map knows the surface to about half a voxel.
        const auto needed = static_cast<float>(-0.75 * depth + 0.5 * h_);
        // A grain that the ends cut has its anchor within its own reach of one of them.
        const int near_end = static_cast<int>(std::ceil(shape.reach_m / h_));
        std::vector<std::vector<Candidate>> of_layer(static_cast<std::size_t>(grid.cells[2]));
        parallel_for(of_layer.size(), [&](std::size_t layer) {
            const int k = static_cast<int>(layer);
            if (k % step != 0 || (demands.only_cut && k > near_end && k < grid.cells[2] - 1 - near_end)) return;
            for (int j = 0; j < grid.cells[1]; j += step)
                for (int i = 0; i < grid.cells[0]; i += step) {
                    if (map_.distance_m[grid.index(i, j, k)] > needed) continue;
                    double best = demands.score;
                    std::size_t rotation = rotations.size();
                    for (std::size_t r = 0; r < rotations.size(); ++r)
                        if (const double value = score(pattern.of_rotation[r], i, j, k, best, demands.only_cut); value > best) {
                            best = value;
                            rotation = r;
                        }
                    if (rotation == rotations.size()) continue;
                    const Vec3 place(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
                    of_layer[layer].push_back({best, place, {place - rotations[rotation] * anchor, rotations[rotation]}});
                }
        });
        for (auto& layer : of_layer) std::move(layer.begin(), layer.end(), std::back_inserter(candidates));
    }

    // Mean of depth over expected depth along the axes, cut at 1; ends as soon as it cannot exceed `best`. Points beyond the first and the
    // last layer do not count, up to half of them.
    [[nodiscard]] double score(const std::vector<Pattern::Point>& points, int i, int j, int k, double best, bool may_be_cut,
                               bool may_be_whole = false) const {
        const Grid& grid = map_.grid;
        const auto count = static_cast<double>(points.size());
        double loss = 0.0, beyond = 0.0;
        const double allowed = (1.0 - best) * count;
        for (const auto& point : points) {
            const int x = i + point.i, y = j + point.j, z = k + point.k;
            if (z < 0 || z >= grid.cells[2]) {
                if (!may_be_cut || (beyond += 1.0) > 0.6 * count) return 0.0;
                continue;
            }
            const bool outside = x < 0 || x >= grid.cells[0] || y < 0 || y >= grid.cells[1];
            const float depth = outside ? -1.0F : -map_.distance_m[grid.index(x, y, z)];
            // A point in a pore costs twice as much as one at the surface: an axis must not leave the solid. Axis points are stored with
            // the farthest from the anchor first, so wrong rotations exceed the allowed loss after few points.
            loss += depth <= 0.0F ? 2.0 : std::max(0.0, 1.0 - static_cast<double>(depth / point.depth_m));
            if (loss > allowed) return 0.0;
        }
        if (may_be_cut && !may_be_whole && beyond == 0.0) return 0.0;
        return 1.0 - loss / (count - beyond);
    }

    [[nodiscard]] bool is_taken(const Vec3& anchor, double radius) const {
        return std::any_of(found_.begin(), found_.end(), [&](const Found& found) {
            const ShapePoints& shape = shapes_[found.shape];
            if ((anchor - found.pose.position_m).norm() > shape.reach_m) return false;
            return signed_distance(placed(shape.capsules, found.pose), anchor) < -0.3 * radius;
        });
    }

    // Axes that lie deep in another grain.
    [[nodiscard]] bool clashes(std::size_t shape, const std::vector<Capsule>& capsules, const Pose& pose) const {
        const auto deep = [](const ShapePoints& points, const Pose& at, const std::vector<Capsule>& other) {
            return std::any_of(points.axis.begin(), points.axis.end(), [&](const auto& point) {
                return signed_distance(other, at.position_m + at.orientation * point.point) < -0.35 * point.radius_m;
            });
        };
        return std::any_of(found_.begin(), found_.end(), [&](const Found& found) {
            const ShapePoints& other = shapes_[found.shape];
            if ((pose.position_m - found.pose.position_m).norm() > shapes_[shape].reach_m + other.reach_m) return false;
            return deep(shapes_[shape], pose, placed(other.capsules, found.pose)) || deep(other, found.pose, capsules);
        });
    }

    // A pose is judged by two shares. `on_surface` compares the outline; `solid_inside` also tests the interior, where an axis point weighs
    // as much as four surface points. Points beyond the first and the last layer are unknown and are left out of both.
    [[nodiscard]] Found judged(std::size_t shape, const Pose& pose) const {
        const ShapePoints& points = shapes_[shape];
        Found found{.shape = shape, .pose = pose};
        long shown = 0, solid = 0, surface = 0, on = 0;
        // Not below about one voxel: the map resolves the surface no finer.
        const double near = std::max(0.35 * points.thinnest_radius_m, 1.2 * h_);
        for (const Vec3& point : points.surface) {
            const Vec3 at = pose.position_m + pose.orientation * point;
            if (at.z() < bottom() || at.z() > top()) {
                found.cut = true;
                continue;
            }
            ++surface;
            const double distance = map_.at(at);
            if (std::abs(distance) < near) ++on;
            ++shown;
            if (distance < 0.3 * points.thinnest_radius_m) ++solid;
        }
        for (const auto& point : points.axis) {
            const Vec3 at = pose.position_m + pose.orientation * point.point;
            if (at.z() < bottom() || at.z() > top()) continue;
            shown += 4;
            if (map_.at(at) < -0.5 * point.radius_m) solid += 4;
        }
        if (shown > 0) found.solid_inside = static_cast<double>(solid) / static_cast<double>(shown);
        if (surface > 0) found.on_surface = static_cast<double>(on) / static_cast<double>(surface);
        if (found.cut && 4 * surface < static_cast<long>(points.surface.size())) found.on_surface = 0.0;  // hardly anything of it is shown
        return found;
    }

    // Other rotations about the same place that score nearly as well: a grain with arms of similar lengths may have been taken the wrong
    // way round.
    [[nodiscard]] Pose best_rotation(const ShapePoints& shape, const Pattern& pattern, const Pose& pose, double cost) const {
        const std::vector<Quaternion>& rotations = pattern.rotations;
        const Vec3 place = pose.position_m + pose.orientation * shape.anchor;
        std::array<int, 3> cell{};
        for (std::size_t a = 0; a < 3; ++a)
            cell[a] = static_cast<int>(std::floor((place[static_cast<Eigen::Index>(a)] - map_.grid.origin_m[a]) / h_));
        std::vector<std::pair<double, std::size_t>> scores;
        for (std::size_t r = 0; r < rotations.size(); ++r)
            if (const double value = score(pattern.of_rotation[r], cell[0], cell[1], cell[2], 0.6, true, true); value > 0.0)
                scores.emplace_back(value, r);
        std::sort(scores.begin(), scores.end(), std::greater<>());
        Pose best = pose;
        std::vector<Quaternion> tried = {pose.orientation};
        constexpr std::size_t maximum = 8;
        const double alike = std::cos(0.25);  // half of an angle of rotation
        for (const auto& [value, r] : scores) {
            if (std::any_of(tried.begin(), tried.end(), [&](const Quaternion& known) { return std::abs(known.dot(rotations[r])) > alike; }))
                continue;
            tried.push_back(rotations[r]);
            Pose other{place - rotations[r] * shape.anchor, rotations[r]};
            if (const double other_cost = fit_to_surface(map_, shape, other); other_cost < cost) {
                cost = other_cost;
                best = other;
            }
            if (tried.size() > maximum) break;
        }
        return best;
    }

    // The best candidates in batches, whose anchors are apart; each batch in parallel, then one by one.
    void take(std::size_t shape, const std::vector<Candidate>& candidates, const Demands& demands) {
        const ShapePoints& points = shapes_[shape];
        // The fits within a batch run in parallel, so they must not depend on each other: their anchors are apart, and no two start from
        // nearly the same pose. Only after its fits does the batch accept grains, the best first, so that of two that clash the better one
        // stays.
        constexpr std::size_t batch_size = 64;
        std::vector<std::uint8_t> done(candidates.size(), 0);
        std::vector<std::vector<Capsule>> tried;
        while (true) {
            std::vector<std::size_t> batch;
            for (std::size_t c = 0; c < candidates.size() && batch.size() < batch_size; ++c) {
                if (done[c] != 0) continue;
                const Candidate& candidate = candidates[c];
                if (std::any_of(batch.begin(), batch.end(), [&](std::size_t other) {
                        return (candidates[other].anchor - candidate.anchor).norm() < points.thinnest_radius_m;
                    }))
                    continue;
                done[c] = 1;
                if (is_taken(candidate.anchor, points.thinnest_radius_m)) continue;
                const std::vector<Capsule> capsules = placed(points.capsules, candidate.pose);
                if (std::any_of(tried.begin(), tried.end(), [&](const auto& other) {
                        return (other[0].a - capsules[0].a).norm() < 4.0 * points.reach_m &&
                               largest_difference_m(other, capsules) < 0.8 * points.thinnest_radius_m;
                    }))
                    continue;
                tried.push_back(capsules);
                batch.push_back(c);
            }
            if (batch.empty()) break;
            std::vector<Found> fitted(batch.size());
            parallel_for(batch.size(), [&](std::size_t b) {
                Pose pose = candidates[batch[b]].pose;
                const double cost = fit_to_surface(map_, points, pose);
                fitted[b] = judged(shape, pose);
                // A first, weaker test: other rotations are fitted only for poses that may still reach the demands.
                if (fitted[b].solid_inside < 0.8 * demands.inside || fitted[b].on_surface < 0.8 * demands.surface) return;
                fitted[b] = judged(shape, best_rotation(points, of_middle_[shape], pose, cost));
            });
            std::stable_sort(fitted.begin(), fitted.end(), [](const Found& one, const Found& other) {
                return one.on_surface + one.solid_inside > other.on_surface + other.solid_inside;
            });
            for (const Found& one : fitted) {
                if (one.solid_inside < demands.inside || one.on_surface < demands.surface) continue;
                const std::vector<Capsule> capsules = placed(points.capsules, one.pose);
                if (!clashes(shape, capsules, one.pose)) found_.push_back(one);
            }
        }
        // The map changes only here, at the end of a pass: until then is_taken() and clashes() keep grains apart.
        for (const Found& one : found_)
            if (one.shape == shape) mask(placed(points.capsules, one.pose), points.thinnest_radius_m);
    }

    // Any positive distance makes a voxel a pore for later candidates. The distances around it are not computed again.
    void mask(const std::vector<Capsule>& capsules, double radius) {
        Bounds bounds;
        for (const Capsule& capsule : capsules) add(bounds, capsule);
        const Grid& grid = map_.grid;
        std::array<int, 3> low{}, high{};
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            low[a] = std::max(0, static_cast<int>(std::floor((bounds.low[axis] - grid.origin_m[a]) / h_)));
            high[a] = std::min(grid.cells[a], static_cast<int>(std::ceil((bounds.high[axis] - grid.origin_m[a]) / h_)));
        }
        for (int k = low[2]; k < high[2]; ++k)
            for (int j = low[1]; j < high[1]; ++j)
                for (int i = low[0]; i < high[0]; ++i) {
                    float& distance = map_.distance_m[grid.index(i, j, k)];
                    if (distance < 0.0F &&
                        signed_distance(capsules, Vec3(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k))) < 0.25 * h_)
                        distance = static_cast<float>(0.3 * radius);
                }
    }

    DistanceMap& map_;
    const std::vector<ShapePoints>& shapes_;
    const double h_;
    std::vector<Pattern> of_middle_;  ///< of each shape, about its anchor
    std::vector<Found> found_;
};

}  // namespace

std::vector<Found> detect(DistanceMap& map, const std::vector<ShapePoints>& shapes) {
    std::vector<std::size_t> order(shapes.size());
    for (std::size_t s = 0; s < order.size(); ++s) order[s] = s;
    std::sort(order.begin(), order.end(),
              [&](std::size_t one, std::size_t other) { return shapes[one].volume_m3 > shapes[other].volume_m3; });
    Search search(map, shapes);
    // All passes of a larger shape before a smaller one, which might lie in an arm of a larger grain that is not found yet.
    // Falling demands: clear grains are found and masked first, so that fewer wrong candidates remain for the weaker demands.
    for (const std::size_t shape : order)
        for (const Demands& demands : {Demands{0.92, 0.95, 0.75, false}, Demands{0.84, 0.92, 0.7, false}, Demands{0.75, 0.9, 0.65, false}})
            search.pass(shape, demands);
    for (const std::size_t shape : order) search.pass(shape, {0.8, 0.93, 0.7, true});
    return search.found();
}

}  // namespace porepack::scans
