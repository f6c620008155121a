// The ranks of MPI: this program, started several times by mpirun or srun. The only folder with MPI.
#pragma once

namespace porepack::parallel {

/// Starts MPI if a launcher has started this process as one of several, and makes core::ranks() all of them. To be made in main().
class MpiRanks {
public:
    /// Threads: the cores to which the launcher has bound the rank, or those of its machine divided by the ranks on it, unless
    /// OMP_NUM_THREADS is set.
    /// Throws EngineError where this program was built without MPI and has been started several times.
    MpiRanks();
    /// Ends MPI, for which all ranks must come here.
    ~MpiRanks();
    MpiRanks(const MpiRanks&) = delete;
    MpiRanks& operator=(const MpiRanks&) = delete;
};

/// One rank fails: ends all of them, with this exit code. Does nothing if there is only one.
void end_all(int exit_code);

}  // namespace porepack::parallel
