// Runs the engines as programs. They end with this process: none keeps running after Ctrl-C or kill -9.
#pragma once

#include <csignal>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::inline core {

struct Program {
    std::vector<std::string> command;                     ///< program and arguments, no shell in between
    Path folder = ".";                                    ///< working folder
    Path log = {};                                        ///< stdout and stderr go here; if empty, to those of this process
    std::map<std::string, std::string> environment = {};  ///< added to the environment of this process
    std::function<void()> while_running = {};             ///< called every 0.2 s
    int stop_signal = SIGTERM;                            ///< when this process is interrupted; SIGKILL follows
    double stop_seconds = 0.2;                            ///< between the two, at most
};

struct ProgramEnd {
    int exit_code = 0;  ///< 128 + signal when a signal ended it
    double wall_time_s = 0.0;
    double peak_memory_bytes = 0.0;
};

/// Runs the program to its end. Throws EngineError when it cannot be started, MachineError when this process is interrupted.
/// The caller checks the exit code.
[[nodiscard]] ProgramEnd run_program(const Program& program);

/// Maximum memory of the programs run since the last call, in bytes.
[[nodiscard]] double take_peak_program_memory_bytes();

/// Full path of a program on PATH.
[[nodiscard]] std::optional<Path> find_program(const std::string& name);
/// The program porepack: the one that was set, or the one beside this program, or on PATH.
[[nodiscard]] std::optional<Path> porepack_program();
/// For a host that is another program.
void set_porepack_program(const Path& program);
/// Throws EngineError that names the Debian package to install.
void require_program(const std::string& name, const std::string& package);
/// First line of what a short command prints; empty when it fails.
[[nodiscard]] std::string first_line_of(const std::string& shell_command);

}  // namespace porepack::inline core
