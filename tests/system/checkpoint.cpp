// A lattice Boltzmann run that was killed resumes from its checkpoint.
#include <filesystem>
#include <fstream>
#include <string>

#include "packing/packing.hpp"
#include "record/digest.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;
using test::quoted;

class Checkpoint : public ::testing::Test {
protected:
    void SetUp() override {
        Packing packing{
            .container = parse_container("cylinder:0.03,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
        for (int i = 0; i < 5; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.004 * (i % 2), 0.0, 0.005 + 0.0105 * i)});
        write_packing(folder_.path() / "packing.json", packing);
    }
    test::Output run(const std::string& more, const std::string& before = "") {
        return porepack("lbm --section 0.005,0.045 --voxel-size 6e-4 --iteration-tolerance 1e-4 --grids 2 --relaxation-time 1.2 " + more +
                            " " + quoted(folder_.path() / "packing.json"),
                        before);
    }
    // Runs that are stopped later and later, until one leaves a checkpoint.
    void stop(const std::string& signal, const std::string& more) {
        for (double seconds = 0.15; seconds < 120.0 && !std::filesystem::exists(checkpoint()); seconds *= 1.3)
            run(more, "timeout -s " + signal + " " + std::to_string(seconds));
        ASSERT_TRUE(std::filesystem::exists(checkpoint()));
    }
    [[nodiscard]] Path checkpoint() const { return folder_.path() / "lbm.checkpoint"; }

    test::Folder folder_;
};

TEST_F(Checkpoint, AKilledRunEndsWithTheSameBits) {
    ASSERT_EQ(run("").exit_code, 0);
    EXPECT_FALSE(std::filesystem::exists(checkpoint()));
    const std::string whole = sha256_of_file(folder_.path() / "flow.vti");
    std::filesystem::remove(folder_.path() / "flow.vti");
    stop("KILL", "--checkpoint-minutes 1e-3");
    ASSERT_FALSE(std::filesystem::exists(folder_.path() / "flow.vti"));
    const auto rest = run("");
    EXPECT_EQ(rest.exit_code, 0) << rest.err;
    EXPECT_TRUE(has(rest.err, "resumes from"));
    EXPECT_EQ(sha256_of_file(folder_.path() / "flow.vti"), whole);
    EXPECT_FALSE(std::filesystem::exists(checkpoint()));
}

TEST_F(Checkpoint, OfAnotherRunOrWithNaNIsRefused) {
    stop("INT", "");
    const auto other = run("--precision single");
    EXPECT_EQ(other.exit_code, 2);
    EXPECT_TRUE(has(other.err, "of another run"));
    // A case whose keys have changed since it was interrupted starts again.
    folder_.write("case.toml",
                  "[shape]\nkind = \"sphere\"\ndiameter_m = 0.01\n[container]\nkind = \"cylinder\"\ndiameter_m = 0.03\nheight_m = 0.06\n"
                  "[packing]\nengine = \"none\"\nfile = \"packing.json\"\n[geometry]\nsection_m = [0.005, 0.045]\n"
                  "voxel_size_m = 1e-3\n[lbm]\nfields = \"none\"\n");
    std::filesystem::create_directories(folder_.path() / "results");
    std::filesystem::copy_file(checkpoint(), folder_.path() / "results" / "lbm.checkpoint");
    const auto the_case = porepack("run --up-to lbm " + quoted(folder_.path()));
    EXPECT_EQ(the_case.exit_code, 0) << the_case.err;
    EXPECT_TRUE(has(the_case.err, "is of other settings and is removed")) << the_case.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "results" / "lbm.checkpoint"));
    std::fstream file(checkpoint(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-4096, std::ios::end);
    for (int i = 0; i < 8; ++i) file.put(static_cast<char>(0xFF));
    file.close();
    const auto nan = run("");
    EXPECT_EQ(nan.exit_code, 2);
    EXPECT_TRUE(has(nan.err, "not finite"));
    std::ofstream(checkpoint(), std::ios::binary) << "nonsense";
    EXPECT_TRUE(has(run("").err, "the checkpoint file is not a checkpoint"));
}

}  // namespace
}  // namespace porepack
