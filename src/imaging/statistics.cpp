#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "imaging/volume.hpp"

namespace porepack::imaging {

VolumeStatistics statistics_of(const VolumeSource& source) {
    const VolumeHeader& header = source.header;
    VolumeStatistics result{.minimum = std::numeric_limits<double>::infinity(),
                            .maximum = -std::numeric_limits<double>::infinity(),
                            .values = std::map<double, std::int64_t>()};
    std::vector<float> layer(static_cast<std::size_t>(header.layer()));
    // Sums about the first value: the variance of large, nearly equal values would cancel otherwise. Values are counted in runs, which
    // saves a look-up per voxel, up to 256 different values.
    double sum = 0.0, squares = 0.0, shift = 0.0;
    for (std::int64_t z = 0; z < header.voxels[2]; ++z) {
        source.read(z, layer);
        if (z == 0) shift = layer.front();
        float last = layer.front();
        std::int64_t run = 0;
        const auto count = [&](float value, std::int64_t number) {
            if (result.values && ((*result.values)[value] += number) >= 0 && result.values->size() > 256) result.values.reset();
        };
        for (const float value : layer) {
            result.minimum = std::min<double>(result.minimum, value);
            result.maximum = std::max<double>(result.maximum, value);
            sum += value - shift;
            squares += (value - shift) * (value - shift);
            if (value != last) {
                count(last, run);
                last = value;
                run = 0;
            }
            ++run;
        }
        count(last, run);
    }
    const auto n = static_cast<double>(header.count());
    result.mean = shift + sum / n;
    result.deviation = std::sqrt(std::max(0.0, squares / n - sum / n * sum / n));
    return result;
}

}  // namespace porepack::imaging
