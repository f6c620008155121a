// The program beside others: threads that wait, and programs that it has started.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "core/process.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::porepack;

// Waiting threads sleep: the settings must be there before OpenMP reads them, which is before main().
TEST(SharedProcessor, WaitingThreadsSleepUnlessTheUserSaysOtherwise) {
    const auto shown = porepack("--version", "env -u OMP_WAIT_POLICY -u GOMP_SPINCOUNT OMP_DISPLAY_ENV=verbose");
    EXPECT_TRUE(has(shown.err, "GOMP_SPINCOUNT = '3000'")) << shown.err;
    const auto users = porepack("--version", "env -u GOMP_SPINCOUNT OMP_WAIT_POLICY=active OMP_DISPLAY_ENV=verbose");
    EXPECT_TRUE(has(users.err, "OMP_WAIT_POLICY = 'ACTIVE'")) << users.err;
}

// kill -9 of the parent ends all child processes of a program, including grandchildren.
TEST(Guardian, NoOrphanOutlivesUs) {
    const test::Folder folder;
    const pid_t child = fork();
    if (child == 0) {
        (void)run_program(
            {.command = {"sh", "-c", "sleep 300 & echo $! > grandchild; wait"}, .folder = folder.path(), .log = folder.path() / "log"});
        _exit(0);
    }
    pid_t grandchild = 0;
    for (int i = 0; i < 100 && grandchild == 0; ++i) {
        usleep(50000);
        std::ifstream(folder.path() / "grandchild") >> grandchild;
    }
    ASSERT_GT(grandchild, 0);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    bool alive = true;
    for (int i = 0; i < 100 && alive; ++i) {
        usleep(50000);
        std::ifstream status("/proc/" + std::to_string(grandchild) + "/stat");
        std::string pid, name, state;
        alive = static_cast<bool>(status >> pid >> name >> state) && state != "Z";
    }
    EXPECT_FALSE(alive);
}

}  // namespace
}  // namespace porepack
