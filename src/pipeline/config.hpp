// Table [parallel] of case.toml.
#pragma once

#include "record/config.hpp"

namespace porepack::pipeline {

struct ParallelConfig {
    long ranks = 1;
};

inline void describe(record::ConfigVisitor& v, ParallelConfig& c) {
    v.integer("ranks", c.ranks, record::between(1.0, 10000.0),
              "processes of MPI for each flow by lattice Boltzmann (docs/cluster.md); the result does not depend on them");
}

}  // namespace porepack::pipeline
