// Poses fitted to simulated scans of grains that are known exactly.
#include "analysis/fit_image.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/members_json.hpp"
#include "imaging/write_volume.hpp"
#include "packing/grains.hpp"
#include "scans/gray_levels.hpp"
#include "scans/scanner.hpp"
#include "scans/shape_points.hpp"
#include "support/helpers.hpp"
#include "support/simulated_scan.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::message_of;

constexpr double d = 0.004;  // of all capsules

Shape bent() {  // an L with legs of different lengths
    return {.id = "bent", .capsules = {{{0, 0, 0}, {0.012, 0, 0}, d / 2}, {{0, 0, 0}, {0, 0.007, 0}, d / 2}}};
}
Shape chiral() {  // differs from its mirror image
    return {.id = "chiral",
            .capsules = {{{0, 0, 0}, {0.009, 0, 0}, d / 2}, {{0.009, 0, 0}, {0.009, 0.007, 0}, d / 2}, {{0, 0, 0}, {0, 0, 0.008}, d / 2}}};
}

double gap_of(const std::vector<Capsule>& first, const std::vector<Capsule>& second) {
    double least = 1e300;
    for (const Capsule& one : first)
        for (const Capsule& other : second) least = std::min(least, gap(one, other));
    return least;
}

// Grains at random in a box, most of them moved until they touch another one.
Packing random_bed(const std::vector<Shape>& shapes, std::size_t grains, double side, unsigned seed) {
    Packing packing;
    packing.container = vessels::make_box(Vec3::Constant(side));
    packing.shapes = shapes;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(0.0, side);
    std::normal_distribution<double> normal;
    std::vector<std::vector<Capsule>> placed;
    const auto fits = [&](const std::vector<Capsule>& capsules) {
        for (const Capsule& capsule : capsules)
            for (const Vec3& end : {capsule.a, capsule.b})
                if ((end.array() < capsule.radius + 5e-4).any() || (end.array() > side - capsule.radius - 5e-4).any()) return false;
        return std::all_of(placed.begin(), placed.end(), [&](const auto& other) { return gap_of(capsules, other) > 0.0; });
    };
    for (long tries = 0; tries < 200000 && placed.size() < grains; ++tries) {
        Body body{.shape = placed.size() % shapes.size(), .position_m = Vec3(place(random), place(random), place(random))};
        body.orientation = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
        if (!fits(world_capsules(packing, body))) continue;
        // Towards the nearest grain, by halves of the gap.
        for (int step = 0; step < 40 && !placed.empty(); ++step) {
            const auto own = world_capsules(packing, body);
            const auto nearest = std::min_element(
                placed.begin(), placed.end(), [&](const auto& one, const auto& other) { return gap_of(own, one) < gap_of(own, other); });
            const double distance = gap_of(own, *nearest);
            if (distance > d || distance < 1e-6) break;
            Body next = body;
            next.position_m += 0.5 * distance * ((*nearest)[0].a - own[0].a).normalized();
            if (!fits(world_capsules(packing, next))) break;
            body = next;
        }
        packing.bodies.push_back(body);
        placed.push_back(world_capsules(packing, body));
    }
    EXPECT_EQ(placed.size(), grains);
    return packing;
}

struct Errors {
    std::size_t found = 0;
    double centre = 0.0, end = 0.0;  ///< largest
};
Errors errors_of(const Packing& exact, const Packing& fitted) {
    Errors errors;
    for (const Body& body : exact.bodies)
        for (const Body& other : fitted.bodies) {
            if (other.shape != body.shape) continue;
            const double end = scans::largest_difference_m(world_capsules(exact, body), world_capsules(fitted, other));
            if (end > 0.25 * d) continue;
            ++errors.found;
            errors.end = std::max(errors.end, end);
            errors.centre = std::max(errors.centre, (other.position_m - body.position_m).norm());
        }
    return errors;
}

