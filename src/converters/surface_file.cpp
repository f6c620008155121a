#include "converters/surface_file.hpp"

#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/Simple_cartesian.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "converters/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack::converters {
namespace {

std::string ending(const Path& path) {
    std::string text = path.extension().string();
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

TriangleSurface read_polygons(const Path& path, double unit_m, const std::string& format) {
    const std::string bytes = read_text(path);
    if (bytes.empty()) throw UserError("the file is empty: " + path.string());
    std::istringstream in(bytes);
    std::vector<CGAL::Simple_cartesian<double>::Point_3> points;
    std::vector<std::vector<std::size_t>> polygons;
    const bool is_ply = format == ".ply";
    bool read = false;
    try {
        read = is_ply ? bytes.starts_with("ply") && CGAL::IO::read_PLY(in, points, polygons) : CGAL::IO::read_OBJ(in, points, polygons);
    } catch (const std::exception&) {  // of sizes that the file cannot hold
    }
    if (!read || points.empty() || polygons.empty())
        throw UserError(fmt::format("not {} file, or an incomplete one: {} ({} points and {} faces were read)", is_ply ? "a PLY" : "an OBJ",
                                    path.string(), points.size(), polygons.size()),
                        {.allowed = "a file with points and faces", .fix = "export it again, or as STL"});
    TriangleSurface surface;
    std::map<std::array<double, 3>, int> place_of;
    std::vector<int> place;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::array<double, 3> p = {points[i].x() * unit_m, points[i].y() * unit_m, points[i].z() * unit_m};
        if (!std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); }))
            throw UserError(fmt::format("point {} is not a number", i + 1), {.where = path.string(), .fix = "export it again"});
        const auto [known, fresh] = place_of.try_emplace(p, static_cast<int>(surface.points.size()));
        if (fresh) surface.points.push_back(p);
        place.push_back(known->second);
    }
    long without_area = 0;
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        const auto& polygon = polygons[f];
        for (const std::size_t corner : polygon)
            if (corner >= place.size())
                throw UserError(fmt::format("face {} has a corner {}, but there are {} points", f + 1, corner + 1, place.size()),
                                {.where = path.string(), .fix = "export it again"});
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            const std::array<int, 3> triangle = {place[polygon[0]], place[polygon[i - 1]], place[polygon[i]]};
            if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
                ++without_area;
            else
                surface.triangles.push_back(triangle);
        }
    }
    if (without_area > 0)
        log_warning(fmt::format("{} triangles of {} have two equal corners: they are left out", without_area, path.string()));
    if (surface.triangles.empty()) throw UserError("the file has no triangle with an area: " + path.string());
    return surface;
}

}  // namespace

bool is_surface_file(const Path& path) {
    const std::string format = ending(path);
    return format == ".stl" || format == ".ply" || format == ".obj";
}

TriangleSurface read_surface(const Path& path, double unit_m) {
    const std::string format = ending(path);
    if (format == ".ply" || format == ".obj") return read_polygons(path, unit_m, format);
    return read_stl(path, unit_m);
}

}  // namespace porepack::converters
