// The falling-head test: simulated, and measured curves.
#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "analysis/falling_head/level_curves.hpp"
#include "analysis/falling_head/simulation.hpp"
#include "bindings/host.hpp"
#include "bindings/objects.hpp"
#include "core/error.hpp"
#include "falling_head/level_curve.hpp"

namespace porepack::python {
namespace {

py::tuple falling_head(double permeability_m2, double inertial_permeability_m, bool with_curve, const py::dict& keys) {
    const auto config = config_of<falling_head::FallingHeadConfig>(keys, "falling_head()");
    const auto found = run([&] { return analysis::simulate_falling_head(permeability_m2, inertial_permeability_m, config, with_curve); });
    return py::make_tuple(to_python(found.result), with_curve ? py::object(py::str(found.files.tables.front().second.csv())) : py::none());
}

falling_head::LevelCurve curve_of(const py::handle& given, std::size_t number) {
    if (py::isinstance<py::str>(given)) return falling_head::read_level_curve(given.cast<std::string>());
    auto [time, level] = given.cast<std::pair<std::vector<double>, std::vector<double>>>();
    const std::string name = fmt::format("curve {}", number);
    if (time.size() != level.size())
        throw core::UserError(fmt::format("{} has {} times and {} levels", name, time.size(), level.size()),
                              {.where = "analyse_falling_head()", .allowed = "as many levels as times"});
    for (std::size_t n = 1; n < time.size(); ++n)
        if (!(time[n] > time[n - 1]))
            throw core::UserError(fmt::format("{}: time {} does not follow the one before", name, n),
                                  {.where = "analyse_falling_head()", .allowed = "times in ascending order, in seconds"});
    return {.name = name, .packing = {}, .time_s = std::move(time), .level_m = std::move(level)};
}

py::dict analyse(const py::list& given, const py::dict& keys) {
    const auto config = config_of<falling_head::FallingHeadConfig>(keys, "analyse_falling_head()");
    std::vector<falling_head::LevelCurve> curves;
    for (const py::handle one : given) curves.push_back(curve_of(one, curves.size()));
    if (curves.empty()) throw core::UserError("there is no curve", {.where = "analyse_falling_head()"});
    return to_python(run([&] { return analysis::analyse_level_curves(curves, config); }).result);
}

}  // namespace

void bind_falling_heads(py::module_& module) {
    module.def("falling_head", &falling_head);
    module.def("analyse_falling_head", &analyse);
}

}  // namespace porepack::python
