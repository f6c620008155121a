// D3Q19: velocities c_q, weights w_q, and the order in which q and q+1 (q odd) are opposite. c_s^2 = 1/3.
#pragma once

#include <array>

namespace porepack::lbm::d3q19 {

inline constexpr int directions = 19;
inline constexpr std::array<std::array<int, 3>, directions> c = {{{0, 0, 0},
                                                                  {1, 0, 0},
                                                                  {-1, 0, 0},
                                                                  {0, 1, 0},
                                                                  {0, -1, 0},
                                                                  {0, 0, 1},
                                                                  {0, 0, -1},
                                                                  {1, 1, 0},
                                                                  {-1, -1, 0},
                                                                  {1, -1, 0},
                                                                  {-1, 1, 0},
                                                                  {1, 0, 1},
                                                                  {-1, 0, -1},
                                                                  {1, 0, -1},
                                                                  {-1, 0, 1},
                                                                  {0, 1, 1},
                                                                  {0, -1, -1},
                                                                  {0, 1, -1},
                                                                  {0, -1, 1}}};
inline constexpr double w_rest = 1.0 / 3.0, w_axis = 1.0 / 18.0, w_diagonal = 1.0 / 36.0;
[[nodiscard]] constexpr double w(int q) {
    return q == 0 ? w_rest : q < 7 ? w_axis : w_diagonal;
}
/// The direction with its component along `axis` reversed.
[[nodiscard]] constexpr int mirrored(int q, int axis) {
    auto wanted = c[static_cast<std::size_t>(q)];
    wanted[static_cast<std::size_t>(axis)] *= -1;
    int found = 0;
    while (c[static_cast<std::size_t>(found)] != wanted) ++found;
    return found;
}
[[nodiscard]] constexpr int opposite(int q) {
    return q == 0 ? 0 : q % 2 == 1 ? q + 1 : q - 1;
}

}  // namespace porepack::lbm::d3q19
