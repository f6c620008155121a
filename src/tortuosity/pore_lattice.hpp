// The corners of an image's voxels as points where a path may turn, and their lines of sight. Only for the sources of this folder.
#pragma once

#include <array>
#include <cstdint>

#include "pore_space/link_cuts.hpp"
#include "pore_space/voxels.hpp"

namespace porepack::tortuosity {

using Corner = std::array<int, 3>;

struct Lattice {
    std::array<int, 3> cells{};
    std::array<bool, 3> periodic{};  // across; never along the path
    shapes::Vec3 origin_m = shapes::Vec3::Zero(), spacing_m = shapes::Vec3::Ones();

    [[nodiscard]] int corners(std::size_t axis) const { return cells[axis] + (periodic[axis] ? 0 : 1); }
    [[nodiscard]] std::size_t size() const {
        return static_cast<std::size_t>(corners(0)) * static_cast<std::size_t>(corners(1)) * static_cast<std::size_t>(corners(2));
    }
    [[nodiscard]] std::size_t index(const Corner& at) const {
        return (static_cast<std::size_t>(at[2]) * static_cast<std::size_t>(corners(1)) + static_cast<std::size_t>(at[1])) *
                   static_cast<std::size_t>(corners(0)) +
               static_cast<std::size_t>(at[0]);
    }
    [[nodiscard]] Corner corner(std::size_t index) const { return geometry::place_in({corners(0), corners(1), corners(2)}, index); }
    // False beyond the walls; across a periodic side the corner is the one on the other side.
    [[nodiscard]] bool wrap(Corner& at) const {
        for (std::size_t a = 0; a < 3; ++a) {
            if (periodic[a])
                at[a] = at[a] < 0 ? at[a] + cells[a] : at[a] >= cells[a] ? at[a] - cells[a] : at[a];
            else if (at[a] < 0 || at[a] > cells[a])
                return false;
        }
        return true;
    }
    [[nodiscard]] shapes::Vec3 place(const Corner& at) const {
        return origin_m + spacing_m.cwiseProduct(shapes::Vec3(at[0], at[1], at[2]));
    }
};

// The voxels are treated as cubes. Pores connect through faces only; a path may follow the faces and edges of a grain, but not pass where
// two pores meet only in an edge or a corner, nor through the faces between pores that `cuts` closes.
class VoxelSight {
public:
    VoxelSight(const geometry::PhaseImage& image, const Lattice& lattice, const pore_space::LinkCuts& cuts)
        : image_(image), lattice_(lattice), cuts_(cuts) {}
    // The corner is in pore space, whose cells here are all connected through faces.
    [[nodiscard]] bool open(const Corner& at) const;
    // The straight path from one corner to another, both open, is in pore space. `step` leads to the other.
    [[nodiscard]] bool visible(const Corner& from, const Corner& step) const;

private:
    [[nodiscard]] bool is_pore(Corner cell) const;
    // Both cells are pore, and the face between them is open; `direction` is -1 or 1.
    [[nodiscard]] bool joined(const Corner& cell, std::size_t axis, int direction) const;
    // The pores among the cells [low, low + size) are joined through the faces between them.
    [[nodiscard]] bool all_joined(const Corner& low, const Corner& size) const;
    [[nodiscard]] bool along_edge(const Corner& from, const Corner& step, std::size_t axis) const;
    [[nodiscard]] bool along_face(const Corner& from, const Corner& step, std::size_t normal) const;
    [[nodiscard]] bool through_cells(const Corner& from, const Corner& step) const;
    const geometry::PhaseImage& image_;
    const Lattice& lattice_;
    const pore_space::LinkCuts& cuts_;
};

}  // namespace porepack::tortuosity
