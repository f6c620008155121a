#include "io/stl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack::io {
namespace {

// Binary STL: 80 bytes of text, the number of triangles (4 bytes), and for each triangle its normal and three corners (12 single-precision
// numbers) and 2 unused bytes.
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

// An STL file repeats a corner in each of its triangles. Corners with equal coordinates in single precision are one point, before the
// scaling to metres: no tolerance can join points that are distinct in the file.
using Corners = std::array<std::array<float, 3>, 3>;

class Welder {
public:
    explicit Welder(double unit) : unit_(unit) {}
    void add(const Corners& corners) {
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
            ++without_area;
            return;
        }
        std::array<int, 3> triangle{};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [entry, fresh] = index_.try_emplace(corners[c], static_cast<int>(surface.points.size()));
            if (fresh) surface.points.push_back({unit_ * corners[c][0], unit_ * corners[c][1], unit_ * corners[c][2]});
            triangle[c] = entry->second;
        }
        surface.triangles.push_back(triangle);
    }
    TriangleSurface surface;
    long without_area = 0;

private:
    double unit_;
    std::unordered_map<std::array<float, 3>, int, PointHash> index_;
};

void require_finite(const Corners& corners, std::size_t triangle, const Path& path) {
    for (const auto& corner : corners)
        for (const float value : corner)
            if (!std::isfinite(value))
                throw UserError(
                    fmt::format("triangle {} of {} has a corner that is not finite in single precision", triangle + 1, path.string()),
                    {.fix = "export the surface again"});
}

void read_binary(const std::string& bytes, std::uint32_t count, const Path& path, Welder& welder) {
    for (std::size_t t = 0; t < count; ++t) {
        Corners corners{};
        // The 12 bytes of the normal are skipped: it follows from the corners.
        std::memcpy(corners.data(), bytes.data() + header_size + t * record_size + 12, sizeof corners);
        require_finite(corners, t, path);
        welder.add(corners);
    }
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

// The words of an ASCII file, which may be written in capitals and across lines; names reach to the end of their line.
class AsciiReader {
public:
    AsciiReader(const std::string& text, const Path& path, Welder& welder) : text_(text), path_(path), welder_(welder) {}

    void read() {
        bool inside = false;
        for (std::string word = next(); !word.empty(); word = next()) {
            const bool end = word == "endsolid" || word == "end";
            if (word == "end") require("solid");
            if (word == "solid" || end) {
                if (inside != end) refuse(word);
                inside = !end;
                at_ = std::min(text_.find('\n', at_), text_.size());  // the rest of the line is a name
            } else if (word == "facet" && inside) {
                read_facet();
            } else {
                refuse(word);
            }
        }
        if (inside)
            throw UserError(fmt::format("the STL file is incomplete: no `endsolid` follows triangle {} of {}", triangle_, path_.string()),
                            {.fix = "export or copy it again"});
    }

private:
    std::string next() {
        const auto blank = [&](std::size_t i) { return std::isspace(static_cast<unsigned char>(text_[i])) != 0; };
        while (at_ < text_.size() && blank(at_)) ++at_;
        const std::size_t start = at_;
        while (at_ < text_.size() && !blank(at_)) ++at_;
        return lower(text_.substr(start, at_ - start));
    }

    void require(const char* word) {
        if (const std::string found = next(); found != word) refuse(found);
    }

    [[noreturn]] void refuse(const std::string& word) const {
        if (word.empty())
            throw UserError(fmt::format("the STL file is incomplete: {} ends in triangle {}", path_.string(), triangle_ + 1),
                            {.fix = "export or copy it again"});
        throw UserError(fmt::format("\"{}\" is not expected in line {}, triangle {} of {}", word.substr(0, 40),
                                    1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'), triangle_ + 1,
                                    path_.string()),
                        {.allowed = "solid NAME, then for each triangle: facet normal, outer loop, three times vertex, endloop, endfacet; "
                                    "at the end endsolid",
                         .fix = "export it again, best as binary STL"});
    }

    float number() {
        const std::string word = next();
        if (word.empty()) refuse(word);
        const char *start = word.data() + (word.starts_with('+') ? 1 : 0), *stop = word.data() + word.size();
        double value = 0.0;
        // Independent of the locale's decimal sign.
        const auto [end, fault] = std::from_chars(start, stop, value);
        // Too small or too large for double precision: 0, or not finite.
        if (fault == std::errc::result_out_of_range && end == stop) value = std::strtod(start, nullptr);
        if ((fault != std::errc() && fault != std::errc::result_out_of_range) || end != stop)
            throw UserError(fmt::format("`{}` is not a number in triangle {} of {}", word.substr(0, 40), triangle_ + 1, path_.string()),
                            {.allowed = "numbers as -1.25e-3, with a decimal point", .fix = "export it again, best as binary STL"});
        return static_cast<float>(value);
    }

    void read_facet() {
        require("normal");
        for (int i = 0; i < 3; ++i) next();  // not used: it follows from the corners
        require("outer");
        require("loop");
        Corners corners{};
        for (auto& corner : corners) {
            require("vertex");
            for (float& value : corner) value = number();
        }
        end_of("loop");
        end_of("facet");
        require_finite(corners, triangle_, path_);
        welder_.add(corners);
        ++triangle_;
    }

    // "endloop" or "end loop"
    void end_of(const std::string& what) {
        const std::string word = next();
        if (word == "end") return require(what.c_str());
        if (word != "end" + what) refuse(word);
    }

    const std::string& text_;
    const Path& path_;
    Welder& welder_;
    std::size_t at_ = 0, triangle_ = 0;
};

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
    std::uint32_t count = 0;
    if (bytes.size() >= header_size) std::memcpy(&count, bytes.data() + 80, sizeof count);
    const std::size_t expected = header_size + record_size * static_cast<std::size_t>(count);
    // Binary files may begin with "solid" as well. The size decides: a file as long as its number of triangles says is binary.
    const std::string start = lower(bytes.substr(0, 1000));
    const std::size_t first = start.find_first_not_of(" \t\r\n");
    const bool ascii = bytes.size() != expected && first != std::string::npos && start.compare(first, 5, "solid") == 0 &&
                       start.find('\0') == std::string::npos;
    Welder welder(unit_m);
    if (ascii) {
        AsciiReader(bytes, path, welder).read();
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
        read_binary(bytes, count, path, welder);
    }
    if (welder.without_area > 0)
        log_warning(fmt::format("{} triangles of {} have two equal corners: they are left out", welder.without_area, path.string()));
    if (welder.surface.triangles.empty()) throw UserError("the STL file has no triangle with an area: " + path.string());
    return std::move(welder.surface);
}

}  // namespace porepack::io