TEST(Poses, RotationsLeaveNoGapAndOccurOnce) {
    const scans::ShapePoints tetrapod = scans::points_of(make_preset(ShapeKind::tetrapod, d, 0.0138));
    EXPECT_LT(tetrapod.anchor.norm(), 1e-6);  // its middle
    EXPECT_EQ(tetrapod.ends.size(), 5U);
    EXPECT_EQ(tetrapod.different_ends.size(), 2U);  // tips and middle
    const double step = 0.5 * d;
    const auto rotations = rotations_of(tetrapod, tetrapod.anchor, step);
    const scans::ShapePoints unsymmetric = scans::points_of(chiral());
    EXPECT_GT(rotations_of(unsymmetric, unsymmetric.anchor, step).size(), 2 * rotations.size());
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    double farthest = 0.0;
    for (int i = 0; i < 200; ++i) {
        const auto exact = scans::placed(
            tetrapod.capsules, {Vec3::Zero(), Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized()});
        double least = 1e300;
        for (const Quaternion& q : rotations)
            least = std::min(least, scans::largest_difference_m(scans::placed(tetrapod.capsules, {Vec3::Zero(), q}), exact));
        farthest = std::max(farthest, least);
    }
    EXPECT_LT(farthest, 1.3 * step);
    const scans::ShapePoints rod = scans::points_of(make_preset(ShapeKind::rod, d, 0.01));
    EXPECT_LT(rotations_of(rod, rod.anchor, step).size(), 300U);
    const scans::ShapePoints sphere = scans::points_of(make_preset(ShapeKind::sphere, d, 0.0));
    EXPECT_EQ(rotations_of(sphere, sphere.anchor, step).size(), 1U);
}

// A mixture of two shapes; the X-ray scan has noise, rings, beam hardening and blur.
TEST(Poses, AMixtureInAnXRayScanIsFound) {
    const Packing exact = random_bed({bent(), make_preset(ShapeKind::tetrapod, d, 0.01)}, 20, 0.045, 3);
    const double h = d / 8.0;
    const scans::SimulatedScan scan = scan_packing(exact, {0.0, 0.045}, {.voxel_size_m = h});
    const test::Folder folder;
    imaging::write_volume(folder.path() / "scan.nrrd", imaging::source_of(scan.grid, scan.values));
    const double width = scan.grid.cells[0] * h;
    const Container box = vessels::make_box({width, width, scan.grid.cells[2] * h});
    const results::Fit found = written(fit_image(folder.path() / "scan.nrrd", {}, box, exact.shapes), folder.path());
    Packing fitted = read_packing(folder.path() / "packing.json");
    for (Body& body : fitted.bodies) body.position_m -= Vec3(0.5 * (width - 0.045), 0.5 * (width - 0.045), 0.0);
    EXPECT_EQ(fitted.bodies.size(), 20U);
    const Errors errors = errors_of(exact, fitted);
    EXPECT_EQ(errors.found, 20U);
    EXPECT_LT(errors.centre, 0.05 * h);
    EXPECT_LT(errors.end, 0.1 * h);
    for (const char* shape : {"bent", "tetrapod"}) {
        EXPECT_NEAR(find(found.sizes, shape)->length_factor.value, 1.0, 0.002);
        EXPECT_NEAR(find(found.sizes, shape)->radius_change_m.value, 0.0, 0.005 * d);
    }
    EXPECT_TRUE(found.doubts.empty()) << json_of(found.doubts);
}

// Another simulator: partial volumes, Gaussian blur, white noise. Wrong sizes are measured and named, a mirrored stack too.
TEST(Poses, WrongSizesAndMirrorImagesAreNamed) {
    const Packing exact = random_bed({chiral()}, 14, 0.04, 5);
    const GrayImage image = test::simulated_scan(Grains(exact), exact.container, d / 8.0, {.blur_voxels = 0.8, .noise = 0.05, .seed = 2});
    const test::Folder folder;
    const Path scan = folder.path() / "scan.nrrd";
    write_volume(scan, scans::scan_of(image, 40.0, 200.0));
    const auto fit = [&](const Shape& shape, const std::string& axes) {
        return written(fit_image(scan, {.axes = axes, .fitted_sizes = true}, exact.container, {shape}), folder.path());
    };
    Shape wrong = chiral();
    for (Capsule& capsule : wrong.capsules) {
        capsule.a *= 0.99;
        capsule.b *= 0.99;
        capsule.radius *= 0.98;
    }
    const results::Fit found = fit(wrong, "xyz");
    EXPECT_NEAR(find(found.sizes, "chiral")->length_factor.value, 1.0 / 0.99, 0.002);
    EXPECT_NEAR(find(found.sizes, "chiral")->radius_change_m.value, 0.02 * d / 2, 0.006 * d / 2);
    EXPECT_EQ(found.doubts.size(), 2U) << json_of(found.doubts);
    const Errors errors = errors_of(exact, read_packing(folder.path() / "packing.json"));
    EXPECT_EQ(errors.found, 14U);
    EXPECT_LT(errors.end, 0.1 * d / 8.0);
    EXPECT_TRUE(has(message_of<UserError>([&] { fit(chiral(), "-xyz"); }), "mirror images of the grains"));
    EXPECT_TRUE(has(message_of<UserError>([&] { fit(make_preset(ShapeKind::sphere, 0.012, 0.0), "xyz"); }), "no grain of this shape"));
    EXPECT_TRUE(has(message_of<UserError>([&] { fit(make_preset(ShapeKind::rod, 0.001, 0.005), "xyz"); }), "voxels thick"));
}

