#include "lbm/checkpoint.hpp"

#include <cmath>
#include <cstring>
#include <fstream>

#include "core/error.hpp"

namespace porepack {
namespace {

constexpr const char* key = "porepack_checkpoint";
constexpr const char* remove_it = "remove the file to begin anew";

[[noreturn]] void refuse(const Path& path, const std::string& why) {
    throw UserError("the checkpoint " + why, {.where = path.string(), .mend = remove_it});
}

template <typename Real>
bool all_finite(std::span<const std::byte> state) {
    bool finite = true;
#pragma omp parallel for schedule(static) reduction(&& : finite)
    for (std::size_t i = 0; i < state.size() / sizeof(Real); ++i) {
        Real value = 0;
        std::memcpy(&value, state.data() + i * sizeof(Real), sizeof(Real));
        finite = finite && std::isfinite(value);
    }
    return finite;
}

std::ifstream open_behind_header(const Path& path, Json& header) {
    std::ifstream file(path, std::ios::binary);
    std::string line;
    if (!file || !std::getline(file, line)) refuse(path, "cannot be read");
    header = Json::parse(line, nullptr, false);
    if (header.is_discarded() || !header.is_object() || !header.contains(key)) refuse(path, "is none");
    return file;
}

}  // namespace

void write_checkpoint(const Path& path, const Json& header, std::span<const std::byte> state) {
    Json marked = header;
    marked[key] = 1;
    write_whole(path, [&](const Path& part) {
        std::ofstream file(part, std::ios::binary);
        file << marked.dump() << '\n';
        file.write(reinterpret_cast<const char*>(state.data()), static_cast<std::streamsize>(state.size()));
        file.close();
        if (!file) throw MachineError("the checkpoint cannot be written", {.where = path.string(), .mend = "is the disk full?"});
    });
}

Json read_checkpoint_header(const Path& path) {
    Json header;
    (void)open_behind_header(path, header);
    return header;
}

void read_checkpoint_state(const Path& path, std::span<std::byte> state, std::size_t bytes_a_number) {
    Json header;
    std::ifstream file = open_behind_header(path, header);
    file.read(reinterpret_cast<char*>(state.data()), static_cast<std::streamsize>(state.size()));
    if (file.gcount() != static_cast<std::streamsize>(state.size()) || file.peek() != std::char_traits<char>::eof())
        refuse(path, "has the wrong size");
    if (!(bytes_a_number == 4 ? all_finite<float>(state) : all_finite<double>(state))) refuse(path, "holds numbers that are not finite");
}

}  // namespace porepack
