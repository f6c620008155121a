// OpenFOAM in practical use: by hand and by the driver, in parallel, interrupted, on bad surfaces, on a full disk. Skipped visibly where
// it is not installed.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "core/json.hpp"
#include "openfoam/foam.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::quoted;
namespace fs = std::filesystem;

const Path cases = Path(POREPACK_SOURCE_FOLDER) / "openfoam_cases";

// A pillar of spheres in a square box: small, and the flow passes on all sides.
FoamScene pillar() {
    Packing packing{
        .container = parse_container("box:0.02,0.02,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.012, 0.0)}, .bodies = {}};
    for (int i = 0; i < 4; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.0095, 0.0105, 0.007 + 0.0125 * i)});
    FoamScene scene{.surface = make_surface(packing, {}).surface,
                    .container = packing.container,
                    .section = {0.02, 0.04},
                    .pore_volume_m3 = 0.0,
                    .grain_size_m = 0.012,
                    .pore_point = Vec3(0.00201, 0.00202, 0.03003)};
    scene.pore_volume_m3 = porosity(Grains(packing), packing.container, scene.section).value * 0.02 * 0.02 * 0.02;
    return scene;
}
constexpr double cell = 1.25e-3;

// A copy of the cases in a separate folder, as a user has it.
Path copy_of_cases(const test::Folder& folder) {
    const Path copy = folder.path() / "openfoam_cases";
    fs::copy(cases, copy, fs::copy_options::recursive);
    return copy;
}

struct ByHand {
    int exit_code;
    std::string text;
};
ByHand by_hand(const Path& folder, const std::string& before = "") {
    const Path log = folder.parent_path() / "by_hand.log";
    const int status = std::system((before + " " + quoted(folder / "Allrun") + " > " + quoted(log) + " 2>&1").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, read_text(log)};
}

// An environment in which a program is missing.
std::string without(const std::string& program, const Path& links) {
    return "mkdir -p " + quoted(links) + " && ln -sf /usr/bin/* /bin/* " + quoted(links) + "/ 2> /dev/null; rm -f " +
           quoted(links / program) + "; PATH=" + quoted(links);
}

TEST(OpenFoam, DriverHandAndTwoProcessesGiveTheSameFlow) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const FoamResult serial = foam_permeability(pillar(), {.meshes = 1}, cell, cases, folder.path() / "serial");
    const FoamResult parallel = foam_permeability(pillar(), {.meshes = 1, .processes = 2}, cell, cases, folder.path() / "parallel");
    EXPECT_EQ(parallel.fine().processes, find_program("mpirun") ? 2 : 1);
    // Meshed on two processes: another mesh of the same quality. On a bed of 1e6 cells k changed by less than 5e-4.
    EXPECT_NEAR(parallel.permeability_m2 / serial.permeability_m2, 1.0, 2e-3);
    EXPECT_NEAR(static_cast<double>(parallel.fine().cells) / static_cast<double>(serial.fine().cells), 1.0, 0.01);
    EXPECT_NEAR(parallel.fine().mesh_volume_ratio, serial.fine().mesh_volume_ratio, 1e-3);
    EXPECT_FALSE(fs::exists(folder.path() / "parallel" / "mesh_fine" / "processor0"));

    const Path mesh = folder.path() / "serial" / "mesh_fine",
               rates = mesh / "postProcessing" / "outletFlow" / "0" / "surfaceFieldValue.dat";
    const std::string flow = read_text(rates);
    // VTK reads every time that case.foam offers: the initial fields with their macros are not among them.
    for (const auto& entry : fs::directory_iterator(mesh)) {
        const std::string name = entry.path().filename();
        if (name.find_first_not_of("0123456789") != std::string::npos) continue;
        const std::string field = read_text(entry.path() / "p");
        EXPECT_EQ(field.find('$', field.find("boundaryField")), std::string::npos) << entry.path();
        EXPECT_NE(name, "0");
    }
    EXPECT_TRUE(has(by_hand(mesh).text, "simpleFoam: already done"));
    ASSERT_EQ(std::system((quoted(mesh / "Allclean")).c_str()), 0);
    EXPECT_FALSE(fs::exists(rates));
    EXPECT_EQ(by_hand(mesh).exit_code, 0);
    EXPECT_EQ(read_text(rates), flow);

    // Without mpirun it still runs, and prints a note.
    const Path parallel_mesh = folder.path() / "parallel" / "mesh_fine";
    ASSERT_EQ(std::system((quoted(parallel_mesh / "Allclean")).c_str()), 0);
    const ByHand alone = by_hand(parallel_mesh, without("mpirun", folder.path() / "links"));
    EXPECT_EQ(alone.exit_code, 0) << alone.text;
    EXPECT_TRUE(has(alone.text, "mpirun is not installed"));
}