// A scan that may not be held in memory: searched on binned voxels, fitted slab by slab, and no worse for that.
TEST(Poses, LargeScansAreFittedSlabBySlab) {
    const Packing exact = random_bed({chiral()}, 14, 0.04, 5);
    const double h = d / 16.0;
    const GrayImage image = test::simulated_scan(Grains(exact), exact.container, h, {.blur_voxels = 0.8, .noise = 0.03, .seed = 2});
    const test::Folder folder;
    const Path scan = folder.path() / "scan.nrrd";
    write_volume(scan, scans::scan_of(image, 40.0, 200.0));
    const auto fit = [&](double memory_bytes) {
        const results::Fit found =
            written(fit_image(scan, {.fit_memory_bytes = memory_bytes}, exact.container, exact.shapes), folder.path());
        EXPECT_TRUE(found.doubts.empty()) << json_of(found.doubts);
        EXPECT_NEAR(found.blur_m.value, std::hypot(0.8, std::sqrt(1.0 / 12.0)) * h, 0.02 * h);
        EXPECT_NEAR(find(found.sizes, "chiral")->length_factor.value, 1.0, 0.0005);
        const Errors errors = errors_of(exact, read_packing(folder.path() / "packing.json"));
        EXPECT_EQ(errors.found, 14U);
        return errors;
    };
    const Errors at_once = fit(1e9), by_slabs = fit(1.2e7);
    EXPECT_LT(at_once.end, 0.05 * h);
    EXPECT_LT(by_slabs.end, 1.1 * at_once.end + 0.002 * h);
    EXPECT_LT(by_slabs.centre, 1.1 * at_once.centre + 0.002 * h);
    EXPECT_TRUE(has(message_of<MachineError>([&] { fit(1e5); }), "on the fewest voxels by which grains are found"));
}

// What is not one of the grains is named, and noise and blur do not hide grains.
TEST(Poses, HardCases) {
    const test::Folder folder;
    const Path file = folder.path() / "scan.nrrd";
    const auto fit = [&](const Packing& packing, const test::ScanSettings& settings, const imaging::ImageConfig& image = {}) {
        const GrayImage scan = test::simulated_scan(Grains(packing), packing.container, d / 8.0, settings);
        write_volume(file, scans::scan_of(scan, 40.0, 200.0));
        return written(fit_image(file, image, packing.container, {bent()}), folder.path());
    };
    const Packing exact = random_bed({bent()}, 14, 0.04, 11);
    for (const auto& settings : {test::ScanSettings{.blur_voxels = 0.8, .noise = 0.1}, {.blur_voxels = 1.5, .noise = 0.03}}) {
        // Blur of 1.5 voxels leaves no peak of the solid in the histogram of grains of 8 voxels.
        const results::Fit found = fit(exact, settings, {.gray_levels = {40.0, 200.0}});
        EXPECT_TRUE(found.doubts.empty()) << json_of(found.doubts);
        const Packing fitted = read_packing(folder.path() / "packing.json");
        EXPECT_EQ(fitted.bodies.size(), 14U);
        EXPECT_EQ(errors_of(exact, fitted).found, 14U);
        EXPECT_LT(errors_of(exact, fitted).end, 0.3 * d / 8.0);
    }
    // A broken grain and a foreign body.
    const Shape leg{.id = "leg", .capsules = {{{0, 0, 0}, {0.009, 0, 0}, d / 2}}};
    for (const Shape& other : {leg, make_preset(ShapeKind::sphere, 0.009, 0.0)}) {
        Packing mixed = random_bed({bent(), other}, 12, 0.04, 12);
        const results::Fit found = fit(mixed, {.blur_voxels = 0.8, .noise = 0.03});
        EXPECT_EQ(found.grains.found, 6U) << other.id;
        EXPECT_EQ(errors_of(mixed, read_packing(folder.path() / "packing.json")).found, 6U) << other.id;
        EXPECT_TRUE(has(json_of(found.doubts).dump(), "of another shape, or a broken one")) << json_of(found.doubts);
    }
    // An empty tube.
    Packing empty = exact;
    empty.bodies.clear();
    empty.container = parse_container("cylinder:0.03,0.02");
    EXPECT_THROW((void)fit(empty, {.blur_voxels = 0.8, .noise = 0.03, .tube = true}, {.find_container = true}), UserError);
}

