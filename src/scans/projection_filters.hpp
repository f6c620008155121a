// What a detector does to a projection, and the filter of back projection; only for the sources of this folder.
#pragma once

#include <vector>

namespace porepack::scans {

/// By a Gaussian of `sigma` pixels, row by row.
void blur_rows(std::vector<float>& values, int columns, int rows, double sigma);
/// Ramachandran & Lakshminarayanan's kernel for pixels of unit width, transformed; `size` is that of a padded row.
[[nodiscard]] std::vector<float> filter_of(int size);

}  // namespace porepack::scans
