#include "scans/refine.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/log.hpp"
#include "core/parallel.hpp"
#include "scans/capsule_surface.hpp"
#include "scans/fitted_model.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

constexpr double band_deviations = 3.0;
constexpr double gross = 0.25;  ///< larger residuals count less: something else is there

// One voxel near a grain's surface.
struct Voxel {
    std::array<int, 3> cell;
    Vec3 centre;
    double value;
    Surface surface;
    double others;  ///< solid fraction of other grains
};

class Fit {
public:
    Fit(const GrayImage& image, const vessels::Container& container, const std::vector<ShapePoints>& shapes, Refined& found,
        std::size_t moving)
        : image_(image), container_(container), shapes_(shapes), found_(found), moving_(moving), h_(image.grid.spacing_m[0]) {}

    [[nodiscard]] std::vector<Capsule> capsules_of(const FittedGrain& grain, const Pose& pose) const {
        const Common::OfShape& sizes = found_.common.shapes[grain.shape];
        return placed(resized(shapes_[grain.shape].capsules, sizes.radius_change_m.value, sizes.length_factor.value), pose);
    }
    [[nodiscard]] std::vector<Capsule> capsules_of(const FittedGrain& grain) const { return capsules_of(grain, grain.pose); }

    // Other grains that come near.
    [[nodiscard]] std::vector<std::vector<Capsule>> neighbours_of(std::size_t g) const {
        const FittedGrain& grain = found_.grains[g];
        const std::vector<Capsule> own = capsules_of(grain);
        std::vector<std::vector<Capsule>> near;
        for (std::size_t other = 0; other < found_.grains.size(); ++other) {
            const FittedGrain& candidate = found_.grains[other];
            if (other == g || (candidate.pose.position_m - grain.pose.position_m).norm() >
                                  1.1 * (shapes_[grain.shape].reach_m + shapes_[candidate.shape].reach_m) + 2.0 * band())
                continue;
            const std::vector<Capsule> capsules = capsules_of(candidate);
            const bool close = std::any_of(own.begin(), own.end(), [&](const Capsule& one) {
                return std::any_of(capsules.begin(), capsules.end(), [&](const Capsule& two) { return gap(one, two) < 2.0 * band(); });
            });
            if (close) near.push_back(capsules);
        }
        return near;
    }

    // Of the grain's capsules, this one is nearest. Not in creases, where another one is as near: blur fills them.
    [[nodiscard]] bool is_nearest(const std::vector<Capsule>& own, std::size_t c, const Vec3& x, const Surface& surface) const {
        for (std::size_t o = 0; o < own.size(); ++o) {
            if (o == c) continue;
            const Surface other = surface_of(own[o], x);
            const double farther = other.distance - surface.distance;
            // Of two capsules at the same distance the first counts, so that a voxel is visited once.
            if (farther < (o < c ? 1e-12 : 0.0)) return false;
            // A crease only where the axis points are apart: at a joint both capsules have the same one.
            if (farther < 1.5 * found_.common.blur_m.value && (other.axis_point - surface.axis_point).norm() > 0.5 * own[c].radius)
                return false;
        }
        return true;
    }

