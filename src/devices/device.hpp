// Devices that run kernels beside the processor: graphics cards and what else has a driver for OpenCL. Their libraries are opened when a
// device is asked for, so that a program without them works.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/error.hpp"

namespace porepack::devices {

struct DeviceInfo {
    std::string id;    ///< "opencl:0", "cuda:0"
    std::string name;  ///< as its driver calls it
    std::string driver;
    double memory_bytes = 0.0, largest_buffer_bytes = 0.0;
    bool graphics = false;  ///< false: the processor itself, through a driver
};

/// The device no longer answers; what was in its memory is lost.
struct DeviceLost : core::MachineError {
    using core::MachineError::MachineError;
};

/// Memory of a device, freed with the object.
class Buffer {
public:
    virtual ~Buffer() = default;
    [[nodiscard]] virtual std::size_t bytes() const = 0;
};

/// Compiled kernels.
class Program {
public:
    virtual ~Program() = default;
};

/// A program as text: OpenCL C 1.2, with the macros of kernel_language.cl, by which it is CUDA too.
struct ProgramText {
    std::string_view text;
    std::vector<std::string> definitions;  ///< "DOUBLE", "PIECES=4"
    const char* ptx = nullptr;  ///< the same with these definitions, compiled for CUDA when the program was built; null if it was not
};
/// kernel_language.cl, which begins each text.
extern const std::string_view kernel_language;

/// An argument of a kernel: a buffer, a number or struct, or so many bytes that the threads of a group share (of these, one at most).
class Argument {
public:
    struct SharedBytes {
        std::size_t bytes;
    };
    Argument(const Buffer& buffer) : value(&buffer) {}
    Argument(SharedBytes bytes) : value(bytes) {}
    template <typename T>
    requires std::is_trivially_copyable_v<T> &&(!std::is_convertible_v<T, const Buffer&>)Argument(const T& number)
        : value(bytes_of(number)) {}

    const std::variant<const Buffer*, SharedBytes, std::vector<std::byte>> value;

private:
    template <typename T>
    static std::vector<std::byte> bytes_of(const T& number) {
        const auto bytes = std::as_bytes(std::span(&number, 1));
        return {bytes.begin(), bytes.end()};
    }
};

/// What is run is done in this order; write() and read() return when they are done. DeviceLost, or MachineError where memory lacks.
class Device {
public:
    virtual ~Device() = default;
    [[nodiscard]] virtual const DeviceInfo& info() const = 0;
    [[nodiscard]] virtual std::unique_ptr<Buffer> allocate(std::size_t bytes) = 0;
    virtual void write(Buffer& to, std::size_t byte, std::span<const std::byte> from) = 0;
    virtual void read(const Buffer& from, std::size_t byte, std::span<std::byte> to) = 0;
    virtual void fill_with_zeros(Buffer& buffer) = 0;
    /// The same program for the same text.
    [[nodiscard]] virtual std::shared_ptr<Program> compile(const ProgramText& text) = 0;
    /// Starts so many groups of `group_size` threads.
    virtual void run(Program& program, const std::string& kernel, std::size_t groups, std::size_t group_size,
                     std::span<const Argument> arguments) = 0;
    virtual void finish() = 0;
};

/// All that can be found on this machine.
[[nodiscard]] std::vector<DeviceInfo> find_devices();
/// `id`: "opencl:0", "cuda:0", or "gpu": the first graphics card, by CUDA if that is there. UserError where there is none of this name,
/// with those that are.
[[nodiscard]] std::shared_ptr<Device> open_device(const std::string& id);
/// True for "cpu", "gpu", and the ids that find_devices() can give.
[[nodiscard]] bool is_device_name(const std::string& id);
/// Bytes per second of a copy from a buffer to another, read and written, the best of several.
[[nodiscard]] double copy_bandwidth(Device& device);

}  // namespace porepack::devices
