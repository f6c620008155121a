#include "scans/projection_filters.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace porepack::scans {

void blur_rows(std::vector<float>& values, int columns, int rows, double sigma) {
    // The Gaussian is separable: one pass along the rows, one across. Beyond the edges the last value continues.
    if (sigma <= 0.0) return;
    const int reach = static_cast<int>(std::ceil(4.0 * sigma));
    std::vector<float> kernel;
    float sum = 0.0F;
    for (int r = -reach; r <= reach; ++r) sum += kernel.emplace_back(static_cast<float>(std::exp(-0.5 * r * r / (sigma * sigma))));
    for (float& weight : kernel) weight /= sum;
    const auto pass = [&](int count, int stride, int lines, int line_stride) {
        std::vector<float> line(static_cast<std::size_t>(count));
        for (int l = 0; l < lines; ++l) {
            const auto at = [&](int i) -> float& { return values[static_cast<std::size_t>(l * line_stride + i * stride)]; };
            for (int i = 0; i < count; ++i) line[static_cast<std::size_t>(i)] = at(i);
            for (int i = 0; i < count; ++i) {
                float mean = 0.0F;
                for (int r = -reach; r <= reach; ++r)
                    mean += kernel[static_cast<std::size_t>(r + reach)] * line[static_cast<std::size_t>(std::clamp(i + r, 0, count - 1))];
                at(i) = mean;
            }
        }
    };
    pass(columns, 1, rows, columns);
    pass(rows, columns, columns, 1);
}

// The kernel is even, so its transform is real. Rows are padded with zeros to twice their length (size_): the cyclic convolution of the
// transforms then equals the linear one.
std::vector<float> filter_of(int size) {
    std::vector<float> kernel(static_cast<std::size_t>(size), 0.0F);
    kernel[0] = 0.25F;
    for (int n = 1; n < size / 2; n += 2)
        kernel[static_cast<std::size_t>(n)] = kernel[static_cast<std::size_t>(size - n)] =
            static_cast<float>(-1.0 / std::pow(std::numbers::pi * n, 2.0));
    Eigen::FFT<float> fft;
    std::vector<std::complex<float>> transformed;
    fft.fwd(transformed, kernel);
    std::vector<float> filter;
    for (const auto& value : transformed) filter.push_back(value.real());
    return filter;
}

}  // namespace porepack::scans