    // visit(Voxel) for the voxels within the band around the grain's surface, every `stride`th along each axis.
    template <typename Visit>
    void for_voxels(const std::vector<Capsule>& own, const std::vector<std::vector<Capsule>>& others, int stride,
                    const Visit& visit) const {
        const Grid& grid = image_.grid;
        const double reach = band();
        for (std::size_t c = 0; c < own.size(); ++c) {
            std::array<int, 3> low{}, high{};
            for (std::size_t a = 0; a < 3; ++a) {
                const auto axis = static_cast<Eigen::Index>(a);
                const double r = own[c].radius + reach, from = std::min(own[c].a[axis], own[c].b[axis]) - r,
                             to = std::max(own[c].a[axis], own[c].b[axis]) + r;
                low[a] = std::max(0, static_cast<int>(std::ceil((from - grid.origin_m[a]) / h_ - 0.5)));
                high[a] = std::min(grid.cells[a] - 1, static_cast<int>(std::floor((to - grid.origin_m[a]) / h_ - 0.5)));
                // Multiples of the stride in the image, whatever the pose: trial poses are compared on the same voxels.
                low[a] += (stride - low[a] % stride) % stride;
            }
            std::vector<const std::vector<Capsule>*> near;
            for (const auto& other : others)
                if (std::any_of(other.begin(), other.end(), [&](const Capsule& one) { return gap(one, own[c]) < 2.0 * reach; }))
                    near.push_back(&other);
            for (int k = low[2]; k <= high[2]; k += stride)
                for (int j = low[1]; j <= high[1]; j += stride)
                    for (int i = low[0]; i <= high[0]; i += stride) {
                        const Vec3 x(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
                        const Surface surface = surface_of(own[c], x);
                        if (std::abs(surface.distance) > reach) continue;
                        if (!is_nearest(own, c, x, surface) || !container_.contains_column(x.x(), x.y())) continue;
                        double sum = 0.0;
                        for (const auto* other : near) {
                            Surface closest;
                            for (const Capsule& capsule : *other)
                                if (const Surface one = surface_of(capsule, x); one.distance < closest.distance) closest = one;
                            sum += fraction(closest);
                        }
                        visit(Voxel{{i, j, k}, x, image_.at(grid.index(i, j, k)), surface, sum});
                    }
        }
    }

    [[nodiscard]] double band() const { return band_deviations * found_.common.blur_m.value; }
    [[nodiscard]] double argument(const Surface& surface) const {
        const double blur = found_.common.blur_m.value;
        return -surface.distance / blur - blur * surface.curvature;
    }
    [[nodiscard]] double fraction(const Surface& surface) const {
        return surface.distance > 2.0 * band() ? 0.0 : inside_of_edge(argument(surface));
    }
    // d fraction / d argument
    [[nodiscard]] double density(const Surface& surface) const {
        const double z = argument(surface);
        return std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
    }
    [[nodiscard]] int stride_for(const FittedGrain& grain) const {
        return std::max(1, static_cast<int>(shapes_[grain.shape].thinnest_radius_m / (8.0 * h_)));
    }

    // Normal equations of one grain's pose; returns the mean square.
    // The model of a voxel is the gray level of the grain's own blurred edge plus the solid fractions of its neighbours, limited to 1. Its
    // derivative by the pose is that of the edge alone: contrast x normal density / blur, times the outward motion of the surface. Where
    // the sum is limited, the voxel does not depend on the pose and adds only to the cost.
    double pose_sums(const FittedGrain& grain, const Pose& pose, const std::vector<std::vector<Capsule>>& others, StepMatrix* H, Step* g,
                     std::unordered_map<std::uint64_t, Step>* blocks = nullptr) const {
        const double contrast = found_.common.solid.value - found_.common.pores.value, blur = found_.common.blur_m.value;
        double cost = 0.0;
        long count = 0;
        for_voxels(capsules_of(grain, pose), others, stride_for(grain), [&](const Voxel& voxel) {
            const double own = fraction(voxel.surface), sum = own + voxel.others;
            const double residual = found_.common.pores.value + contrast * std::min(1.0, sum) - voxel.value, size = std::abs(residual);
            cost += size > gross ? gross * (2.0 * size - gross) : size * size;
            ++count;
            if (H == nullptr || sum > 1.0) return;
            const double weight = size > gross ? gross / size : 1.0;
            // The surface moves outward by n . (translation + rotation x lever).
            const double slope = contrast * density(voxel.surface) / blur;
            Step J;
            J << slope * voxel.surface.normal, slope * (voxel.centre - pose.position_m).cross(voxel.surface.normal);
            *H += weight * J * J.transpose();
            *g += weight * residual * J;
            if (blocks != nullptr) {
                // 21 bits per axis. Residuals of neighbouring voxels are correlated; the sums over blocks are taken as independent.
                const int block = std::max(4, static_cast<int>(2.0 * shapes_[grain.shape].thinnest_radius_m / h_));
                const auto key = static_cast<std::uint64_t>(voxel.cell[0] / block) << 42U |
                                 static_cast<std::uint64_t>(voxel.cell[1] / block) << 21U |
                                 static_cast<std::uint64_t>(voxel.cell[2] / block);
                blocks->try_emplace(key, Step::Zero()).first->second += weight * residual * J;
            }
        });
        return count > 0 ? cost / static_cast<double>(count) : 1e300;
    }

    // Levenberg-Marquardt in translation and rotation. Steps as long as the thinnest diameter, and steps that are not finite, are refused
    // without an evaluation: the linear model does not hold so far from the surface.
    void fit_pose(std::size_t g, Pose& pose) const {
        const FittedGrain& grain = found_.grains[g];
        const auto others = neighbours_of(g);
        const double r = shapes_[grain.shape].thinnest_radius_m;
        double damping = 1e-3, cost = pose_sums(grain, pose, others, nullptr, nullptr);
        for (int iteration = 0; iteration < 10; ++iteration) {
            StepMatrix H = StepMatrix::Zero();
            Step gradient = Step::Zero();
            (void)pose_sums(grain, pose, others, &H, &gradient);
            bool better = false;
            double largest = 0.0;
            for (int trial = 0; trial < 5 && !better; ++trial) {
                StepMatrix A = H;
                const double floor = 1e-9 * H.diagonal().head<3>().maxCoeff() + 1e-300;
                for (int d = 0; d < 6; ++d) A(d, d) += damping * H(d, d) + floor * (d < 3 ? 1.0 : r * r);
                const Step step = -A.ldlt().solve(gradient);
                largest = std::max(step.head<3>().norm(), step.tail<3>().norm() * shapes_[grain.shape].reach_m);
                if (!(largest < 2.0 * r)) {
                    damping = 10.0 * damping + 1e-3;
                    continue;
                }
                const Pose next = moved_by(pose, step);
                if (const double trial_cost = pose_sums(grain, next, others, nullptr, nullptr); trial_cost < cost) {
                    better = true;
                    cost = trial_cost;
                    pose = next;
                    damping = std::max(1e-6, 0.2 * damping);
                } else {
                    damping = 10.0 * damping + 1e-3;
                }
            }
            if (!better || largest < 1e-4 * h_) return;
        }
    }

    // All grains at once: each sees its neighbours where the sweep before has left them.
    void sweep() {
        std::vector<Pose> poses(moving_);
        parallel_for(poses.size(), [&](std::size_t g) {
            poses[g] = found_.grains[g].pose;
            fit_pose(g, poses[g]);
        });
        for (std::size_t g = 0; g < poses.size(); ++g) found_.grains[g].pose = poses[g];
    }

    // Gray levels, blur, radii and lengths, from voxels that other grains do not reach.
    // Gauss-Newton over all common parameters at once, with limited steps. The grains are the independent samples: the covariance is H^-1
    // (sum of g g^T over grains) H^-1, so that errors shared by the voxels of a grain enter with their full weight. A selection of about
    // 120 grains, evenly spread over the list, bounds the cost.
    void fit_common() {
        const std::size_t unknowns = 3 + 2 * shapes_.size();
        const auto n = static_cast<Eigen::Index>(unknowns);
        constexpr std::size_t maximum = 120;
        const std::size_t every = 1 + moving_ / maximum;
        std::vector<std::size_t> chosen;
        for (std::size_t g = 0; g < moving_; g += every)
            if (!found_.grains[g].cut) chosen.push_back(g);
        if (chosen.empty())
            for (std::size_t g = 0; g < moving_; ++g) chosen.push_back(g);
        Eigen::MatrixXd H(n, n), scatter(n, n);
        for (int iteration = 0; iteration < 8; ++iteration) {
            // Summed below in the order of the grains: the result does not depend on the threads.
            std::vector<Eigen::MatrixXd> parts(chosen.size(), Eigen::MatrixXd::Zero(n, n));
            std::vector<Eigen::VectorXd> gradients(chosen.size(), Eigen::VectorXd::Zero(n));
            parallel_for(chosen.size(), [&](std::size_t at) { common_sums(chosen[at], parts[at], gradients[at]); });
            H.setZero();
            scatter.setZero();
            Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
            for (std::size_t at = 0; at < chosen.size(); ++at) {
                H += parts[at];
                gradient += gradients[at];
                scatter += gradients[at] * gradients[at].transpose();
            }
            for (Eigen::Index d = 0; d < n; ++d)
                if (H(d, d) <= 0.0) H(d, d) = 1.0;  // a shape without grains
            Eigen::VectorXd step = -H.ldlt().solve(gradient);
            Common& common = found_.common;
            step[2] = std::clamp(step[2], -0.3 * common.blur_m.value, 0.3 * common.blur_m.value);
            common.pores.value += step[0];
            common.solid.value += step[1];
            common.blur_m.value += step[2];
            double largest = std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2]) / h_});
            for (std::size_t s = 0; s < shapes_.size(); ++s) {
                const auto d = static_cast<Eigen::Index>(3 + 2 * s);
                const double r = shapes_[s].thinnest_radius_m;
                common.shapes[s].radius_change_m.value += std::clamp(step[d], -0.1 * r, 0.1 * r);
                common.shapes[s].length_factor.value += std::clamp(step[d + 1], -0.05, 0.05);
                largest = std::max({largest, std::abs(step[d]) / h_, std::abs(step[d + 1])});
            }
            if (largest < 1e-5) break;
        }
        const Eigen::MatrixXd inverse = H.completeOrthogonalDecomposition().pseudoInverse();
        const Eigen::MatrixXd covariance = inverse * scatter * inverse;
        const auto error = [&](std::size_t d) {
            return std::sqrt(std::max(0.0, covariance(static_cast<Eigen::Index>(d), static_cast<Eigen::Index>(d))));
        };
        found_.common.pores.uncertainty = error(0);
        found_.common.solid.uncertainty = error(1);
        found_.common.blur_m.uncertainty = error(2);
        for (std::size_t s = 0; s < shapes_.size(); ++s) {
            found_.common.shapes[s].radius_change_m.uncertainty = error(3 + 2 * s);
            found_.common.shapes[s].length_factor.uncertainty = error(4 + 2 * s);
        }
    }

    // Of one grain, with its pose eliminated (Schur complement): lengths and radii move poses, too.
    // The unknowns are ordered as gray level of the pores, of the solid, blur, then radius change and length factor of each shape. The rows
    // follow from the edge model: a larger radius moves the surface along its normal, a longer axis moves each axis point away from the
    // position in proportion to its distance.
    void common_sums(std::size_t g, Eigen::MatrixXd& H, Eigen::VectorXd& gradient) const {
        const FittedGrain& grain = found_.grains[g];
        const double contrast = found_.common.solid.value - found_.common.pores.value, blur = found_.common.blur_m.value;
        const Eigen::Index n = H.rows();
        const auto first = static_cast<Eigen::Index>(3 + 2 * grain.shape);
        const double factor = found_.common.shapes[grain.shape].length_factor.value, reach = shapes_[grain.shape].reach_m;
        Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n + 6, n + 6);
        Eigen::VectorXd sums = Eigen::VectorXd::Zero(n + 6), J(n + 6);
        for_voxels(capsules_of(grain), neighbours_of(g), stride_for(grain), [&](const Voxel& voxel) {
            if (voxel.others > 0.01) return;
            const double own = fraction(voxel.surface), slope = contrast * density(voxel.surface);
            const double residual = found_.common.pores.value + contrast * own - voxel.value;
            if (std::abs(residual) > gross) return;
            const Vec3 lever = (voxel.surface.axis_point - grain.pose.position_m) / factor;
            J.setZero();
            J[0] = 1.0 - own;
            J[1] = own;
            J[2] = slope * (voxel.surface.distance / (blur * blur) - voxel.surface.curvature);
            J[first] = slope / blur;
            J[first + 1] = slope / blur * voxel.surface.normal.dot(lever);
            J.segment<3>(n) = slope / blur * voxel.surface.normal;
            // Rotations in units of the displacement at the grain's reach: the eigenvalues below are then comparable with those of
            // translations.
            J.segment<3>(n + 3) = slope / blur / reach * (voxel.centre - grain.pose.position_m).cross(voxel.surface.normal);
            all += J * J.transpose();
            sums += residual * J;
        });
        // Pseudo-inverse of the pose's block: a rotation about an axis of symmetry has no eigenvalue to divide by.
        Eigen::SelfAdjointEigenSolver<StepMatrix> solver(StepMatrix(all.bottomRightCorner<6, 6>()));
        Step inverse = Step::Zero();
        for (int d = 0; d < 6; ++d)
            if (solver.eigenvalues()[d] > 1e-6 * solver.eigenvalues()[5]) inverse[d] = 1.0 / solver.eigenvalues()[d];
        const Eigen::MatrixXd gain =
            all.topRightCorner(n, 6) * solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
        H = all.topLeftCorner(n, n) - gain * all.bottomLeftCorner(6, n);
        gradient = sums.head(n) - gain * sums.tail(6);
    }

    // The last step: residual and uncertainty of each grain.
    // Sandwich estimate per grain: H^-1 (sum over blocks of s s^T) H^-1, with s the sum of a block's weighted gradients. The uncertainty of
    // an end follows from the covariance of translation and rotation through its displacement t + w x lever.
    void judge() {
        std::vector<double> squares(moving_);
        parallel_for(moving_, [&](std::size_t g) {
            FittedGrain& grain = found_.grains[g];
            StepMatrix H = StepMatrix::Zero();
            Step gradient = Step::Zero();
            std::unordered_map<std::uint64_t, Step> blocks;
            squares[g] = pose_sums(grain, grain.pose, neighbours_of(g), &H, &gradient, &blocks);
            grain.residual = std::sqrt(squares[g]);
            StepMatrix scatter = StepMatrix::Zero();
            for (const auto& [key, sum] : blocks) scatter += sum * sum.transpose();
            // Rotations about an axis of symmetry change nothing and count as known.
            StepMatrix scaled = H;
            const double r = shapes_[grain.shape].reach_m;
            Step unit;
            unit << 1.0, 1.0, 1.0, 1.0 / r, 1.0 / r, 1.0 / r;
            scaled = unit.asDiagonal() * H * unit.asDiagonal();
            const Eigen::SelfAdjointEigenSolver<StepMatrix> solver(scaled);
            Step inverse = Step::Zero();
            for (int d = 0; d < 6; ++d)
                if (solver.eigenvalues()[d] > 1e-6 * solver.eigenvalues()[5]) inverse[d] = 1.0 / solver.eigenvalues()[d];
            const StepMatrix pseudo =
                unit.asDiagonal() * (solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose()) * unit.asDiagonal();
            const StepMatrix covariance = pseudo * scatter * pseudo;
            grain.position_error_m = std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace()));
            grain.end_error_m = 0.0;
            for (const Vec3& end : shapes_[grain.shape].ends) {
                const Vec3 lever = grain.pose.orientation * end;
                Eigen::Matrix<double, 3, 6> J;
                J << Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero();
                for (int a = 0; a < 3; ++a) J.block<3, 1>(0, 3 + a) = Vec3::Unit(a).cross(lever);
                grain.end_error_m = std::max(grain.end_error_m, std::sqrt(std::max(0.0, (J * covariance * J.transpose()).trace())));
            }
        });
        double sum = 0.0;
        for (const double square : squares) sum += square / static_cast<double>(squares.size());
        found_.residual = std::sqrt(sum);
    }

private:
    const GrayImage& image_;
    const vessels::Container& container_;
    const std::vector<ShapePoints>& shapes_;
    Refined& found_;
    const std::size_t moving_;
    const double h_;
};

}  // namespace

Refined refine(const GrayImage& image, const vessels::Container& container, const std::vector<ShapePoints>& shapes,
               std::vector<FittedGrain> grains, Common start, std::size_t moving) {
    Refined found{.grains = std::move(grains), .common = std::move(start), .residual = 0.0};
    found.common.shapes.resize(shapes.size());
    // The edge model divides by the blur.
    found.common.blur_m.value = std::max(found.common.blur_m.value, 0.3 * image.grid.spacing_m[0]);
    moving = std::min(moving, found.grains.size());
    if (moving == 0) return found;
    Fit fit(image, container, shapes, found, moving);
    constexpr int sweeps = 3;
    Progress progress("poses");
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        fit.sweep();
        fit.fit_common();
        progress.update((sweep + 1.0) / (sweeps + 1.0));
    }
    fit.sweep();
    fit.judge();
    return found;
}

}  // namespace porepack::scans
