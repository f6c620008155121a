#include "tortuosity/conjugate_gradients.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "tortuosity/multigrid.hpp"
#include "tortuosity/uses.hpp"

namespace porepack::tortuosity {

// The usual symbols: r residual, p search direction, q = A p, rho = r M r with the preconditioner M (one V-cycle).
ConjugateGradientResult solve_by_conjugate_gradients(std::vector<ConductanceGrid>& grids, std::vector<double> b, std::vector<double>& x,
                                                     const ConjugateGradientOptions& options) {
    ConductanceGrid& fine = grids.front();
    const double scale = std::sqrt(sum_over(fine, [&](std::size_t i) { return b[i] * b[i]; }));
    std::vector<double> r = std::move(b), p(fine.size(), 0.0), q(fine.size(), 0.0);
    multiply(fine, x, [&](std::size_t i, double product, double diagonal) {
        if (diagonal == 0.0) x[i] = 0.0;
        r[i] = diagonal > 0.0 ? r[i] - product : 0.0;
    });
    Progress progress(options.label);
    ConjugateGradientResult result;
    const auto relative_residual = [&] { return std::sqrt(sum_over(fine, [&](std::size_t i) { return r[i] * r[i]; })) / scale; };
    result.residual = scale > 0.0 ? relative_residual() : 0.0;
    const double first = result.residual;
    double rho = 0.0;
    while (result.residual > options.tolerance && result.iterations < options.max_iterations) {
        check_interrupt();
        for_cells(fine, [&](std::size_t i) { fine.b[i] = static_cast<float>(r[i]); });
        v_cycle(grids);
        const double now = sum_over(fine, [&](std::size_t i) { return r[i] * static_cast<double>(fine.x[i]); });
        const double beta = result.iterations == 0 ? 0.0 : now / rho;
        rho = now;
        for_cells(fine, [&](std::size_t i) { p[i] = static_cast<double>(fine.x[i]) + beta * p[i]; });
        multiply(fine, p, [&](std::size_t i, double product, double) { q[i] = product; });
        const double alpha = rho / sum_over(fine, [&](std::size_t i) { return p[i] * q[i]; });
        for_cells(fine, [&](std::size_t i) {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
        });
        result.residual = relative_residual();
        ++result.iterations;
        if (!std::isfinite(result.residual)) break;
        progress.update(std::log(first / result.residual) / std::log(first / options.tolerance),
                        fmt::format("residual {:.1e}", result.residual));
    }
    result.converged = result.residual <= options.tolerance;
    return result;
}

}  // namespace porepack::tortuosity
