// Boxes in a tree, for a fast search among many.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "geometry/vector.hpp"

namespace porepack::inline geometry {

class BoxTree {
public:
    BoxTree() = default;
    explicit BoxTree(const std::vector<Bounds>& boxes) : items_(boxes.size()) {
        std::iota(items_.begin(), items_.end(), 0U);
        if (!boxes.empty()) divide(boxes, 0, static_cast<std::uint32_t>(boxes.size()));
    }

    /// Visits the numbers of all boxes whose key(box) is not above limit(), and of some others near them: a group of up to four is visited
    /// as a whole. Groups with a lower key come first; limit() may fall with each visit. The key of a box may not be above that of a box
    /// within it.
    template <typename Key, typename Limit, typename Visit>
    void search(const Key& key, const Limit& limit, const Visit& visit) const {
        if (!nodes_.empty()) search(0, key, limit, visit);
    }

private:
    struct Node {
        Bounds bounds;
        std::uint32_t first = 0, count = 0;  // items of a leaf
        std::uint32_t second = 0;            // the other part; the one part follows its node
    };
    static constexpr std::uint32_t leaf = 4;

    // By the middles of the boxes along the longest axis, into halves.
    std::uint32_t divide(const std::vector<Bounds>& boxes, std::uint32_t first, std::uint32_t last) {
        const auto here = static_cast<std::uint32_t>(nodes_.size());
        nodes_.emplace_back();
        Bounds bounds, middles;
        for (std::uint32_t n = first; n < last; ++n) {
            const Bounds& box = boxes[items_[n]];
            bounds.low = bounds.low.cwiseMin(box.low);
            bounds.high = bounds.high.cwiseMax(box.high);
            middles.add(0.5 * (box.low + box.high), 0.0);
        }
        nodes_[here].bounds = bounds;
        if (last - first <= leaf) {
            nodes_[here].first = first;
            nodes_[here].count = last - first;
            return here;
        }
        int axis = 0;
        (middles.high - middles.low).maxCoeff(&axis);
        const std::uint32_t middle = first + (last - first) / 2;
        std::nth_element(items_.begin() + first, items_.begin() + middle, items_.begin() + last, [&](std::uint32_t a, std::uint32_t b) {
            const double p = boxes[a].low[axis] + boxes[a].high[axis], q = boxes[b].low[axis] + boxes[b].high[axis];
            return p < q || (p == q && a < b);
        });
        (void)divide(boxes, first, middle);
        const std::uint32_t second = divide(boxes, middle, last);
        nodes_[here].second = second;
        return here;
    }

    template <typename Key, typename Limit, typename Visit>
    void search(std::uint32_t n, const Key& key, const Limit& limit, const Visit& visit) const {
        const Node& node = nodes_[n];
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(static_cast<std::size_t>(items_[i]));
        if (node.count > 0) return;
        std::uint32_t near = n + 1, far = node.second;
        double least = key(nodes_[near].bounds), most = key(nodes_[far].bounds);
        if (most < least) {
            std::swap(near, far);
            std::swap(least, most);
        }
        if (least <= limit()) search(near, key, limit, visit);
        if (most <= limit()) search(far, key, limit, visit);
    }

    std::vector<std::uint32_t> items_;
    std::vector<Node> nodes_;
};

/// Square of the distance of a point from a box; 0 inside.
[[nodiscard]] inline double square_from(const Bounds& box, const Vec3& point) {
    return (box.low - point).cwiseMax(point - box.high).cwiseMax(0.0).squaredNorm();
}
/// The boxes have a common point.
[[nodiscard]] inline bool meet(const Bounds& one, const Bounds& two) {
    return (one.low.array() <= two.high.array()).all() && (two.low.array() <= one.high.array()).all();
}

}  // namespace porepack::inline geometry
