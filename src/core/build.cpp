#include "core/build.hpp"

#include "core/version.hpp"

namespace porepack::inline core {

const char* program_version() {
    return POREPACK_VERSION;
}

const char* git_hash() {
    return POREPACK_GIT_HASH;
}

}  // namespace porepack::inline core