// By commands, in a tube; the scan shows a part of the bed.
TEST(Poses, FromAPackingToAScanAndBack) {
    Packing exact = random_bed({bent()}, 10, 0.028, 7);
    exact.container = parse_container("cylinder:0.04,0.028");
    for (Body& body : exact.bodies) body.position_m -= Vec3(0.014, 0.014, 0.0);
    const test::Folder folder;
    const auto path = [&](const char* name) { return test::quoted(folder.path() / name); };
    write_packing(folder.path() / "packing.json", exact);
    folder.write("grain.toml",
                 "[[capsule]]\na_m = [0, 0, 0]\nb_m = [0.012, 0, 0]\nradius_m = 0.002\n"
                 "[[capsule]]\na_m = [0, 0, 0]\nb_m = [0, 0.007, 0]\nradius_m = 0.002\n");
    const auto scanned = test::porepack("image simulate " + path("packing.json") + " " + path("scan.nrrd") +
                                        " --voxel-size 4e-4 --part 0.004,0.024 --tube-wall 0.003");
    ASSERT_EQ(scanned.exit_code, 0) << scanned.err;
    const auto fitted = test::porepack("image fit " + path("scan.nrrd") + " --image-find-container --shape " + path("grain.toml") +
                                       " --output " + path("fitted") + " --json");
    ASSERT_EQ(fitted.exit_code, 0) << fitted.err;
    EXPECT_TRUE(fitted.json()["doubts"].empty()) << fitted.out;
    EXPECT_NEAR(fitted.json()["container"]["diameter_m"].get<double>(), 0.04, 8e-5);
    Packing found = read_packing(folder.path() / "fitted" / "packing.json");
    EXPECT_TRUE(found.container.cut_ends());
    for (Body& body : found.bodies) body.position_m.z() += 0.004;
    EXPECT_EQ(errors_of(exact, found).found, found.bodies.size());  // no false grain
    EXPECT_GE(found.bodies.size(), 8U);                             // of the other ones hardly anything is shown
    EXPECT_LT(errors_of(exact, found).end, 0.3 * 4e-4);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "fitted" / "fit.png"));
    const auto flow = test::porepack("lbm " + path("fitted/packing.json") + " --section 0.008,0.012 --voxel-size 1e-3 --json");
    EXPECT_EQ(flow.exit_code, 0) << flow.err;

    folder.write("periodic.json", R"({"format": "porepack-packing", "version": 1, "container": {"kind": "box", "size_m": [1, 1, 1],
        "periodic": [true, true, true], "ends": "cut"}, "shapes": [], "bodies": []})");
    for (const auto& [call, message] :
         {std::pair("image simulate " + path("periodic.json") + " " + path("no.nrrd") + " --voxel-size 1e-2", "has no cut ends"),
          std::pair("image simulate " + path("packing.json") + " " + path("no.nrrd"), "no voxel size"),
          std::pair("image simulate " + path("packing.json") + " " + path("no.nrrd") + " --voxel-size 1e-3 --part 3",
                    "no range of heights"),
          std::pair("image fit " + path("scan.nrrd") + " --shape " + path("packing.json") + " --volume 1e-7", "have no effect"),
          std::pair("image fit " + path("scan.nrrd") + std::string(" --shape cube"), "cube")}) {
        const auto output = test::porepack(call);
        EXPECT_EQ(output.exit_code, 2) << call;
        EXPECT_TRUE(has(output.err, message)) << output.err;
    }
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "no.nrrd"));
}

}  // namespace
}  // namespace porepack
