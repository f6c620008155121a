// Runs the engines as programs. They die with us: no orphan goes on after Ctrl-C or kill -9.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::core {

struct Program {
    std::vector<std::string> command;                     ///< program and arguments, no shell in between
    Path folder = ".";                                    ///< where it runs
    Path log;                                             ///< stdout and stderr go here
    std::map<std::string, std::string> environment = {};  ///< added to ours
    std::function<void()> while_running = {};             ///< called every 0.2 s
};

struct ProgramEnd {
    int exit_code = 0;  ///< 128 + signal when a signal ended it
    double wall_time_s = 0.0;
    double peak_memory_bytes = 0.0;
};

/// Runs to the end. Throws EngineError when the program cannot be started, MachineError when we are interrupted meanwhile.
/// A bad exit code is the caller's to judge.
[[nodiscard]] ProgramEnd run_program(const Program& program);

/// Largest memory of a program run since the last call of this, in bytes.
[[nodiscard]] double take_peak_program_memory_bytes();

/// Full path of a program on PATH.
[[nodiscard]] std::optional<Path> find_program(const std::string& name);
/// Throws EngineError that names the Debian package to install.
void require_program(const std::string& name, const std::string& package);
/// First line of what a short command prints; empty when it fails.
[[nodiscard]] std::string first_line_of(const std::string& shell_command);

}  // namespace porepack::core
