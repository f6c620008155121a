// Stacks of PNG files.
#include <fmt/format.h>
#include <itkPNGImageIO.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "imaging/itk_files.hpp"

namespace porepack::imaging {
namespace {

// Byte 25 of the file: 0 gray, 2 colours, 3 a lookup table, 4 and 6 with transparency.
void require_gray_png(const Path& path) {
    std::array<char, 26> start{};
    std::ifstream file(path, std::ios::binary);
    if (!file.read(start.data(), start.size()) || start[25] == 0) return;  // too short: the reader says so
    throw UserError(start[25] == 3 ? "the values of the image are places in a lookup table of colours" : "the image is in colours",
                    {.where = path.string(),
                     .allowed = "gray values, without transparency",
                     .fix = "save it as gray values: in ImageJ Image > Lookup Tables > Grays (the values stay), then save as TIFF"});
}

}  // namespace

FileVolume open_png_stack(const std::vector<Path>& files) {
    const auto open = [](const Path& path) {
        const auto io = itk::PNGImageIO::New();
        if (!io->CanReadFile(path.c_str()))
            throw UserError("not a PNG image, or a damaged one: " + path.string(), {.fix = "export this layer again"});
        require_gray_png(path);
        io->SetFileName(path.string());
        io->ReadImageInformation();
        return io;
    };
    const Json header = Json::parse(with_itk([&] { return files.front(); },
                                             [&] {
                                                 const auto first = open(files.front());
                                                 return Json{{"size", {first->GetDimensions(0), first->GetDimensions(1)}},
                                                             {"type", name_of(type_of(*first, files.front()))}}
                                                     .dump();
                                             }));
    const auto type = choice_named<ValueType>(header["type"].get<std::string>()).value();
    FileVolume volume{
        .voxels = {header["size"][0].get<std::int64_t>(), header["size"][1].get<std::int64_t>(), static_cast<std::int64_t>(files.size())},
        .type = type,
        .files = files};
    volume.format = fmt::format("PNG, {}, {} files, {} to {}", name_of(type), files.size(), files.front().filename().string(),
                                files.back().filename().string());
    const auto read_one = [open, type, n = volume.voxels, first = files.front().filename().string()](const Path& path, std::int64_t,
                                                                                                     std::span<char> bytes) {
        const auto io = open(path);
        if (static_cast<std::int64_t>(io->GetDimensions(0)) != n[0] || static_cast<std::int64_t>(io->GetDimensions(1)) != n[1] ||
            type_of(*io, path) != type)
            throw UserError("the image has another size or type than " + first, {.where = path.string()});
        read_all(*io, bytes, path);
    };
    volume.read = [layers = std::make_shared<LayerFiles>(files, type, volume.voxels[0] * volume.voxels[1], read_one)](
                      std::int64_t z, std::span<float> values) { layers->read(z, values); };
    return volume;
}

}  // namespace porepack::imaging
