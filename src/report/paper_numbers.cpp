// What the paper states for its grains, beside what was computed.
#include <cmath>
#include <string>

#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace {

// Numbers of the paper (section 8 of its results) for this grain, if there are any.
struct PaperNumber {
    const char *kind, *quantity, *text;
    double sphericity;
};
constexpr PaperNumber paper_numbers[] = {
    {"tetrapod", "porosity", "0.70 (DEM), 0.685 (CT)", 0.53},
    {"tetrapod", "porosity", "0.78 (DEM)", 0.47},
    {"tetrapod", "tortuosity", "1.58 (DEM), 1.61 (CT)", 0.53},
    {"tetrahedron", "tortuosity", "2.4 (DEM)", 0.74},
};

}  // namespace

std::string paper_number(const ReportInput& input, const std::string& quantity) {
    const auto& shape = input.results.shape;
    if (!shape || !shape->sphericity) return "";
    for (const auto& entry : paper_numbers)
        if (shape->kind == entry.kind && quantity == entry.quantity && std::abs(*shape->sphericity - entry.sphericity) < 0.006)
            return entry.text;
    return "";
}

}  // namespace porepack::report
