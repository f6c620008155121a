#include "lbm/scheme.hpp"

namespace porepack::lbm {

// Eq. (T8) and (T9): sigma = shift (magic - lambda) / (1 + 2x), shift = 2 / plus, with lambda of Eq. (T11), under-relaxed.
WallRule Scheme::wall_rule() const {
    const double plus = tau - 0.5;
    if (two_relaxation_times()) return {2.0 / plus, magic, 0.6 * (0.5 * plus + magic), 1.0};
    // Without the term for parabolas: at small viscosities it makes flows in narrow throats unstable. Half under-relaxed: walls close to
    // nodes are more stable.
    return {0.0, 0.0, 1e30, 0.5};
}

}  // namespace porepack::lbm
