#include "pouring/grain_body.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "pouring/uses.hpp"

namespace porepack::pouring {
namespace {

double rounded(double value, double size) {
    const double unit = std::pow(10.0, std::floor(std::log10(size)) - 6.0);
    return std::round(value / unit) * unit;
}

}  // namespace

GrainBody grain_body(const Shape& shape, double density_kg_per_m3) {
    const ShapeMeasures measures = measure(shape);
    GrainBody body;
    const double mass = density_kg_per_m3 * measures.volume_m3;
    body.mass_kg = rounded(mass, mass);
    for (int axis = 0; axis < 3; ++axis) body.centre_m[axis] = rounded(measures.centre_of_mass_m[axis], measures.maximum_feret_diameter_m);
    Eigen::Matrix3d tensor = measures.inertia_per_density_m5;
    const double largest = tensor.cwiseAbs().maxCoeff();
    tensor = tensor.unaryExpr([&](double value) { return rounded(value, largest); });
    const Eigen::Matrix3d off = tensor - Eigen::Matrix3d(tensor.diagonal().asDiagonal());
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    if (off.norm() > 1e-5 * tensor.norm()) {
        axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor).eigenvectors();
        if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
    }
    body.turn = Quaternion(axes);
    body.inertia_kg_m2 = density_kg_per_m3 * (axes.transpose() * tensor * axes).diagonal();
    return body;
}

}  // namespace porepack::pouring
