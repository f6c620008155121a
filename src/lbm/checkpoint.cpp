#include "lbm/checkpoint.hpp"

#include <cmath>
#include <cstring>
#include <fstream>

#include "core/error.hpp"
#include "core/members_json.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm {
namespace {

constexpr const char* key = "porepack_checkpoint";
constexpr const char* remove_it = "remove the file to start again";

[[noreturn]] void refuse(const Path& path, const std::string& why) {
    throw UserError("the checkpoint " + why, {.where = path.string(), .fix = remove_it});
}

template <typename Real>
bool all_finite(std::span<const std::byte> populations) {
    bool finite = true;
#pragma omp parallel for schedule(static) reduction(&& : finite)
    for (std::size_t i = 0; i < populations.size() / sizeof(Real); ++i) {
        Real value = 0;
        std::memcpy(&value, populations.data() + i * sizeof(Real), sizeof(Real));
        finite = finite && std::isfinite(value);
    }
    return finite;
}

std::ifstream open_behind_header(const Path& path, Json& header) {
    require_file(path);
    std::ifstream file(path, std::ios::binary);
    std::string line;
    if (!file || !std::getline(file, line)) refuse(path, "cannot be read");
    header = Json::parse(line, nullptr, false);
    if (header.is_discarded() || !header.is_object() || !header.contains(key)) refuse(path, "file is not a checkpoint");
    return file;
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

void write_checkpoint(const Path& path, const SavedRun& saved, std::span<const std::byte> populations) {
    Json header = json_of(saved);
    header[key] = 4;
    write_whole(path, [&](const Path& part) {
        std::ofstream file(part, std::ios::binary);
        file << header.dump() << '\n';
        file.write(reinterpret_cast<const char*>(populations.data()), static_cast<std::streamsize>(populations.size()));
        file.close();
        if (!file) throw MachineError("the checkpoint cannot be written", {.where = path.string(), .fix = "is the disk full?"});
    });
}

SavedRun read_checkpoint(const Path& path) {
    Json header;
    (void)open_behind_header(path, header);
    try {
        return from_json_members<SavedRun>(header);
    } catch (const UserError&) {
        refuse(path, "has another version");
    }
}

void read_checkpoint_populations(const Path& path, std::span<std::byte> populations, Precision precision) {
    Json header;
    std::ifstream file = open_behind_header(path, header);
    file.read(reinterpret_cast<char*>(populations.data()), static_cast<std::streamsize>(populations.size()));
    if (file.gcount() != static_cast<std::streamsize>(populations.size()) || file.peek() != std::char_traits<char>::eof())
        refuse(path, "has the wrong size");
    if (!(precision == Precision::single_precision ? all_finite<float>(populations) : all_finite<double>(populations)))
        refuse(path, "contains numbers that are not finite");
}

}  // namespace porepack::lbm
