#include "vessels/container.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "vessels/box.hpp"
#include "vessels/cylinder.hpp"

namespace porepack::vessels {

Container::Container(std::shared_ptr<const Vessel> vessel, bool cut_ends)
    : vessel_(std::move(vessel)), periodic_(vessel_->periodic()), cut_ends_(cut_ends) {
    const Bounds bounds = vessel_->bounds();
    low_ = bounds.low;
    high_ = bounds.high;
    size_ = high_ - low_;
    for (int axis = 0; axis < 3; ++axis)
        if ((axis == 2 || vessel_->fills_bounds() || periodic_[static_cast<std::size_t>(axis)]) && low_[axis] != 0.0)
            throw std::logic_error("the floor of a vessel, and periodic sides, begin at 0");
}

const Vessel& Container::vessel() const {
    if (vessel_ == nullptr) throw std::logic_error("a container without a vessel");
    return *vessel_;
}

Container::WidestPlace Container::widest_place(double z) const {
    constexpr int steps = 100;
    WidestPlace place{.at = 0.5 * (low_ + high_), .width_m = 0.0};
    place.at.z() = z;
    place.width_m = 2.0 * wall_distance(place.at);
    for (int j = 0; j <= steps; ++j)
        for (int i = 0; i <= steps; ++i) {
            const Vec3 at(low_.x() + size_.x() * i / steps, low_.y() + size_.y() * j / steps, place.at.z());
            if (const double width = 2.0 * wall_distance(at); width > (1.0 + 1e-9) * place.width_m) place = {at, width};
        }
    for (int axis = 0; axis < 2; ++axis)
        if (periodic_[static_cast<std::size_t>(axis)]) place.width_m = std::min(place.width_m, size_[axis]);
    return place;
}

bool Container::contains_column(double x, double y) const {
    thread_local std::vector<Interval> parts;
    vessel().column(x, y, parts);
    return !parts.empty();
}

Container Container::resized(const Vec3& size_m) const {
    auto other = vessel().resized(size_m);
    if (other == nullptr)
        throw UserError(fmt::format("this vessel cannot be {:g} x {:g} x {:g} m: {}", size_m.x(), size_m.y(), size_m.z(), text_of(*this)));
    return Container(std::move(other), cut_ends_);
}

Container make_cylinder(double diameter_m, double height_m) {
    return Container(std::make_shared<const Cylinder>(diameter_m, height_m));
}

Container make_box(const Vec3& size_m, const std::array<bool, 3>& periodic) {
    return Container(std::make_shared<const Box>(size_m, periodic));
}

void require_prism(const Container& container, const std::string& what) {
    if (container.vessel().outlines(container.size().norm()).empty())
        throw UserError(what + " needs a vessel whose cross-section is the same at all heights", {.where = text_of(container)});
}

Json to_json(const Container& container) {
    Json json = container.vessel().to_json();
    if (container.cut_ends()) json["ends"] = "cut";
    return json;
}

std::string text_of(const Container& container) {
    Json json = to_json(container);
    for (auto& [key, value] : json.items())
        if (value.is_array() && value.size() > 3) value = value.size();
    return json.dump();
}

}  // namespace porepack::vessels
