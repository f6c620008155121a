// The vessel that holds a packing, and whether the bed ends with it.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "core/json_fwd.hpp"
#include "geometry/vessel.hpp"

namespace porepack::vessels {

/// Copies share the vessel, which is never changed. Bounds and periodic sides are kept, because loops over grains ask for them.
class Container {
public:
    /// Without a vessel, to be filled in: bounds of size 0.
    Container() = default;
    explicit Container(std::shared_ptr<const geometry::Vessel> vessel, bool cut_ends = false);

    /// Throws std::logic_error where there is none yet.
    [[nodiscard]] const geometry::Vessel& vessel() const;
    /// Lowest and highest corner of the inner space.
    [[nodiscard]] const geometry::Vec3& low() const { return low_; }
    [[nodiscard]] const geometry::Vec3& high() const { return high_; }
    [[nodiscard]] const geometry::Vec3& size() const { return size_; }
    [[nodiscard]] double height() const { return size_.z(); }
    [[nodiscard]] const std::array<bool, 3>& periodic() const { return periodic_; }
    [[nodiscard]] bool any_periodic() const { return periodic_[0] || periodic_[1] || periodic_[2]; }
    /// The bed goes on below the floor and above the top, as in a scan of a part: grains may reach through both.
    [[nodiscard]] bool cut_ends() const { return cut_ends_; }

    /// Mean from the floor to the top.
    [[nodiscard]] double inner_area_m2() const { return vessel().mean_area({low_.z(), high_.z()}); }
    [[nodiscard]] double wall_distance(const geometry::Vec3& point) const { return vessel().distance(point); }
    [[nodiscard]] std::optional<double> tube_diameter() const { return vessel().tube_diameter(); }
    /// Where the largest sphere between the sides fits at half height (the middle, where that is as wide as any other place; elsewhere
    /// within 2 % of the width), and its diameter, which is not above a periodic side.
    struct WidestPlace {
        geometry::Vec3 at;
        double width_m;
    };
    [[nodiscard]] WidestPlace widest_place() const { return widest_place(0.5 * (low_.z() + high_.z())); }
    /// At another height.
    [[nodiscard]] WidestPlace widest_place(double z) const;
    /// A point of the vertical line at (x, y) lies inside.
    [[nodiscard]] bool contains_column(double x, double y) const;

    /// With a bed that goes on beyond floor and top.
    [[nodiscard]] Container with_cut_ends() const { return Container(vessel_, true); }
    /// Throws UserError where the vessel cannot have this size.
    [[nodiscard]] Container resized(const geometry::Vec3& size_m) const;

private:
    std::shared_ptr<const geometry::Vessel> vessel_;
    geometry::Vec3 low_ = geometry::Vec3::Zero(), high_ = geometry::Vec3::Zero(), size_ = geometry::Vec3::Zero();
    std::array<bool, 3> periodic_ = {false, false, false};
    bool cut_ends_ = false;
};

[[nodiscard]] Container make_cylinder(double diameter_m, double height_m);
[[nodiscard]] Container make_box(const geometry::Vec3& size_m, const std::array<bool, 3>& periodic = {false, false, false});

/// Throws UserError unless the cross-section is the same at all heights and known as an outline; `what` needs that.
void require_prism(const Container& container, const std::string& what);

/// The vessel's, and `ends` = "cut" where the bed goes on.
[[nodiscard]] core::Json to_json(const Container& container);
/// The same in one line for messages, of long lists only the length.
[[nodiscard]] std::string text_of(const Container& container);

}  // namespace porepack::vessels
