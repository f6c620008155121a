// Structs to JSON and back.
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/members_json.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

struct Part {
    double length_m = 0.0;
    std::optional<double> error;
};
template <MembersOf<Part> Self, typename Visit>
void visit_members(Self& part, const Visit& visit) {
    visit("length_m", part.length_m);
    visit("error", part.error);
}
struct Whole {
    std::vector<Part> parts;
    Interval interval;
    std::string name;
};
template <MembersOf<Whole> Self, typename Visit>
void visit_members(Self& whole, const Visit& visit) {
    visit("parts", whole.parts);
    visit("interval", whole.interval);
    visit("name", whole.name);
}

struct Flattened {
    OptionalKey<Part> part;
    OptionalKey<double> slope;
    ByName<long> counts;
    double unknown = std::numeric_limits<double>::quiet_NaN();
};
template <MembersOf<Flattened> Self, typename Visit>
void visit_members(Self& flattened, const Visit& visit) {
    visit("", flattened.part);
    visit("slope", flattened.slope);
    visit("counts", flattened.counts);
    visit("unknown", flattened.unknown);
    double twice = flattened.slope ? 2.0 * *flattened.slope : 0.0;
    visit("twice", twice);
}

TEST(Members, GoToJsonAndBack) {
    const Whole whole{.parts = {{0.1, std::nullopt}, {0.2, 1e-3}}, .interval = {1.0, 2.0}, .name = "bed"};
    const Json json = json_of(whole);
    EXPECT_EQ(json.dump(), R"({"parts":[{"length_m":0.1,"error":null},{"length_m":0.2,"error":0.001}],"interval":[1.0,2.0],"name":"bed"})");
    const auto back = from_json_members<Whole>(json);
    EXPECT_EQ(json_of(back), json);
    // A key that is missing, or holds something else, is named, with the document.
    const auto message = [](const char* text) {
        return test::message_of<UserError>([&] { (void)from_json_members<Whole>(Json::parse(text), "bed.json"); });
    };
    const std::string missing = message(R"({"parts":[{"length_m":0.1,"error":null},{"error":null}],"interval":[1,2],"name":"bed"})");
    EXPECT_TRUE(test::has(missing, "the key `parts[1].length_m` is missing") && test::has(missing, "bed.json")) << missing;
    const std::string other = message(R"({"parts":[{"length_m":"long","error":null}],"interval":[1,2],"name":"bed"})");
    EXPECT_TRUE(test::has(other, "`parts[0].length_m` is \"long\"")) << other;
    EXPECT_TRUE(test::has(message(R"({"parts":[],"interval":[1],"name":"bed"})"), "`interval` is [1]"));

    // Keys that may be absent.
    EXPECT_EQ(json_of(Flattened{}).dump(), R"({"counts":{},"unknown":null,"twice":0.0})");
    const Flattened all{.part = Part{0.1, std::nullopt}, .slope = 2.0, .counts = {{"b", 1}, {"a", 2}}};
    const std::string text = json_of(all).dump();
    EXPECT_EQ(text, R"({"length_m":0.1,"error":null,"slope":2.0,"counts":{"b":1,"a":2},"unknown":null,"twice":4.0})");
    const auto again = from_json_members<Flattened>(Json::parse(text));
    EXPECT_EQ(json_of(again).dump(), text);
    EXPECT_EQ(*find(again.counts, "a"), 2);
    EXPECT_EQ(find(again.counts, "c"), nullptr);
    EXPECT_FALSE(from_json_members<Flattened>(Json::parse(R"({"counts":{},"unknown":null,"twice":0.0})")).part);
}

}  // namespace
}  // namespace porepack
