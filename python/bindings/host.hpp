// Runs work of the library for a Python program: in a thread of its own, without the interpreter's lock, while the caller's thread
// passes on log and progress and looks for Ctrl-C.
#pragma once

#include <functional>
#include <optional>
#include <type_traits>
#include <utility>

namespace porepack::python {

/// Returns when the work has ended. The functions `on_log` and `on_progress` of porepack._host are called in the caller's thread. Ctrl-C,
/// or an exception of theirs, ends the work at its next check and is raised then; else what the work throws. `work` must not touch Python.
void run_in_thread(const std::function<void()>& work);

/// The same of work that returns something.
template <typename Work>
[[nodiscard]] auto run(Work&& work) {
    std::optional<std::invoke_result_t<Work>> result;
    run_in_thread([&] { result.emplace(work()); });
    return std::move(*result);
}

}  // namespace porepack::python
