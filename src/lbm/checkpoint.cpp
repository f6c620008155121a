#include "lbm/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "core/communicator.hpp"
#include "core/error.hpp"
#include "core/members_json.hpp"
#include "core/shared_file.hpp"
#include "lbm/lattice.hpp"
#include "lbm/uses.hpp"
#include "pore_space/pore_space.hpp"
#include "record/resolved_config.hpp"

namespace porepack::lbm {
namespace {

constexpr const char* key = "porepack_checkpoint";
constexpr int version = 5;  // 4: the memory of one process
constexpr const char* remove_it = "remove the file to start again";

[[noreturn]] void refuse(const Path& path, const std::string& why) {
    throw UserError("the checkpoint " + why, {.where = path.string(), .fix = remove_it});
}

template <typename Real>
bool all_finite(std::span<const std::byte> populations) {
    for (std::size_t byte = 0; byte < populations.size(); byte += sizeof(Real)) {
        Real value = 0;
        std::memcpy(&value, populations.data() + byte, sizeof(Real));
        if (!std::isfinite(value)) return false;
    }
    return true;
}

std::size_t bytes_per_node(const Flow& flow) {
    return d3q19::directions * flow.bytes_per_number();
}

// Visits the nodes in blocks, with memory for the populations of each.
template <typename Visit>
void for_blocks(const Flow& flow, const Domain& domain, const Visit& visit) {
    constexpr std::size_t block_nodes = 64 * Flow::chunk;
    std::vector<std::byte> memory;
    for (std::size_t first = 0; first < domain.nodes(); first += block_nodes) {
        memory.resize(std::min(block_nodes, domain.nodes() - first) * bytes_per_node(flow));
        visit(first, std::span(memory));
    }
}

std::ifstream open_behind_header(const Path& path, Json& header) {
    require_file(path);
    std::ifstream file(path, std::ios::binary);
    std::string line;
    if (!file || !std::getline(file, line)) refuse(path, "cannot be read");
    header = Json::parse(line, nullptr, false);
    if (header.is_discarded() || !header.is_object() || !header.contains(key)) refuse(path, "file is not a checkpoint");
    if (header[key] != version) refuse(path, "has another version");
    return file;
}

// Of a list whose order does not matter: the entries are added after they were mixed (the finaliser of splitmix64).
constexpr std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ x >> 30U) * 0xbf58476d1ce4e5b9U;
    x = (x ^ x >> 27U) * 0x94d049bb133111ebU;
    return x ^ x >> 31U;
}

}  // namespace

template <MembersOf<SavedRun> Self, typename Visit>
void visit_members(Self& saved, const Visit& visit) {
    visit("run", saved.identity);
    visit("attempts", saved.attempts);
    visit("relaxation_time", saved.relaxation_time);
    visit("steps", saved.run.steps);
    visit("seconds", saved.run.seconds);
    visit("grids", saved.grids);
    visit("history", saved.run.history);
    visit("balance", saved.run.balance);
}

std::string identity_of(const PoreSpace& space, LbmConfig config, const Domain& domain) {
    config.max_time_s = config.checkpoint_minutes = 0.0;
    config.device = "cpu";  // another one may go on
    const Communicator& slabs = *domain.slabs;
    const std::uint64_t cells_below = domain.grid.index(0, 0, domain.grid.slab.first), nodes_below = sum_below(slabs, domain.nodes());
    std::array<std::uint64_t, 2> sums{};  // of cells with nodes, of walls
    domain.cells.for_each([&](std::size_t cell) { sums[0] += mixed(cells_below + cell + 1); });
    for (const WallLink& link : domain.walls)
        sums[1] += mixed((nodes_below + link.node + 1) << 21U | static_cast<std::uint64_t>(link.q) << 16U | link.distance);
    std::array<std::uint64_t, 2> all{};
    for (const Bytes& of_slab : slabs.gather(std::as_bytes(std::span(sums)))) {
        const std::vector<std::uint64_t> list = list_of<std::uint64_t>(of_slab);
        for (std::size_t i = 0; i < 2; ++i) all[i] += list[i];
    }
    return fmt::format("{} {} {} {} {:016x} {:016x}", record::resolved_config(config).dump(), name_of(space.ends), space.section.z0_m,
                       space.section.z1_m, all[0], all[1]);
}

void write_checkpoint(const Path& path, const SavedRun& saved, const Flow& flow, const Domain& domain) {
    Json header = json_of(saved);
    header[key] = version;
    const std::string line = header.dump() + '\n';  // that of the first slab; the seconds of the others differ
    const auto header_bytes = static_cast<std::uint64_t>(agreed(*domain.slabs, static_cast<double>(line.size())));
    std::uint64_t byte = header_bytes + sum_below(*domain.slabs, domain.nodes()) * bytes_per_node(flow);
    write_together(path, "the checkpoint", *domain.slabs, [&](SharedFile& file) {
        if (domain.slabs->part() == 0) file.write(0, std::as_bytes(std::span(line)));
        for_blocks(flow, domain, [&](std::size_t first, std::span<std::byte> block) {
            flow.populations(first, block);
            file.write(byte, block);
            byte += block.size();
        });
    });
}

SavedRun read_checkpoint(const Path& path) {
    Json header;
    (void)open_behind_header(path, header);
    try {
        return from_json_members<SavedRun>(header);
    } catch (const UserError&) {
        refuse(path, "has not the expected content");
    }
}

void read_checkpoint_populations(const Path& path, Flow& flow, const Domain& domain) {
    Json header;
    std::ifstream file = open_behind_header(path, header);
    const auto header_bytes = static_cast<std::uint64_t>(file.tellg());
    if (std::filesystem::file_size(path) != header_bytes + static_cast<std::uint64_t>(domain.all_nodes) * bytes_per_node(flow))
        refuse(path, "has the wrong size");
    file.seekg(static_cast<std::streamoff>(header_bytes + sum_below(*domain.slabs, domain.nodes()) * bytes_per_node(flow)));
    for_blocks(flow, domain, [&](std::size_t first, std::span<std::byte> block) {
        file.read(reinterpret_cast<char*>(block.data()), static_cast<std::streamsize>(block.size()));
        if (!file) refuse(path, "cannot be read");
        if (!(flow.bytes_per_number() == sizeof(float) ? all_finite<float>(block) : all_finite<double>(block)))
            refuse(path, "contains numbers that are not finite");
        flow.set_populations(first, block);
    });
}

}  // namespace porepack::lbm
