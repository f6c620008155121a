// The schemas of docs/schema name all keys that results may have.
#include <set>
#include <string>

#include "core/json.hpp"
#include "results/descriptors.hpp"
#include "results/falling_head.hpp"
#include "results/foam.hpp"
#include "results/forchheimer.hpp"
#include "results/geometry.hpp"
#include "results/image.hpp"
#include "results/lbm.hpp"
#include "results/pack.hpp"
#include "results/seeds.hpp"
#include "results/shape.hpp"
#include "results/tortuosity.hpp"
#include "results/uncertainty.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

template <typename T>
concept HasMembers = requires(const T& part) {
    visit_members(part, [](const char*, const auto&) {});
};

template <HasMembers T>
void add_keys(const T& part, std::set<std::string>& keys) {
    visit_members(part, [&]<typename Member>(const char* name, const Member& member) {
        if (*name != '\0')
            keys.insert(name);
        else if constexpr (HasMembers<Member>)
            add_keys(member, keys);
        else if constexpr (requires { member.has_value(); })
            if constexpr (HasMembers<typename Member::value_type>) add_keys(typename Member::value_type{}, keys);
    });
}

template <typename Result>
void expect_all_keys(const Json& schema) {
    std::set<std::string> keys;
    add_keys(Result{}, keys);
    EXPECT_FALSE(keys.empty()) << Result::stage;
    const Json& known = schema.at("$defs").at(Result::stage).at("properties");
    for (const std::string& key : keys) EXPECT_TRUE(known.contains(key)) << Result::stage << ": " << key;
}

TEST(Schema, NamesAllKeysOfResults) {
    const Json schema = read_json(Path(POREPACK_SOURCE_FOLDER) / "docs/schema/result.schema.json");
    expect_all_keys<results::Shape>(schema);
    expect_all_keys<results::Pack>(schema);
    expect_all_keys<results::Image>(schema);
    expect_all_keys<results::Stl>(schema);
    expect_all_keys<results::Voxelise>(schema);
    expect_all_keys<results::Slices>(schema);
    expect_all_keys<results::Lbm>(schema);
    expect_all_keys<results::Foam>(schema);
    expect_all_keys<results::Tortuosity>(schema);
    expect_all_keys<results::Forchheimer>(schema);
    expect_all_keys<results::FallingHead>(schema);
    expect_all_keys<results::Causes>(schema);
    expect_all_keys<results::Seeds>(schema);
    expect_all_keys<results::Uncertainty>(schema);
    expect_all_keys<results::Descriptors>(schema);
}

}  // namespace
}  // namespace porepack