TEST(OpenFoam, AStoppedSolverGoesOn) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const FoamConfig config{.meshes = 1, .residual = 1e-10};
    const Path mesh = folder.path() / "stopped" / "mesh_fine";
    const double whole = foam_permeability(pillar(), config, cell, cases, folder.path() / "whole").permeability_m2;
    (void)foam_permeability(pillar(), config, cell, cases, folder.path() / "stopped");
    // The files of a killed run: times up to 100, the last one incomplete, rows of the flow rate beyond it.
    fs::remove(mesh / "log.simpleFoam.done");
    std::vector<int> times;
    for (const auto& entry : fs::directory_iterator(mesh))
        if (const int time = std::atoi(entry.path().filename().c_str()); time > 0) times.push_back(time);
    ASSERT_EQ(times.size(), 2U);
    const int newest = std::max(times[0], times[1]), before = std::min(times[0], times[1]);
    fs::resize_file(mesh / std::to_string(newest) / "U", 5000);
    const FoamResult rest = foam_permeability(pillar(), config, cell, cases, folder.path() / "stopped");
    EXPECT_TRUE(has(read_text(mesh / "log.Allrun"), "resumes from iteration " + std::to_string(before)));
    EXPECT_TRUE(has(read_text(mesh / "log.Allrun"), "snappyHexMesh: already done"));
    EXPECT_NEAR(rest.permeability_m2 / whole, 1.0, 1e-8);
    EXPECT_NEAR(static_cast<double>(rest.fine().iterations), newest, 20.0);

    // Other settings start over.
    const FoamResult other = foam_permeability(pillar(), {.meshes = 1, .residual = 1e-4}, cell, cases, folder.path() / "stopped");
    EXPECT_LT(other.fine().iterations, before);
}

TEST(OpenFoam, AKilledDriverGoesOn) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    Packing packing{
        .container = parse_container("box:0.02,0.02,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.012, 0.0)}, .bodies = {}};
    for (int i = 0; i < 4; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.0095, 0.0105, 0.007 + 0.0125 * i)});
    write_packing(folder.path() / "packing.json", packing);
    const std::string command =
        "foam --section 0.02,0.04 --cell-size 8e-4 --levels 1 --residual 1e-12 " + quoted(folder.path() / "packing.json");
    const Path solver_log = folder.path() / ".foam.running" / "foam" / "mesh_fine" / "log.simpleFoam";
    std::thread killer([&] {
        for (int i = 0; i < 600 && !fs::exists(solver_log); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
        (void)std::system(("pkill -9 -f -- " + quoted("--residual 1e-12 " + (folder.path() / "packing.json").string())).c_str());
    });
    EXPECT_NE(test::porepack(command).exit_code, 0);
    killer.join();
    EXPECT_TRUE(fs::exists(solver_log));
    const auto rest = test::porepack(command);
    ASSERT_EQ(rest.exit_code, 0) << rest.err;
    EXPECT_TRUE(has(read_text(folder.path() / "foam" / "mesh_fine" / "log.Allrun"), "snappyHexMesh: already done"));
    EXPECT_FALSE(fs::exists(folder.path() / ".foam.running"));
}

