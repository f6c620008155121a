#include "report/bed_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/json.hpp"
#include "report/page.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace {

const Path library = "/usr/share/javascript/three", licence = "/usr/share/doc/libjs-three/copyright";

template <typename Number>
std::string base64_of(const std::vector<Number>& numbers) {
    std::string bytes(numbers.size() * sizeof(Number), '\0');
    if (!numbers.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
    return base64(bytes);
}

Json json_of_surface(const geometry::TriangleSurface& surface) {
    std::vector<float> points;
    std::vector<std::uint32_t> corners;
    for (const auto& point : surface.points)
        for (const double x : point) points.push_back(static_cast<float>(x));
    for (const auto& triangle : surface.triangles)
        for (const int corner : triangle) corners.push_back(static_cast<std::uint32_t>(corner));
    return {{"points", base64_of(points)}, {"triangles", base64_of(corners)}};
}

std::string data_of(const BedView& bed) {
    Json json = {{"low_m", bed.low_m}, {"high_m", bed.high_m}, {"kinds", Json::array()}};
    for (const BedView::Kind& kind : bed.kinds) {
        json["kinds"].push_back(json_of_surface(kind.surface));
        json["kinds"].back()["name"] = kind.name;
    }
    std::vector<float> poses;
    json["kind_of_grain"] = json["contacts"] = Json::array();
    for (const BedView::Grain& grain : bed.grains) {
        for (const double x : grain.position_m) poses.push_back(static_cast<float>(x));
        for (const double x : grain.orientation) poses.push_back(static_cast<float>(x));
        json["kind_of_grain"].push_back(grain.kind);
        json["contacts"].push_back(grain.neighbours);
    }
    json["poses"] = base64_of(poses);
    if (!bed.vessel.triangles.empty()) json["vessel"] = json_of_surface(bed.vessel);
    std::vector<float> lines;  // x, y, z, speed
    for (const BedView::Line& line : bed.streamlines) {
        json["points_of_lines"].push_back(line.points_m.size());
        for (std::size_t p = 0; p < line.points_m.size(); ++p) {
            for (const double x : line.points_m[p]) lines.push_back(static_cast<float>(x));
            lines.push_back(static_cast<float>(line.speeds_m_per_s[p]));
        }
    }
    if (!lines.empty()) json["lines"] = base64_of(lines);
    json["flow"] = bed.flow;
    if (const auto& slice = bed.slice) {
        json["slice"] = {{"normal", slice->normal}, {"at_m", slice->at_m},     {"low_m", slice->low_m},  {"size_m", slice->size_m},
                         {"width", slice->width},   {"height", slice->height}, {"values", Json::array()}};
        for (const auto& values : slice->values)
            json["slice"]["values"].push_back({{"name", values.name},
                                               {"unit", values.unit},
                                               {"range", {values.range.low, values.range.high}},
                                               {"bytes", base64_of(values.bytes)}});
    }
    if (const auto& scan = bed.scan)
        json["scan"] = {{"voxels", scan->voxels},
                        {"low_m", scan->low_m},
                        {"size_m", scan->size_m},
                        {"range", {scan->range.low, scan->range.high}},
                        {"bytes", base64_of(scan->bytes)}};
    if (bed.section_m) json["section_m"] = {bed.section_m->low, bed.section_m->high};
    // No text of a user ends the script.
    std::string text;
    for (const char c : json.dump(-1, ' ', true, Json::error_handler_t::replace)) c == '<' ? text += "\\u003c" : text += c;
    return text;
}

// Inside a comment of JavaScript.
std::string licence_text() {
    if (!std::filesystem::exists(licence)) return "three.js, MIT licence, https://threejs.org/license";
    std::string text = read_text(licence);
    for (std::size_t at = 0; (at = text.find("*/", at)) != std::string::npos;) text.replace(at, 2, "* /");
    return text;
}

std::string script(const std::string& text) {
    return "<script>\n" + text + "\n</script>\n";
}

}  // namespace

void require_three() {
    if (!std::filesystem::exists(library / "three.min.js"))
        throw EngineError("three.js is not installed", {.fix = "apt-get install --no-install-recommends libjs-three"});
}

std::string bed_view_html(const BedView& bed) {
    require_three();
    const auto own = [](const char* name) { return read_text(data_file(Path("templates") / name)); };
    return "<style>\n" + own("bed_view.css") + "</style>\n" +
           filled(own("bed_view.html"), {{"label", for_html(bed.text)}, {"data", data_of(bed)}}) +
           script("/*\n" + licence_text() + "*/\n" + read_text(library / "three.min.js") + "\n" +
                  read_text(library / "examples/js/controls/OrbitControls.js")) +
           script(own("bed_view.js"));
}

void write_bed_page(const Path& html, const std::string& title, const BedView& bed) {
    write_text(html, filled(read_text(data_file("templates/bed_page.html")),
                            {{"title", for_html(title)}, {"text", for_html(bed.text)}, {"bed", bed_view_html(bed)}}));
}

}  // namespace porepack::report
