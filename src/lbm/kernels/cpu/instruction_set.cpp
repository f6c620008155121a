#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <span>
#include <string>

#include "core/error.hpp"
#include "lbm/kernels/cpu/kernel.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm::cpu {

namespace baseline {
extern const KernelFunctions<float> single_precision;
extern const KernelFunctions<double> double_precision;
}  // namespace baseline
#ifdef POREPACK_X86_SETS
namespace avx2 {
extern const KernelFunctions<float> single_precision;
extern const KernelFunctions<double> double_precision;
}  // namespace avx2
namespace avx512 {
extern const KernelFunctions<float> single_precision;
extern const KernelFunctions<double> double_precision;
}  // namespace avx512
#endif

std::span<const InstructionSet> instruction_sets() {
    static const std::array sets = {
        InstructionSet{"baseline", [] { return true; }, &baseline::single_precision, &baseline::double_precision},
#ifdef POREPACK_X86_SETS
        InstructionSet{"avx2", [] { return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0; },
                       &avx2::single_precision, &avx2::double_precision},
        InstructionSet{"avx512",
                       [] {
                           return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
                                  __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512dq") != 0;
                       },
                       &avx512::single_precision, &avx512::double_precision},
#endif
    };
    return sets;
}

const InstructionSet& chosen_instruction_set() {
    const auto sets = instruction_sets();
    if (const char* wanted = std::getenv("POREPACK_INSTRUCTION_SET")) {
        std::string known;
        for (const InstructionSet& set : sets) {
            known += (known.empty() ? "" : ", ") + std::string(set.name);
            if (std::string(wanted) != set.name) continue;
            if (!set.runs_here())
                throw UserError(fmt::format("this processor does not have the instruction set {}", wanted),
                                {.where = "POREPACK_INSTRUCTION_SET", .fix = "unset it: the best one is chosen"});
            return set;
        }
        throw UserError(fmt::format("no such instruction set: {}", wanted), {.where = "POREPACK_INSTRUCTION_SET", .allowed = known});
    }
    const InstructionSet* best = &sets.front();
    for (const InstructionSet& set : sets)
        if (set.runs_here()) best = &set;
    return *best;
}

}  // namespace porepack::lbm::cpu
