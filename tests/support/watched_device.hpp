// A device of this machine, with its traffic counted and with limits of its own.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "devices/device.hpp"

namespace porepack::test {

class WatchedDevice : public devices::Device {
public:
    explicit WatchedDevice(std::shared_ptr<devices::Device> device) : device_(std::move(device)), info_(device_->info()) {}

    std::size_t bytes_moved = 0, runs = 0;
    std::size_t largest_buffer = SIZE_MAX;   ///< a larger one is refused
    std::size_t runs_until_lost = SIZE_MAX;  ///< then the device is lost
    std::string replaced, by;                ///< in the text of programs

    [[nodiscard]] const devices::DeviceInfo& info() const override { return info_; }
    [[nodiscard]] std::unique_ptr<devices::Buffer> allocate(std::size_t bytes) override {
        if (bytes > largest_buffer) throw core::MachineError("too large");
        return device_->allocate(bytes);
    }
    void write(devices::Buffer& to, std::size_t byte, std::span<const std::byte> from) override {
        bytes_moved += from.size();
        device_->write(to, byte, from);
    }
    void read(const devices::Buffer& from, std::size_t byte, std::span<std::byte> to) override {
        bytes_moved += to.size();
        device_->read(from, byte, to);
    }
    void fill_with_zeros(devices::Buffer& buffer) override { device_->fill_with_zeros(buffer); }
    [[nodiscard]] std::shared_ptr<devices::Program> compile(const devices::ProgramText& text) override {
        std::string changed(text.text);
        if (const std::size_t at = replaced.empty() ? std::string::npos : changed.find(replaced); at != std::string::npos)
            changed.replace(at, replaced.size(), by);
        return device_->compile({.text = changed, .definitions = text.definitions, .ptx = text.ptx});
    }
    void run(devices::Program& program, const std::string& kernel, std::size_t groups, std::size_t group_size,
             std::span<const devices::Argument> arguments) override {
        if (++runs > runs_until_lost) throw devices::DeviceLost("the device was lost");
        device_->run(program, kernel, groups, group_size, arguments);
    }
    void finish() override { device_->finish(); }

private:
    std::shared_ptr<devices::Device> device_;
    devices::DeviceInfo info_;
};

}  // namespace porepack::test
