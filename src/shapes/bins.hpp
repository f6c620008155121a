// Boxes sorted into cubic bins, for a fast search of the boxes near a point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "shapes/capsule.hpp"

namespace porepack::shapes {

class SpatialBins {
public:
    /// Bins about as large as the mean box, at most about two million.
    explicit SpatialBins(const std::vector<Bounds>& boxes) : boxes_(boxes) {
        if (boxes.empty()) return;
        double extent = 0.0;
        for (const Bounds& box : boxes) {
            low_ = low_.cwiseMin(box.low);
            high_ = high_.cwiseMax(box.high);
            extent += (box.high - box.low).maxCoeff() / static_cast<double>(boxes.size());
        }
        size_ = std::max(extent, (high_ - low_).maxCoeff() / 128.0);
        for (std::size_t a = 0; a < 3; ++a) count_[a] = 1 + static_cast<int>((high_ - low_)[static_cast<int>(a)] / size_);
        // First counted, then filled: one array for all bins.
        first_.assign(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) * static_cast<std::size_t>(count_[2]) + 1,
                      0);
        for (const Bounds& box : boxes) over_bins(box.low, box.high, [&](std::size_t bin) { ++first_[bin + 1]; });
        for (std::size_t bin = 1; bin < first_.size(); ++bin) first_[bin] += first_[bin - 1];
        item_.resize(first_.back());
        std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
        for (std::size_t i = 0; i < boxes.size(); ++i)
            over_bins(boxes[i].low, boxes[i].high, [&](std::size_t bin) { item_[next[bin]++] = static_cast<int>(i); });
    }

    /// Appends the boxes that come within `reach` of the point along every axis, each once.
    void near(const Vec3& point, double reach, std::vector<int>& found) const {
        if (boxes_.empty()) return;
        const std::size_t begin = found.size();
        const Vec3 low = point - Vec3::Constant(reach), high = point + Vec3::Constant(reach);
        if ((low.array() > high_.array()).any() || (high.array() < low_.array()).any()) return;
        over_bins(low, high, [&](std::size_t bin) {
            for (std::size_t k = first_[bin]; k < first_[bin + 1]; ++k) {
                const Bounds& box = boxes_[static_cast<std::size_t>(item_[k])];
                if ((low.array() <= box.high.array()).all() && (high.array() >= box.low.array()).all()) found.push_back(item_[k]);
            }
        });
        std::sort(found.begin() + static_cast<std::ptrdiff_t>(begin), found.end());
        found.erase(std::unique(found.begin() + static_cast<std::ptrdiff_t>(begin), found.end()), found.end());
    }

private:
    template <typename Visit>
    void over_bins(const Vec3& low, const Vec3& high, const Visit& visit) const {
        std::array<int, 3> from{}, to{};
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<int>(a);
            from[a] = std::clamp(static_cast<int>((low[axis] - low_[axis]) / size_), 0, count_[a] - 1);
            to[a] = std::clamp(static_cast<int>((high[axis] - low_[axis]) / size_), 0, count_[a] - 1);
        }
        for (int k = from[2]; k <= to[2]; ++k)
            for (int j = from[1]; j <= to[1]; ++j)
                for (int i = from[0]; i <= to[0]; ++i)
                    visit((static_cast<std::size_t>(k) * static_cast<std::size_t>(count_[1]) + static_cast<std::size_t>(j)) *
                              static_cast<std::size_t>(count_[0]) +
                          static_cast<std::size_t>(i));
    }

    std::vector<Bounds> boxes_;
    Vec3 low_ = Vec3::Constant(1e300), high_ = Vec3::Constant(-1e300);
    double size_ = 1.0;
    std::array<int, 3> count_ = {1, 1, 1};
    std::vector<std::size_t> first_;
    std::vector<int> item_;
};

}  // namespace porepack::shapes
