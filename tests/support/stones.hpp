// Stones for tests: spheres of triangles, with waves on them.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "shapes/rounded_body.hpp"

namespace porepack::test {

/// An icosahedron of radius 1/2 whose sides are halved `halvings` times (20 * 4^halvings triangles). Twelve waves of random directions, up
/// to four lengths around the stone, move its corners in and out by `roughness` of the radius in all.
inline shapes::PolyhedronSize stone(int halvings, double roughness, unsigned seed, double rounding_m) {
    using shapes::Vec3;
    shapes::PolyhedronSize size;
    const double golden = std::numbers::phi, shortest = 2.0 / std::sqrt(1.0 + golden * golden);
    for (const double a : {-1.0, 1.0})
        for (const double b : {-golden, golden})
            for (const Vec3& corner : {Vec3(0.0, a, b), Vec3(a, b, 0.0), Vec3(b, 0.0, a)}) size.corners_m.push_back(corner.normalized());
    const auto at = [&](int i) -> const Vec3& { return size.corners_m[static_cast<std::size_t>(i)]; };
    for (int i = 0; i < 12; ++i)
        for (int j = i + 1; j < 12; ++j)
            for (int k = j + 1; k < 12; ++k)
                if (std::max({(at(i) - at(j)).norm(), (at(j) - at(k)).norm(), (at(k) - at(i)).norm()}) < 1.1 * shortest) {
                    const bool outward = (at(j) - at(i)).cross(at(k) - at(i)).dot(at(i)) > 0.0;
                    size.faces.push_back(outward ? std::vector<int>{i, j, k} : std::vector<int>{i, k, j});
                }
    for (int halving = 0; halving < halvings; ++halving) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int i, int j) {
            const auto [place, fresh] = middles.try_emplace({std::min(i, j), std::max(i, j)}, static_cast<int>(size.corners_m.size()));
            if (fresh) size.corners_m.push_back((at(i) + at(j)).normalized());
            return place->second;
        };
        std::vector<std::vector<int>> smaller;
        for (const auto& face : size.faces) {
            const int a = middle(face[0], face[1]), b = middle(face[1], face[2]), c = middle(face[2], face[0]);
            smaller.insert(smaller.end(), {{face[0], a, c}, {a, face[1], b}, {c, b, face[2]}, {a, b, c}});
        }
        size.faces = smaller;
    }
    std::mt19937 random(seed);
    const auto uniform = [&] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
    struct Wave {
        Vec3 along;
        double phase;
    };
    std::vector<Wave> waves;
    for (int n = 0; n < 12; ++n) {
        const double x = uniform(), y = uniform(), z = uniform(), phase = std::numbers::pi * uniform();
        waves.push_back({4.0 * Vec3(x, y, z), phase});
    }
    for (Vec3& corner : size.corners_m) {
        double sum = 0.0;
        for (const Wave& wave : waves) sum += std::cos(wave.along.dot(corner) + wave.phase) / 12.0;
        corner *= 0.5 * (1.0 + roughness * sum);
    }
    size.rounding_m = rounding_m;
    return size;
}

}  // namespace porepack::test
