// One flow on several ranks of MPI: the numbers and the files of one process, to the last bit.
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

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
        for (const char* key : {"seconds", "set_up_seconds", "updates_per_second", "bytes_per_node", "peak_memory_bytes",
                                "expected_memory_bytes", "wall_time_s"})
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
    const Output a_case = porepack("lbm " + quoted(Path(POREPACK_SOURCE_FOLDER) / "cases/quickstart"), mpirun);
    EXPECT_EQ(a_case.exit_code, 2);
    EXPECT_TRUE(has(a_case.err, "a case starts its ranks itself")) << a_case.err;
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
    EXPECT_TRUE(has(expected(" --ranks 4"), "4 ranks with "));
    EXPECT_FALSE(has(expected(""), "ranks"));
    const Output many = lbm("--voxel-size 0.05 --dry-run --section 0.3,1.7 --ranks 9", "no");
    EXPECT_TRUE(has(many.err, "9 ranks are too many") && has(many.err, "up to 4")) << many.err;
    if (!find_program("mpirun")) return;
    const Output started = lbm("--voxel-size 0.01 --dry-run", "no", mpirun);
    EXPECT_TRUE(has(started.out, "2 ranks with ")) << started.err;
}

// The processes of a run on this packing.
class Processes {
public:
    Processes(const Path& folder, const Path& packing) : folder_(folder), mark_(packing.string()) {}
    [[nodiscard]] std::vector<int> ranks() const { return found(std::string(POREPACK_PROGRAM) + " lbm " + mark_ + " .*", "-x"); }
    [[nodiscard]] std::vector<int> all() const { return found(mark_, ""); }
    // Waits for the ranks and their starter, and some time after that.
    [[nodiscard]] bool wait_for(std::size_t number, double seconds_more) const {
        for (int i = 0; i < 400; ++i) {
            if (ranks().size() >= number) {
                std::this_thread::sleep_for(std::chrono::duration<double>(seconds_more));
                return true;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(25));
        }
        return false;
    }
    [[nodiscard]] bool end_within(double seconds) const {
        for (double waited = 0.0; waited < seconds; waited += 0.1) {
            if (all().empty()) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        return false;
    }

private:
    [[nodiscard]] std::vector<int> found(const std::string& pattern, const std::string& whole) const {
        const Path list = folder_ / "processes";
        (void)std::system(("pgrep " + whole + " -f -- " + quoted(pattern) + " > " + quoted(list)).c_str());
        std::istringstream lines(read_text(list));
        std::vector<int> ids;
        for (int id = 0; lines >> id;)
            if (const std::string name = name_of(id); name == "porepack" || name == "mpirun") ids.push_back(id);
        return ids;
    }
    static std::string name_of(int process) {
        std::ifstream file("/proc/" + std::to_string(process) + "/comm");
        std::string name;
        file >> name;
        return name;
    }
    Path folder_;
    std::string mark_;
};

// Whoever is killed, all end, and the run goes on from its checkpoint, on another number of ranks.
TEST_F(Ranks, EndTogetherAndResume) {
    REQUIRE_PROGRAM("mpirun");
    write_bed();
    const std::string scene = "--section 0.3,1.7 --voxel-size 0.016 --checkpoint-minutes 1e-3 ";
    ASSERT_EQ(lbm(scene, "whole", "OMP_NUM_THREADS=2").exit_code, 0);
    const Processes processes(folder.path(), packing);
    const Path checkpoint = folder.path() / "parts" / "lbm.checkpoint";
    enum class Victim { rank, launcher, starter };
    for (const Victim victim : {Victim::rank, Victim::launcher, Victim::starter}) {
        bool met = false;
        std::thread killer([&] {
            for (int i = 0; i < 200 && !std::filesystem::exists(checkpoint); ++i)
                std::this_thread::sleep_for(std::chrono::milliseconds(50));
            met = processes.wait_for(3, 0.05);
            const std::vector<int> all = processes.all(),
                                   ranks = processes.ranks();  // the starter, mpirun and two ranks, as they were started
            if (!met || all.size() < 4) return;
            kill(victim == Victim::rank ? ranks.back() : victim == Victim::launcher ? all[1] : all[0], SIGKILL);
        });
        const Output killed = lbm(scene + "--ranks 2", "parts", "timeout 60 env OMP_NUM_THREADS=1");
        killer.join();
        EXPECT_TRUE(met);
        EXPECT_NE(killed.exit_code, 0);
        EXPECT_NE(killed.exit_code, 124);
        EXPECT_TRUE(processes.end_within(10.0)) << static_cast<int>(victim);
        EXPECT_TRUE(std::filesystem::exists(checkpoint));
        EXPECT_FALSE(std::filesystem::exists(folder.path() / "parts" / "lbm.result.json"));
        if (victim == Victim::rank) {
            EXPECT_TRUE(has(killed.err, "one of the 2 ranks has ended without a message")) << killed.err;
        }
    }
    const Output rest = lbm(scene + "--ranks 3", "parts", "OMP_NUM_THREADS=1");
    ASSERT_EQ(rest.exit_code, 0) << rest.err;
    EXPECT_TRUE(has(rest.err, "resumes from"));
    EXPECT_TRUE(read_text(folder.path() / "parts" / "flow.vti") == read_text(folder.path() / "whole" / "flow.vti"));
    EXPECT_FALSE(std::filesystem::exists(checkpoint));
}

// Ctrl-C: they write a checkpoint before they end.
TEST_F(Ranks, SaveTheirStateWhenInterrupted) {
    REQUIRE_PROGRAM("mpirun");
    write_bed();
    const std::string scene = "--section 0.3,1.7 --voxel-size 0.02 ";
    ASSERT_EQ(lbm(scene, "whole", "OMP_NUM_THREADS=2").exit_code, 0);
    const Path checkpoint = folder.path() / "parts" / "lbm.checkpoint";
    for (double seconds = 1.0; seconds < 10.0 && !std::filesystem::exists(checkpoint); seconds += 0.3) {
        const Output stopped = lbm(scene + "--ranks 2", "parts", "timeout -s INT " + std::to_string(seconds) + " env OMP_NUM_THREADS=1");
        if (stopped.exit_code == 0) break;
        EXPECT_TRUE(has(stopped.err, "error: interrupted")) << stopped.err;
        EXPECT_EQ(stopped.err.find("rank 1"), std::string::npos) << stopped.err;
    }
    ASSERT_TRUE(std::filesystem::exists(checkpoint));
    const Output rest = lbm(scene, "parts", "OMP_NUM_THREADS=2");
    ASSERT_EQ(rest.exit_code, 0) << rest.err;
    EXPECT_TRUE(has(rest.err, "resumes from"));
    EXPECT_TRUE(read_text(folder.path() / "parts" / "flow.vti") == read_text(folder.path() / "whole" / "flow.vti"));
}

// The part of the second rank lies beyond the largest size that a file may have.
TEST_F(Ranks, SayThatTheDiskIsFull) {
    REQUIRE_PROGRAM("mpirun");
    write_bed();
    const Output full = lbm("--section 0.3,1.7 --voxel-size 0.0125 --grids 1 --checkpoint-minutes 1e-4 --ranks 2", "full",
                            "ulimit -f 120000; timeout 60 env OMP_NUM_THREADS=1");
    EXPECT_EQ(full.exit_code, 5);
    EXPECT_TRUE(has(full.err, "rank 1: the checkpoint cannot be written")) << full.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "full" / "lbm.checkpoint"));
}

