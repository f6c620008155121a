// The memory of the populations on a device.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "devices/device.hpp"

namespace porepack::lbm::opencl {

/// Numbers that are zero at first; in pieces of a power of two where the device gives no buffer for all.
template <typename Real>
class Store {
public:
    static constexpr std::size_t max_pieces = 8;  ///< as many arguments has a kernel of lattice.cl

    /// MachineError where the memory of the device is too small.
    Store(devices::Device& device, std::size_t numbers) : device_(device) {
        for (bits_ = std::bit_width(numbers); pieces_.empty(); --bits_) {
            const std::size_t piece = std::size_t{1} << static_cast<unsigned>(bits_), count = (numbers + piece - 1) / piece;
            try {
                for (std::size_t p = 0; p < count; ++p)
                    pieces_.push_back(device.allocate(sizeof(Real) * std::min(piece, numbers - p * piece)));
                for (auto& one : pieces_) device.fill_with_zeros(*one);  // drivers may take the memory only now
                break;
            } catch (const devices::DeviceLost&) {
                throw;
            } catch (const core::MachineError&) {
                pieces_.clear();
                if (2 * count > max_pieces) throw;  // half as large ones may be too many
            }
        }
    }
    [[nodiscard]] std::size_t pieces() const { return pieces_.size(); }
    [[nodiscard]] double bytes() const {
        double sum = 0.0;
        for (const auto& piece : pieces_) sum += static_cast<double>(piece->bytes());
        return sum;
    }
    void add_arguments(std::vector<devices::Argument>& list) const {
        for (std::size_t p = 0; p < (pieces() > 1 ? max_pieces : 1); ++p) list.emplace_back(*pieces_[std::min(p, pieces() - 1)]);
        if (pieces() > 1) list.emplace_back(static_cast<std::uint32_t>(bits_));
    }
    void read(std::size_t first, std::span<Real> numbers) const {
        for_pieces(first, numbers.size(), [&](std::size_t piece, std::size_t at, std::size_t from, std::size_t count) {
            device_.read(*pieces_[piece], at * sizeof(Real), std::as_writable_bytes(numbers.subspan(from, count)));
        });
    }
    void write(std::size_t first, std::span<const Real> numbers) {
        for_pieces(first, numbers.size(), [&](std::size_t piece, std::size_t at, std::size_t from, std::size_t count) {
            device_.write(*pieces_[piece], at * sizeof(Real), std::as_bytes(numbers.subspan(from, count)));
        });
    }

private:
    template <typename Visit>
    void for_pieces(std::size_t first, std::size_t count, const Visit& visit) const {
        const std::size_t piece = std::size_t{1} << static_cast<unsigned>(bits_);
        for (std::size_t done = 0; done < count;) {
            const std::size_t at = (first + done) % piece, here = std::min(count - done, piece - at);
            visit((first + done) / piece, at, done, here);
            done += here;
        }
    }
    devices::Device& device_;
    std::vector<std::unique_ptr<devices::Buffer>> pieces_;
    int bits_ = 0;
};

}  // namespace porepack::lbm::opencl