TEST(OpenFoam, BadSurfacesAreSeen) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const FoamConfig config{.meshes = 1};
    const auto message = [&](const char* name, const FoamScene& scene) {
        return test::message_of<EngineError>([&] { (void)foam_permeability(scene, config, cell, cases, folder.path() / name); });
    };
    FoamScene open = pillar();
    open.surface.triangles.resize(open.surface.triangles.size() - 40);
    EXPECT_TRUE(has(message("open", open), "not a closed surface"));
    FoamScene empty = pillar();
    empty.surface = {};
    EXPECT_TRUE(has(message("empty", empty), "not a closed surface"));
    FoamScene millimetres = pillar();
    for (auto& point : millimetres.surface.points)
        for (double& x : point) x *= 1000.0;
    EXPECT_TRUE(has(message("millimetres", millimetres), "millimetres"));

    // Truncated during copying by hand.
    const Path user = copy_of_cases(folder) / "stokes_packing", stl = user / "constant" / "triSurface" / "solid.stl";
    const ByHand none = by_hand(user);
    EXPECT_EQ(none.exit_code, 2);
    EXPECT_TRUE(has(none.text, "put the grains' closed surface"));
    write_stl(stl, pillar().surface);
    fs::resize_file(stl, fs::file_size(stl) / 2);
    const ByHand cut = by_hand(user);
    EXPECT_EQ(cut.exit_code, 2);
    EXPECT_TRUE(has(cut.text, "not a closed surface"));
}

TEST(OpenFoam, BadMeshesAndFlowsAreSeen) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    FoamScene outside = pillar();
    outside.pore_point = Vec3(0.5, 0.5, 0.5);
    EXPECT_TRUE(
        has(test::message_of<EngineError>([&] { (void)foam_permeability(outside, {.meshes = 1}, cell, cases, folder.path() / "outside"); }),
            "OpenFOAM"));
    FoamScene other = pillar();
    other.pore_volume_m3 *= 1.1;
    EXPECT_TRUE(
        has(test::message_of<EngineError>([&] { (void)foam_permeability(other, {.meshes = 1}, cell, cases, folder.path() / "other"); }),
            "lost or invented pore space"));
    // Linear solvers that stop at 1e-3: flow and residuals no longer change, and the run is not converged.
    const Path user = copy_of_cases(folder);
    const Path settings = user / "stokes_packing" / "system" / "fvSolution";
    std::string text = read_text(settings);
    text.replace(text.find("tolerance 1e-14"), 15, "tolerance 1e-3");
    write_text(settings, text);
    EXPECT_TRUE(has(test::message_of<NumericalError>([&] {
                        (void)foam_permeability(pillar(), {.meshes = 1, .max_iterations = 200}, cell, user, folder.path() / "stall");
                    }),
                    "did not converge"));
}

TEST(OpenFoam, AFullDiskIsAnError) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const Path user = copy_of_cases(folder) / "stokes_packing";
    write_stl(user / "constant" / "triSurface" / "solid.stl", pillar().surface);
    write_text(user / "system" / "caseParameters",
               "xMin 0; xMax 0.02; yMin 0; yMax 0.02; zMin 0.02; zMax 0.04; nx 16; ny 16; nz 16; wallRadius 1; surfaceLevel 1;\n"
               "locationInMesh (0.00201 0.00202 0.03003); viscosity 1; pressureDrop 1; relaxationU 0.95; relaxationP 0.15;\n"
               "residual 1e-6; maxIterations 1000; processes 1;\n");
    for (const int kilobytes : {100, 800})
        EXPECT_NE(by_hand(user, "ulimit -f " + std::to_string(kilobytes) + ";").exit_code, 0) << kilobytes;
    const ByHand room = by_hand(user);
    EXPECT_EQ(room.exit_code, 0) << room.text;
}

TEST(OpenFoam, AnUnknownVersionIsNamed) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const Path user = copy_of_cases(folder);
    std::string functions = read_text(user / "runFunctions");
    functions.replace(functions.find("known_versions=\"1912\""), 21, "known_versions=\"2112\"");
    write_text(user / "runFunctions", functions);
    (void)foam_permeability(pillar(), {.meshes = 1}, 2e-3, user, folder.path() / "run");
    EXPECT_TRUE(has(read_text(folder.path() / "run" / "mesh_fine" / "log.Allrun"), "were not run with OpenFOAM 1912; known: 2112"));
}

