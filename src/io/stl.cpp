#include "io/stl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <unordered_map>

#include "core/error.hpp"

namespace porepack::io {
using namespace core;
namespace {

constexpr std::size_t header_size = 84;
constexpr std::size_t record_size = 50;

struct PointHash {
    std::size_t operator()(const std::array<float, 3>& p) const {
        std::size_t hash = 0;
        for (const float value : p) {
            std::uint32_t bits = 0;
            const float clean = value == 0.0F ? 0.0F : value;  // -0 is 0
            std::memcpy(&bits, &clean, sizeof bits);
            hash = (hash ^ bits) * 0x9E3779B97F4A7C15ULL;
        }
        return hash;
    }
};

class Welder {
public:
    explicit Welder(double unit) : unit_(unit) {}
    void add(const std::array<std::array<float, 3>, 3>& corners) {
        std::array<int, 3> triangle{};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [entry, fresh] = index_.try_emplace(corners[c], static_cast<int>(surface.points.size()));
            if (fresh) surface.points.push_back({unit_ * corners[c][0], unit_ * corners[c][1], unit_ * corners[c][2]});
            triangle[c] = entry->second;
        }
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) surface.triangles.push_back(triangle);
    }
    TriangleSurface surface;

private:
    double unit_;
    std::unordered_map<std::array<float, 3>, int, PointHash> index_;
};

void require_finite(const std::array<std::array<float, 3>, 3>& corners, std::size_t triangle, const Path& path) {
    for (const auto& corner : corners)
        for (const float value : corner)
            if (!std::isfinite(value))
                throw UserError(fmt::format("triangle {} of {} has a corner that is not finite", triangle, path.string()),
                                {.fix = "export the surface again"});
}

TriangleSurface read_binary(const std::string& bytes, std::uint32_t count, const Path& path, double unit) {
    Welder welder(unit);
    for (std::size_t t = 0; t < count; ++t) {
        std::array<std::array<float, 3>, 3> corners{};
        std::memcpy(corners.data(), bytes.data() + header_size + t * record_size + 12, sizeof corners);
        require_finite(corners, t, path);
        welder.add(corners);
    }
    return std::move(welder.surface);
}

TriangleSurface read_ascii(const std::string& text, const Path& path, double unit) {
    Welder welder(unit);
    std::istringstream words(text);
    std::string word;
    std::array<std::array<float, 3>, 3> corners{};
    std::size_t corner = 0, triangle = 0;
    bool ended = false;
    while (words >> word) {
        std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        ended = word == "endsolid" || (ended && word != "solid");
        if (word != "vertex") continue;
        for (float& value : corners[corner]) {
            std::string number;
            words >> number;
            const auto [end, fault] =
                std::from_chars(number.data() + (number.starts_with('+') ? 1 : 0), number.data() + number.size(), value);
            if (fault != std::errc() || end != number.data() + number.size()) {
                throw UserError(fmt::format("`{}` is not a number in triangle {} of {}", number, triangle, path.string()),
                                {.fix = "the file may be incomplete: export it again"});
            }
        }
        if (++corner < 3) continue;
        require_finite(corners, triangle, path);
        welder.add(corners);
        corner = 0;
        ++triangle;
    }
    if (!ended || corner != 0)
        throw UserError(fmt::format("the STL file is incomplete: {} ends in triangle {}", path.string(), triangle),
                        {.fix = "export or copy it again"});
    return std::move(welder.surface);
}

}  // namespace

void write_stl(const Path& path, const TriangleSurface& surface, const std::string& header) {
    std::string bytes(header_size + record_size * surface.triangles.size(), '\0');
    std::memcpy(bytes.data(), header.data(), std::min<std::size_t>(header.size(), 80));
    const auto count = static_cast<std::uint32_t>(surface.triangles.size());
    std::memcpy(bytes.data() + 80, &count, sizeof count);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        std::array<std::array<double, 3>, 3> p{};
        for (std::size_t c = 0; c < 3; ++c) p[c] = surface.points[static_cast<std::size_t>(surface.triangles[t][c])];
        std::array<double, 3> u{}, v{};
        for (std::size_t i = 0; i < 3; ++i) {
            u[i] = p[1][i] - p[0][i];
            v[i] = p[2][i] - p[0][i];
        }
        std::array<double, 3> n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        std::array<float, 12> record{};
        for (std::size_t i = 0; i < 3; ++i) {
            record[i] = static_cast<float>(length > 0.0 ? n[i] / length : 0.0);
            for (std::size_t c = 0; c < 3; ++c) record[3 + 3 * c + i] = static_cast<float>(p[c][i]);
        }
        std::memcpy(bytes.data() + header_size + t * record_size, record.data(), sizeof record);
    }
    write_text(path, bytes);
}

void write_stl_regions(const Path& path, const TriangleSurface& surface, const std::vector<int>& region,
                       const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t r = 0; r < names.size(); ++r) {
        text += "solid " + names[r] + "\n";
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            if (region[t] != static_cast<int>(r)) continue;
            text += "facet normal 0 0 0\nouter loop\n";
            for (const int corner : surface.triangles[t]) {
                const auto& p = surface.points[static_cast<std::size_t>(corner)];
                text += fmt::format("vertex {:.9g} {:.9g} {:.9g}\n", p[0], p[1], p[2]);
            }
            text += "endloop\nendfacet\n";
        }
        text += "endsolid " + names[r] + "\n";
    }
    write_text(path, text);
}

void write_ply(const Path& path, const TriangleSurface& surface, const std::string& comment) {
    std::string bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment porepack; {}\nelement vertex {}\nproperty double x\nproperty double y\nproperty "
        "double "
        "z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        comment, surface.points.size(), surface.triangles.size());
    const auto append = [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); };
    for (const auto& p : surface.points) append(p.data(), sizeof p);
    for (const auto& t : surface.triangles) {
        bytes.push_back(3);
        append(t.data(), sizeof t);
    }
    write_text(path, bytes);
}

TriangleSurface read_stl(const Path& path, double unit_m) {
    const std::string bytes = read_text(path);
    if (bytes.empty()) throw UserError("the file is empty: " + path.string());
    TriangleSurface surface;
    std::uint32_t count = 0;
    if (bytes.size() >= header_size) std::memcpy(&count, bytes.data() + 80, sizeof count);
    const std::size_t expected = header_size + record_size * static_cast<std::size_t>(count);
    std::string start = bytes.substr(0, 1000);
    std::transform(start.begin(), start.end(), start.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const std::size_t first = start.find_first_not_of(" \t\r\n");
    const bool ascii = first != std::string::npos && start.compare(first, 5, "solid") == 0 && start.find("facet") != std::string::npos &&
                       bytes.size() != expected;
    if (ascii) {
        surface = read_ascii(bytes, path, unit_m);
    } else {
        if (bytes.size() < header_size) throw UserError("not an STL file: " + path.string(), {.allowed = "binary or ASCII STL"});
        if (bytes.size() < expected)
            throw UserError(fmt::format("the STL file is incomplete: {} needs {} triangles ({} bytes), has {} bytes", path.string(), count,
                                        expected, bytes.size()),
                            {.fix = "export or copy it again"});
        if (bytes.size() > expected)
            throw UserError(fmt::format("{} bytes follow the {} triangles that the STL file announces: {}", bytes.size() - expected, count,
                                        path.string()),
                            {.fix = "export it again; surfaces of several files must be joined by a program, not by appending the files"});
        surface = read_binary(bytes, count, path, unit_m);
    }
    if (surface.triangles.empty()) throw UserError("the STL file has no triangle: " + path.string());
    return surface;
}

}  // namespace porepack::io
