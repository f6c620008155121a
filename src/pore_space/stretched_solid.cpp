#include "pore_space/stretched_solid.hpp"
#include "pore_space/uses.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace porepack::pore_space {
namespace {

class StretchedProbe : public SolidProbe {
public:
    StretchedProbe(std::unique_ptr<SolidProbe> inner, const Vec3& stretch) : inner_(std::move(inner)), shrink_(stretch.cwiseInverse()) {}
    void move_to(const Vec3& point, double reach) override { inner_->move_to(shrunk(point), reach * shrink_.maxCoeff()); }
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        return inner_->first_hit(shrunk(from), shrunk(step));
    }

private:
    [[nodiscard]] Vec3 shrunk(const Vec3& point) const { return point.cwiseProduct(shrink_); }

    std::unique_ptr<SolidProbe> inner_;
    Vec3 shrink_;
};

}  // namespace

std::optional<Stretch> stretch_to_cubes(const Grid& grid) {
    const auto& [dx, dy, dz] = grid.spacing_m;
    if (dx == dy && dy == dz) return std::nullopt;
    const double h = std::cbrt(dx * dy * dz);
    return Stretch{h / dx, h / dy, h / dz};
}

void stretch_grid(Grid& grid, const Stretch& stretch) {
    for (std::size_t a = 0; a < 3; ++a) {
        grid.spacing_m[a] *= stretch[a];
        grid.origin_m[a] *= stretch[a];
    }
}

double strain_of(const std::optional<Stretch>& stretch) {
    double largest = 0.0;
    if (stretch)
        for (const double factor : *stretch) largest = std::max(largest, std::abs(factor - 1.0));
    return largest;
}

StretchedSolid::StretchedSolid(std::shared_ptr<const Solid> inner, const Stretch& stretch)
    : inner_(std::move(inner)), stretch_(stretch.data()) {}

void StretchedSolid::lift(std::vector<Interval>& parts) const {
    for (Interval& part : parts) part = {part.low * stretch_.z(), part.high * stretch_.z()};
}

void StretchedSolid::column(double x, double y, std::vector<Interval>& parts) const {
    inner_->column(x / stretch_.x(), y / stretch_.y(), parts);
    lift(parts);
}

// A segment of this length is at most length / (smallest factor) long in the inner solid.
void StretchedSolid::near_column(double x, double y, double length, std::vector<Interval>& parts) const {
    inner_->near_column(x / stretch_.x(), y / stretch_.y(), length / stretch_.minCoeff(), parts);
    lift(parts);
}

Bounds StretchedSolid::bounds() const {
    const Bounds inner = inner_->bounds();
    return {inner.low.cwiseProduct(stretch_), inner.high.cwiseProduct(stretch_)};
}

std::unique_ptr<SolidProbe> StretchedSolid::probe() const {
    return std::make_unique<StretchedProbe>(inner_->probe(), stretch_);
}

}  // namespace porepack::pore_space
