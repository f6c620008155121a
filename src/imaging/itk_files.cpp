#include "imaging/itk_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"

namespace porepack::imaging {

ValueType type_of(const itk::ImageIOBase& io, const Path& path) {
    using Type = itk::CommonEnums::IOComponent;
    static const std::map<Type, ValueType> types = {{Type::UCHAR, ValueType::uint8},   {Type::CHAR, ValueType::int8},
                                                    {Type::USHORT, ValueType::uint16}, {Type::SHORT, ValueType::int16},
                                                    {Type::UINT, ValueType::uint32},   {Type::INT, ValueType::int32},
                                                    {Type::FLOAT, ValueType::float32}, {Type::DOUBLE, ValueType::float64}};
    const auto found = types.find(io.GetComponentType());
    if (found == types.end() || io.GetNumberOfComponents() != 1)
        throw UserError(fmt::format("the image has {} values of type {} per voxel", io.GetNumberOfComponents(),
                                    itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType())),
                        {.where = path.string(), .allowed = "one value per voxel: 8, 16 or 32 bits, or floating point"});
    return found->second;
}

std::string with_itk(const std::function<Path()>& file, const std::function<std::string()>& work) {
    const auto what = [&] { return "the image cannot be read: " + file().string(); };
    return in_own_process(
        [&]() -> std::string {
            try {
                return work();
            } catch (const itk::ExceptionObject&) {
                throw UserError(what(), {.fix = "the file may be incomplete or damaged: write it again"});
            }
        },
        what);
}

void require_memory(double bytes, const Path& path) {
    if (const double free = available_memory_bytes(); free > 0.0 && bytes > 0.9 * free)
        throw MachineError(fmt::format("the image needs {}, and {} are free", human_bytes(bytes), human_bytes(free)),
                           {.where = path.string(),
                            .fix = "convert it on a larger machine to a format that is read layer by layer: porepack image convert"});
}

void read_all(itk::ImageIOBase& io, std::span<char> bytes, const Path& path) {
    if (static_cast<std::size_t>(io.GetImageSizeInBytes()) != bytes.size())
        throw UserError("the image has another size than its first layer", {.where = path.string()});
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned i = 0; i < io.GetNumberOfDimensions(); ++i) region.SetSize(i, io.GetDimensions(i));
    io.SetIORegion(region);
    io.Read(bytes.data());
}

void LayerFiles::read(std::int64_t z, std::span<float> values) {
    for (std::size_t done = 0; done < values.size(); done += values_, ++z) {
        if (z / per_block_ != block_) read_block(z / per_block_);
        const auto layer = static_cast<std::size_t>(z % per_block_);
        to_float(shared_->bytes().subspan(layer * bytes_, bytes_).data(), type_, values.subspan(done, values_),
                 files_[static_cast<std::size_t>(z)]);
    }
}

void LayerFiles::read_block(std::int64_t block) {
    block_ = -1;
    if (!shared_) {
        require_memory(static_cast<double>(bytes_) * static_cast<double>(per_block_), files_.front());
        shared_.emplace(bytes_ * static_cast<std::size_t>(per_block_));
    }
    const std::int64_t first = block * per_block_, end = std::min(first + per_block_, static_cast<std::int64_t>(files_.size()));
    const SharedBytes place(sizeof first);  // of the layer that is being read, where the process ends in it
    const auto file = [&] {
        std::int64_t z = 0;
        std::memcpy(&z, place.bytes().data(), sizeof z);
        return files_[static_cast<std::size_t>(z)];
    };
    (void)with_itk(file, [&] {
        for (std::int64_t z = first; z < end; ++z) {
            std::memcpy(place.bytes().data(), &z, sizeof z);
            read_one_(files_[static_cast<std::size_t>(z)], z,
                      shared_->bytes().subspan(static_cast<std::size_t>(z - first) * bytes_, bytes_));
        }
        return std::string();
    });
    block_ = block;
}

}  // namespace porepack::imaging
