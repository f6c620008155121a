#include "lbm/pressure_ends.hpp"

#include <algorithm>

#include "lbm/uses.hpp"

namespace porepack::lbm {

PressureEnds::PressureEnds(std::unique_ptr<Flow> flow, const Domain& domain) : flow_(std::move(flow)), domain_(domain) {
    for (const BoundaryLink& link : domain.boundary_links)
        for (const std::size_t node : {link.node, link.source}) chunks_.push_back(node / chunk);
    std::sort(chunks_.begin(), chunks_.end());
    chunks_.erase(std::unique(chunks_.begin(), chunks_.end()), chunks_.end());
    speed_.resize(chunks_.size() * chunk);
    const auto place = [&](std::size_t node) {
        const auto rank = std::lower_bound(chunks_.begin(), chunks_.end(), node / chunk) - chunks_.begin();
        return static_cast<std::size_t>(rank) * chunk + node % chunk;
    };
    for (const BoundaryLink& link : domain.boundary_links) places_.push_back({place(link.node), place(link.source)});
    added_.resize(domain.boundary_links.size());
}

void PressureEnds::advance_two_steps() {
    flow_->advance_two_steps();
    update();
}

void PressureEnds::update() {
    for (std::size_t c = 0, end = 0; c < chunks_.size(); c = end) {
        for (end = c + 1; end < chunks_.size() && chunks_[end] == chunks_[end - 1] + 1;) ++end;
        const std::size_t first = chunks_[c] * chunk;
        moments_.resize(std::min((end - c) * chunk, domain_.nodes() - first));
        flow_->moments(first, moments_);
        for (std::size_t i = 0; i < moments_.size(); ++i) speed_[c * chunk + i] = moments_[i].velocity[2];
    }
    for (std::size_t l = 0; l < added_.size(); ++l) {
        const BoundaryLink& link = domain_.boundary_links[l];
        const double across = 0.5 * (speed_[places_[l][0]] + speed_[places_[l][1]]);
        const bool comes_back = across < 0.0 && d3q19::c[link.q][2] < 0;
        added_[l] = (comes_back ? 3.0 : 6.0) * d3q19::w(link.q) * across * across;
    }
    flow_->set_boundary_links(added_);
}

}  // namespace porepack::lbm
