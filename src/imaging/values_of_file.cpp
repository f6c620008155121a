#include "imaging/values_of_file.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"

namespace porepack::imaging {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 22;

// The bytes of a file from `start` on, or of what is packed there by gzip or zlib.
class Bytes {
public:
    Bytes(Path path, std::uint64_t start, bool packed)
        : path_(std::move(path)), start_(start), packed_(packed), input_(packed ? chunk : 0) {
        require_file(path_);
        file_.open(path_, std::ios::binary);
        if (!file_) throw UserError("the file cannot be opened: " + path_.string());
        if (packed_) rewind();
    }
    ~Bytes() { inflateEnd(&stream_); }
    Bytes(const Bytes&) = delete;
    Bytes& operator=(const Bytes&) = delete;

    void read(std::uint64_t at, char* into, std::size_t count) {
        if (packed_) {
            if (at < position_) rewind();
            std::vector<char> skipped(std::min<std::uint64_t>(chunk, at - position_));
            while (position_ < at)
                if (unpack(skipped.data(), std::min<std::uint64_t>(skipped.size(), at - position_)) == 0) too_short();
            while (count > 0) {
                const std::size_t got = unpack(into, count);
                if (got == 0) too_short();
                into += got;
                count -= got;
            }
            return;
        }
        file_.clear();
        file_.seekg(static_cast<std::streamoff>(start_ + at));
        if (!file_.read(into, static_cast<std::streamsize>(count))) too_short();
    }

    // True if nothing follows.
    bool ends_at(std::uint64_t at) {
        if (!packed_) return fs::file_size(path_) == start_ + at;
        char one = 0;
        return position_ == at && unpack(&one, 1) == 0;
    }

private:
    static constexpr std::size_t chunk = std::size_t{1} << 18;

    void rewind() {
        inflateEnd(&stream_);
        stream_ = {};
        if (inflateInit2(&stream_, 15 + 32) != Z_OK) throw MachineError("not enough memory to unpack " + path_.string());  // gzip or zlib
        file_.clear();
        file_.seekg(static_cast<std::streamoff>(start_));
        position_ = 0;
        ended_ = false;
    }

    // 0 at the end of the packed bytes.
    std::size_t unpack(char* into, std::size_t count) {
        stream_.next_out = reinterpret_cast<Bytef*>(into);
        stream_.avail_out = static_cast<uInt>(std::min(count, block_bytes));
        const uInt asked = stream_.avail_out;
        while (!ended_ && stream_.avail_out == asked) {
            if (stream_.avail_in == 0) {
                file_.read(input_.data(), static_cast<std::streamsize>(input_.size()));
                stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
                stream_.avail_in = static_cast<uInt>(file_.gcount());
                if (stream_.avail_in == 0) too_short();
            }
            const int state = inflate(&stream_, Z_NO_FLUSH);
            if (state == Z_STREAM_END)  // several gzip members may follow each other
                ended_ = stream_.avail_in == 0 && file_.peek() == std::ifstream::traits_type::eof();
            else if (state != Z_OK)
                too_short();
            if (state == Z_STREAM_END && !ended_ && inflateReset(&stream_) != Z_OK) too_short();
        }
        const std::size_t got = asked - stream_.avail_out;
        position_ += got;
        return got;
    }

    [[noreturn]] void too_short() const {
        throw UserError("the image ends before its last voxel, or is damaged: " + path_.string(), {.fix = "write it again"});
    }

    Path path_;
    std::uint64_t start_, position_ = 0;
    bool packed_, ended_ = false;
    std::ifstream file_;
    std::vector<char> input_;
    z_stream stream_ = {};
};

}  // namespace

void read_values(FileVolume& volume, const ValuesOfFile& of) {
    const auto bytes = std::make_shared<Bytes>(of.path, of.start, of.packed);
    const bool swapped = of.big_endian != (std::endian::native == std::endian::big);
    volume.sequential = of.packed;
    volume.files.push_back(of.path);
    const std::uint64_t size = size_of(volume.type), layer = static_cast<std::uint64_t>(volume.voxels[0] * volume.voxels[1]);
    const std::uint64_t end = of.skip + size * layer * static_cast<std::uint64_t>(volume.voxels[2]);
    if (!of.packed && !bytes->ends_at(end)) {
        const std::uint64_t found = fs::file_size(of.path) - std::min<std::uintmax_t>(of.start + of.skip, fs::file_size(of.path)),
                            wanted = end - of.skip;
        throw UserError(
            fmt::format("the data have {} bytes, and {} x {} x {} values of {} bytes are {}", found, volume.voxels[0], volume.voxels[1],
                        volume.voxels[2], size, wanted),
            {.where = of.path.string(),
             .fix = found > wanted
                        ? fmt::format(
                              "correct sizes and type; if {} bytes of another header come first: --image-header-bytes {} of a raw file",
                              found - wanted, of.skip + found - wanted)
                        : "correct the header, or of a raw file --image-dims, --image-type or --image-header-bytes; or the file is "
                          "incomplete"});
    }
    volume.read = [=, type = volume.type, path = of.path, packed = of.packed, skip = of.skip](std::int64_t first, std::span<float> values) {
        const std::size_t at_once = std::max<std::size_t>(1, block_bytes / size);
        std::vector<char> block(std::min(values.size(), at_once) * size);
        std::uint64_t at = skip + size * layer * static_cast<std::uint64_t>(first);
        for (std::size_t done = 0; done < values.size();) {
            const std::size_t count = std::min(at_once, values.size() - done);
            bytes->read(at, block.data(), count * size);
            if (swapped) swap_bytes(block.data(), size, count);
            to_float(block.data(), type, values.subspan(done, count), path);
            at += count * size;
            done += count;
        }
        if (packed && at == end && !bytes->ends_at(end))
            throw UserError("bytes follow the last voxel", {.where = path.string(), .fix = "correct --image-dims or --image-type"});
    };
}

}  // namespace porepack::imaging