TEST_F(Ranks, ComputeTheFlowsOfACase) {
    REQUIRE_PROGRAM("mpirun");
    write_bed();
    const Path the_case = folder.path() / "case";
    folder.write(
        "case/case.toml",
        "[shape]\nkind = \"tetrapod\"\ndiameter_m = 0.2\nlength_m = 0.2\n[container]\nkind = \"cylinder\"\ndiameter_m = 1\nheight_m = 2\n"
        "[packing]\nengine = \"none\"\nfile = \"../packing.json\"\n[geometry]\nsection_m = [0.3, 1.7]\nvoxel_size_m = 0.05\n"
        "[forchheimer]\nenabled = true\nreynolds = [2, 5, 10]\nvoxel_size_m = 0.06\ngrids = 1\nopenfoam = false\n"
        "[parallel]\nranks = 2\n");
    for (const std::string stage : {"lbm", "forchheimer"}) {
        std::map<std::string, Json> results;
        for (const std::string ranks : {"1", "2"}) {
            const Path output = folder.path() / ("ranks_" + ranks);
            const Output ran = porepack(
                "run " + quoted(the_case) + " --up-to " + stage + " --output " + quoted(output) + (ranks == "1" ? " --ranks 1" : ""),
                "OMP_NUM_THREADS=1");
            ASSERT_EQ(ran.exit_code, 0) << ran.err;
            results[ranks] = read_json(output / stage / "result.json");
            remove_costs(results[ranks]);
            EXPECT_EQ(read_json(output / stage / "manifest.json").at("processes"), std::stoi(ranks));
        }
        EXPECT_EQ(results["1"], results["2"]);
    }
    EXPECT_TRUE(read_text(folder.path() / "ranks_1/lbm/flow.vti") == read_text(folder.path() / "ranks_2/lbm/flow.vti"));
    // The number of ranks makes no result stale.
    const Output again = porepack("run " + quoted(the_case) + " --up-to lbm --ranks 3 --output " + quoted(folder.path() / "ranks_2"));
    EXPECT_TRUE(has(again.err, "lbm: already done")) << again.err;
    const Output plan = porepack("run " + quoted(the_case) + " --up-to lbm --ranks 40 --dry-run");
    EXPECT_EQ(plan.exit_code, 2);
    EXPECT_TRUE(has(plan.err, "40 ranks are too many")) << plan.err;
    const Output loose = porepack("forchheimer " + quoted(packing) + " --section 0.3,1.7 --voxel-size 0.06 --grids 1 --reynolds 2,5,10 " +
                                      "--openfoam false --ranks 2 --json --output " + quoted(folder.path() / "loose"),
                                  "OMP_NUM_THREADS=1");
    ASSERT_EQ(loose.exit_code, 0) << loose.err;
    EXPECT_EQ(loose.json().at("inertial_permeability_m"),
              read_json(folder.path() / "ranks_1/forchheimer/result.json").at("inertial_permeability_m"));
}

}  // namespace
}  // namespace porepack
