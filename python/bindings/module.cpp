// The module porepack._core, on which the package porepack stands.
#include <dlfcn.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

#include <exception>
#include <filesystem>
#include <string>

#include "bindings/objects.hpp"
#include "core/build.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/process.hpp"
#include "stages/settings.hpp"

namespace porepack::python {
namespace {

void raise(const char* kind, const std::string& fault, const core::Advice& advice) {
    const py::object type = py::module_::import("porepack._errors").attr(kind);
    PyErr_SetObject(type.ptr(), type(fault, advice.where, advice.allowed, advice.fix).ptr());
}

void translate(std::exception_ptr thrown) {
    try {
        if (thrown) std::rethrow_exception(thrown);
    } catch (const core::Error& error) {
        const char* kind = error.code() == core::ExitCode::user        ? "UserError"
                           : error.code() == core::ExitCode::numerical ? "NumericalError"
                           : error.code() == core::ExitCode::engine    ? "EngineError"
                                                                       : "MachineError";
        raise(kind, error.fault(), error.advice());
    } catch (const std::filesystem::filesystem_error& error) {
        raise("MachineError", "cannot use " + error.path1().string() + ": " + error.code().message(), {});
    }
}

// Of one table: rows of key, unit, type, allowed, default, meaning.
py::list keys_of_table(const std::string& table) {
    stages::Settings settings;
    py::list rows;
    for (const record::KeyRow& row : record::key_rows(settings.describe_table(table)))
        rows.append(py::make_tuple(row.key, row.unit, row.type, row.allowed, row.standard, row.meaning));
    return rows;
}

// Files and program that belong to this build: in the package of a wheel, else in the prefix or the build folder that the package lies in.
void find_own_files() {
    Dl_info own{};
    if (dladdr(reinterpret_cast<const void*>(&keys_of_table), &own) == 0) return;
    const std::filesystem::path package = std::filesystem::path(own.dli_fname).parent_path();
    const std::filesystem::path prefix = package / ".." / ".." / ".." / "..";
    for (const auto& data : {package / "data", prefix / "share" / "porepack"})
        if (std::filesystem::exists(data / "liggghts_templates")) {
            core::set_data_folder(data);
            break;
        }
    for (const auto& program : {package / ".." / ".." / "porepack", prefix / "bin" / "porepack"})
        if (std::filesystem::is_regular_file(program) && access(program.c_str(), X_OK) == 0) return core::set_porepack_program(program);
}

}  // namespace
}  // namespace porepack::python

PYBIND11_MODULE(_core, module) {
    using namespace porepack::python;
    find_own_files();
    py::register_exception_translator(&translate);
    bind_packings(module);
    bind_pore_spaces(module);
    bind_flows(module);
    bind_scans(module);
    bind_falling_heads(module);
    bind_cases(module);
    module.def("version", [] { return std::string(porepack::core::program_version()); });
    module.def("git_hash", [] { return std::string(porepack::core::git_hash()); });
    module.def("keys_of_table", &keys_of_table);
    module.def("flag_of", [](const std::string& key) { return porepack::record::flag_of(key); });
}
