// One flow on several ranks of MPI: the numbers and the files of one process, to the last bit.
#include <chrono>
#include <thread>

#include "core/files.hpp"
#include "core/json.hpp"
#include "packing/packing.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using namespace test;

const std::string mpirun = "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 60 mpirun --quiet --oversubscribe -np 2";

class Ranks : public testing::Test {
protected:
    // A bed in a cylinder, 2 high.
    void write_bed() {
        Packing bed = random_bed("cylinder:1,2", 30, 0.1);
        bed.overlap_allowed = true;
        write_packing(packing, bed);
    }
    Output lbm(const std::string& arguments, const std::string& output, const std::string& before = "") {
        return porepack("lbm " + quoted(packing) + " --output " + quoted(folder.path() / output) + " " + arguments, before);
    }

    Folder folder;
    Path packing = folder.path() / "packing.json";
};

// Costs and memory differ from run to run.
void remove_costs(Json& json) {
    if (json.is_object())
        for (const char* key : {"seconds", "set_up_seconds", "updates_per_second", "bytes_per_node", "peak_memory_bytes", "wall_time_s"})
            json.erase(key);
    if (json.is_structured())
        for (Json& part : json) remove_costs(part);
}

TEST_F(Ranks, GiveTheResultOfOneProcess) {
    REQUIRE_PROGRAM("mpirun");
    write_bed();
    const std::string of_bed = "--section 0.3,1.7 --voxel-size 0.05 ",
                      in_situ = "--section 0.7,1.3 --voxel-size 0.05 --ends in_situ --buffer 0.4 ";
    for (const std::string& scene : {of_bed, in_situ}) {
        const Output one = lbm(scene + "--json", "one", "OMP_NUM_THREADS=2");
        ASSERT_EQ(one.exit_code, 0) << one.err;
        Json expected = one.json();
        remove_costs(expected);
        for (const int ranks : {2, 3}) {
            const std::string name = "ranks_" + std::to_string(ranks);
            const Output several = lbm(scene + "--json --ranks " + std::to_string(ranks), name, "OMP_NUM_THREADS=1");
            ASSERT_EQ(several.exit_code, 0) << several.err;
            Json found = several.json();
            remove_costs(found);
            EXPECT_EQ(found, expected);
            EXPECT_TRUE(read_text(folder.path() / name / "flow.vti") == read_text(folder.path() / "one" / "flow.vti"));
        }
    }
}

TEST_F(Ranks, RefuseWhatTheyCannotDo) {
    REQUIRE_PROGRAM("mpirun");
    write_bed();
    for (const char* number : {"0", "-1", "1000000", "two"}) EXPECT_EQ(lbm(std::string("--ranks ") + number, "no").exit_code, 2) << number;
    const Output many = lbm("--section 0.3,1.7 --voxel-size 0.05 --ranks 9", "no");
    EXPECT_EQ(many.exit_code, 2);
    EXPECT_TRUE(has(many.err, "9 ranks are too many") && has(many.err, "up to 4")) << many.err;
    EXPECT_EQ(many.err.find("rank 1"), std::string::npos) << many.err;  // told once
    const Output a_case = porepack("lbm " + quoted(Path(POREPACK_SOURCE_FOLDER) / "cases/quickstart") + " --ranks 2");
    EXPECT_EQ(a_case.exit_code, 2);
    EXPECT_TRUE(has(a_case.err, "packing.json --ranks 2")) << a_case.err;
    const Output keys = porepack("keys", mpirun);
    EXPECT_EQ(keys.exit_code, 2);
    EXPECT_TRUE(has(keys.err, "started 2 times by mpirun")) << keys.err;
    const Output two = lbm("--ranks 3 --voxel-size 0.05 --section 0.3,1.7", "no", mpirun);
    EXPECT_EQ(two.exit_code, 2);
    EXPECT_TRUE(has(two.err, "the launcher has started 2")) << two.err;
    const Output without = lbm("--ranks 2 --voxel-size 0.05 --section 0.3,1.7", "no", "PATH=/nowhere");
    EXPECT_EQ(without.exit_code, 4);
    EXPECT_TRUE(has(without.err, "openmpi-bin")) << without.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "no" / "lbm.result.json"));
}

TEST_F(Ranks, PredictTheMemoryOfEach) {
    write_bed();
    const auto expected = [&](const std::string& ranks) {
        return lbm("--voxel-size 0.01 --dry-run --json" + ranks, "no").json().at("expected").dump();
    };
    EXPECT_TRUE(has(expected(" --ranks 4"), "4 ranks, memory of each"));
    EXPECT_FALSE(has(expected(""), "ranks"));
    const Output many = lbm("--voxel-size 0.05 --dry-run --section 0.3,1.7 --ranks 9", "no");
    EXPECT_TRUE(has(many.err, "9 ranks are too many") && has(many.err, "up to 4")) << many.err;
    if (!find_program("mpirun")) return;
    const Output started = lbm("--voxel-size 0.01 --dry-run", "no", mpirun);
    EXPECT_TRUE(has(started.out, "2 ranks, memory of each")) << started.err;
}

// A rank that is killed ends all.
TEST_F(Ranks, EndTogether) {
    REQUIRE_PROGRAM("mpirun");
    write_bed();
    const std::string mark = (folder.path() / "packing.json").string();
    const auto processes = [&] {
        return std::atoi(
            read_text([&] {
                const Path file = folder.path() / "count";
                (void)std::system(
                    ("pgrep -c -x -f -- " + quoted(std::string(POREPACK_PROGRAM) + " lbm " + mark + " .*") + " > " + quoted(file)).c_str());
                return file;
            }())
                .c_str());
    };
    int met = 0;
    std::thread killer([&] {
        for (int i = 0; i < 200 && met < 2; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            met = processes();
        }
        std::this_thread::sleep_for(std::chrono::seconds(1));
        (void)std::system(("pkill -9 -n -x -f -- " + quoted(std::string(POREPACK_PROGRAM) + " lbm " + mark + " .*")).c_str());
    });
    const Output killed = porepack("lbm " + quoted(mark) + " --output " + quoted(folder.path() / "no") + " --voxel-size 0.012 --ranks 2",
                                   "timeout 60 env OMP_NUM_THREADS=1");
    killer.join();
    EXPECT_EQ(met, 2);
    EXPECT_NE(killed.exit_code, 0);
    EXPECT_NE(killed.exit_code, 124);  // the launcher ended by itself
    EXPECT_EQ(processes(), 0);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "no" / "lbm.result.json"));
}

}  // namespace
}  // namespace porepack