// One period of three layers in a box that is periodic in x and y, against the cell that is periodic in all directions.
TEST(OpenFoam, APeriodOfLayersHasThePermeabilityOfThePeriodicCell) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    const auto k_of = [&](const char* name, double height, bool periodic_z, const std::vector<double>& layers, const std::string& flags) {
        Json packing = {
            {"format", "porepack-packing"},
            {"version", 1},
            {"container", {{"kind", "box"}, {"size_m", {0.01, 0.01, height}}, {"periodic", {true, true, periodic_z}}}},
            {"shapes",
             {{{"id", "sphere"}, {"cavity", "filled"}, {"capsules", {{{"a_m", {0, 0, 0}}, {"b_m", {0, 0, 0}}, {"radius_m", 0.0043}}}}}}},
            {"bodies", Json::array()}};
        for (const double z : layers)
            packing["bodies"].push_back({{"shape", "sphere"}, {"position_m", {0.003, 0.005, z}}, {"orientation", {1, 0, 0, 0}}});
        const Path file = folder.path() / (std::string(name) + ".json");
        write_json(file, packing);
        const auto output = test::porepack("foam --json --meshes 1 --cell-size 1e-3 " + flags + " --output " +
                                           test::quoted(folder.path() / name) + " " + test::quoted(file));
        EXPECT_EQ(output.exit_code, 0) << output.err;
        return output.json()["permeability_m2"].get<double>();
    };
    const double periodic = k_of("cell", 0.01, true, {0.005}, "");
    // A plane between the layers, and one through the spheres.
    for (const char* section : {"0.02,0.03", "0.0175,0.0275"})
        EXPECT_NEAR(k_of("layers", 0.06, false, {0.015, 0.025, 0.035}, std::string("--section ") + section) / periodic, 1.0, 0.02)
            << section;
}

TEST(OpenFoam, InertiaLowersThePermeability) {
    REQUIRE_PROGRAM("simpleFoam");
    const test::Folder folder;
    // From one gap to the next but one: inflow and outflow are alike, and no momentum is gained between them.
    FoamScene scene = pillar();
    scene.section = {0.01325, 0.03825};
    scene.pore_volume_m3 = 4e-4 * 0.025 - 2.0 * 9.04779e-7;
    // The converged flux depends slightly on the relaxation (3e-4 on this mesh), which is the same here.
    const FoamConfig config{.meshes = 1, .relaxation_velocity = 0.8, .relaxation_pressure = 0.2, .residual = 1e-7};
    const double creeping = foam_permeability(scene, config, cell, cases, folder.path() / "stokes").permeability_m2;
    const Path user = copy_of_cases(folder) / "inertial_packing";
    write_stl(user / "constant" / "triSurface" / "solid.stl", pillar().surface);
    const double viscosity = 1e-6;
    write_text(user / "system" / "caseParameters",
               "xMin 0; xMax 0.02; yMin 0; yMax 0.02; zMin 0.01325; zMax 0.03825; nx 16; ny 16; nz 20; wallRadius 1; surfaceLevel 1;\n"
               "locationInMesh (0.00201 0.00202 0.03003); viscosity 1e-6; pressureDrops (1e-11 1e-6 1e-5 3e-5);\n"
               "relaxationU 0.8; relaxationP 0.2; residual 1e-7; maxIterations 2000; processes 2;\n");
    const ByHand run = by_hand(user);
    ASSERT_EQ(run.exit_code, 0) << run.text;
    std::ifstream rates(user / "flow_rates.dat");
    std::string header;
    std::getline(rates, header);
    std::vector<double> permeability, reynolds;
    for (double drop = 0.0, flow = 0.0, iterations = 0.0, momentum = 0.0; rates >> drop >> flow >> iterations >> momentum;) {
        permeability.push_back(viscosity * flow * 0.025 / (4e-4 * drop));
        reynolds.push_back(flow / 4e-4 * 0.012 / viscosity);
        std::printf("  Re %.3g: k/k0 %.4f in %.0f iterations\n", reynolds.back(), permeability.back() / creeping, iterations);
    }
    ASSERT_EQ(permeability.size(), 4U);
    EXPECT_NEAR(permeability[0] / creeping, 1.0, 1e-5);
    for (std::size_t i = 1; i < 4; ++i) EXPECT_LT(permeability[i], permeability[i - 1]);
    EXPECT_LT(permeability[3], 0.98 * creeping);
    EXPECT_TRUE(has(by_hand(user).text, "already done"));
}

}  // namespace
}  // namespace porepack
