// Conjugate gradients for the matrix of a ConductanceGrid; only for the sources of this folder.
#pragma once

#include <string>
#include <vector>

#include "tortuosity/conductance_grid.hpp"

namespace porepack::tortuosity {

struct ConjugateGradientOptions {
    /// The solver stops when |b - A x| / |b| (2-norms) is at or below this. Dimensionless. With 1e-6 the error of D_eff is far below that
    /// of the voxels; use a smaller value if single concentrations matter.
    double tolerance = 1e-6;
    /// Upper limit on iterations; the multigrid preconditioner keeps their number nearly independent of the grid. Raise it only if a
    /// smaller tolerance or pores that are nearly closed need more.
    long max_iterations = 500;
    /// Name in the progress line.
    std::string label = "conjugate gradients";
};

struct ConjugateGradientResult {
    long iterations = 0;
    double residual = 0.0;  ///< |b - A x| / |b|; not a number when the solver broke down
    bool converged = false;
};

/// Improves `x`, which holds the first guess, until A x = `b`; A is that of grids.front(), and all `grids` (make_grids) precondition. Cells
/// without any open face become 0. Vectors are of one value per cell of grids.front(); their memory is 3 doubles per cell with `b`, and
/// grids.front() keeps its own in single precision. The same bits on any number of threads. Source: Hestenes & Stiefel (1952).
[[nodiscard]] ConjugateGradientResult solve_by_conjugate_gradients(std::vector<ConductanceGrid>& grids, std::vector<double> b,
                                                                   std::vector<double>& x, const ConjugateGradientOptions& options = {});

}  // namespace porepack::tortuosity
