// Parts of one computation in several threads.
#include "core/communicator.hpp"

#include <array>
#include <span>

#include "core/error.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

using test::message_of;

TEST(Communicator, APartThatFailsEndsTheOthers) {
    EXPECT_EQ(message_of<UserError>([] {
                  run_parts(3, [](const Communicator& parts) {
                      if (parts.part() == 1) throw UserError("the second part");
                      (void)parts.gather({});
                  });
              }),
              "the second part");
}

TEST(Communicator, AddsInTheOrderOfTheParts) {
    run_parts(4, [](const Communicator& parts) {
        std::array<double, 1> sum = {1.0};
        parts.in_turn(sum, [&] { sum[0] = 3.0 * sum[0] + parts.part(); });
        EXPECT_EQ(sum[0], 3.0 * (3.0 * (3.0 * 3.0 + 1.0) + 2.0) + 3.0);
        const std::array<int, 1> own = {parts.part()};
        std::array<int, 2> from{};
        const auto bytes = std::as_bytes(std::span(own));
        parts.exchange({bytes, bytes}, {std::as_writable_bytes(std::span(from).first(1)), std::as_writable_bytes(std::span(from).last(1))});
        EXPECT_EQ(from[0], (parts.part() + 3) % 4);
        EXPECT_EQ(from[1], (parts.part() + 1) % 4);
    });
}

}  // namespace
}  // namespace porepack
