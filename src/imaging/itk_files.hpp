// What the readers by ITK share: a process of their own, and layers with a file each. Only for the sources of this folder.
#pragma once

#include <itkImageIOBase.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/files.hpp"
#include "core/own_process.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/layer_files.hpp"

namespace porepack::imaging {

[[nodiscard]] ValueType type_of(const itk::ImageIOBase& io, const core::Path& path);
/// Runs `work` in a process of its own: ITK and the libraries below it abort on some damaged files, print their own remarks, and name their
/// own sources in errors. file(): the one that is being read.
std::string with_itk(const std::function<core::Path()>& file, const std::function<std::string()>& work);
/// All of the image, in its own type.
void read_all(itk::ImageIOBase& io, std::span<char> bytes, const core::Path& path);
/// Throws MachineError.
void require_memory(double bytes, const core::Path& path);

// Layers with a file each, read block by block in a process that may crash.
class LayerFiles {
public:
    using ReadOne = std::function<void(const core::Path& file, std::int64_t z, std::span<char> bytes)>;
    LayerFiles(std::vector<core::Path> files, ValueType type, std::int64_t values_per_layer, ReadOne read_one)
        : files_(std::move(files)),
          type_(type),
          values_(static_cast<std::size_t>(values_per_layer)),
          bytes_(values_ * size_of(type)),
          read_one_(std::move(read_one)),
          per_block_(std::clamp<std::int64_t>(static_cast<std::int64_t>(block_bytes / std::max<std::size_t>(bytes_, 1)), 1,
                                              static_cast<std::int64_t>(files_.size()))) {}

    void read(std::int64_t z, std::span<float> values);

private:
    static constexpr std::size_t block_bytes = 64U << 20U;

    void read_block(std::int64_t block);

    std::vector<core::Path> files_;
    ValueType type_;
    std::size_t values_, bytes_;
    ReadOne read_one_;
    std::int64_t per_block_, block_ = -1;
    std::optional<core::SharedBytes> shared_;
};

}  // namespace porepack::imaging
