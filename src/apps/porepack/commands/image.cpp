// Commands on images: info, convert, crop, bin, segment, simulate.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "analysis/fit_image.hpp"
#include "analysis/scan_plan.hpp"
#include "analysis/segment.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "imaging/write_volume.hpp"
#include "record/resolved_config.hpp"
#include "results/image_info.hpp"
#include "scans/gray_levels.hpp"
#include "scans/scanner.hpp"
#include "shapes/config.hpp"
#include "vessels/config.hpp"

namespace porepack::apps {
namespace {

ImageConfig config_of(const Common& common) {
    return config_from_flags<ImageConfig>(common.image_flags);
}

results::Volume volume_of(const VolumeHeader& header) {
    results::Volume found{.format = header.format,
                          .voxels = header.voxels,
                          .voxel_size_m = header.spacing_m,
                          .voxel_size_from = header.size_source,
                          .origin_m = header.origin_m,
                          .orientation = header.orientation,
                          .type = std::string(name_of(header.type))};
    for (std::size_t a = 0; a < 3; ++a) found.size_m[a] = header.spacing_m[a] * static_cast<double>(header.voxels[a]);
    return found;
}

// How many voxels have which values.
results::Histogram histogram_of(const VolumeSource& source, const VolumeStatistics& found) {
    constexpr std::size_t classes = 24;
    results::Histogram histogram{
        .from = found.minimum, .class_width = (found.maximum - found.minimum) / classes, .fractions = std::vector<double>(classes, 0.0)};
    std::vector<float> layer(static_cast<std::size_t>(source.header.layer()));
    for (std::int64_t z = 0; z < source.header.voxels[2]; ++z) {
        source.read(z, layer);
        for (const float value : layer)
            histogram.fractions[std::min(classes - 1, static_cast<std::size_t>((value - found.minimum) / histogram.class_width))] +=
                1.0 / static_cast<double>(source.header.count());
    }
    return histogram;
}

// The thresholds that two peaks suggest.
results::GrayThresholds thresholds_of(const Common& common, const VolumeSource& source) {
    try {
        const GrayLevels levels = fit_gray_levels(source, config_of(common).pore_side, {}, common.input);
        return {.gray_level_of_pores = levels.pore,
                .gray_level_of_solid = levels.solid,
                .threshold_half_level = levels.half_level(),
                .threshold_otsu = levels.otsu};
    } catch (const UserError&) {
        return {};  // no two peaks
    }
}

results::VolumeValues values_of(const Common& common, const VolumeSource& source) {
    const VolumeStatistics found = statistics_of(source);
    results::VolumeValues values{
        .minimum = found.minimum, .maximum = found.maximum, .mean = found.mean, .standard_deviation = found.deviation};
    if (found.values && found.values->size() <= 16) {
        values.values.emplace();
        for (const auto& [value, count] : *found.values)
            values.values->push_back({value, static_cast<double>(count) / static_cast<double>(source.header.count())});
    } else if (found.maximum > found.minimum) {
        values.histogram = histogram_of(source, found);
        values.thresholds = thresholds_of(common, source);
    }
    return values;
}

void draw(const results::Histogram& histogram) {
    const auto& fractions = histogram.fractions;
    const double maximum = *std::max_element(fractions.begin(), fractions.end());
    fmt::print("histogram (class from, part of the voxels):\n");
    for (std::size_t c = 0; c < fractions.size(); ++c)
        fmt::print("{:>12.5g} {:>6.2f} % {}\n", histogram.from + static_cast<double>(c) * histogram.class_width, 100.0 * fractions[c],
                   std::string(static_cast<std::size_t>(std::lround(50.0 * fractions[c] / maximum)), '#'));
}

void info(const Common& common) {
    const VolumeSource source = open_volume(common.input, config_of(common));
    results::ImageInfo result{.volume = volume_of(source.header)};
    if (!common.dry_run) result.values = values_of(common, source);
    if (common.json || !result.values || !result.values->histogram) return print_result(common, result);
    const results::Histogram histogram = *result.values->histogram;
    result.values->histogram.reset();
    print_result(common, result);
    draw(histogram);
}

void write(const Common& common, const std::string& target, const VolumeSource& source) {
    results::WrittenImage result{.volume = volume_of(source.header)};
    (common.dry_run ? result.would_write : result.written) = target;
    if (!common.dry_run) write_volume(target, source);
    print_result(common, result);
}

// The shapes of a packing, of a case, of a TOML file with capsules, or one by its name and keys.
std::vector<shapes::Shape> shapes_of(const std::string& text, const Flags& flags) {
    std::vector<shapes::Shape> found;
    shapes::ShapeConfig config;
    if (is_packing(text)) {
        if (!flags.empty()) throw UserError("keys of the shape have no effect on a packing's shapes", {.where = "--shape " + text});
        return packing::read_packing(text).shapes;
    }
    Flags all = flags;
    const bool file = is_case(text) || text.ends_with(".toml");
    const TomlFile toml = file ? TomlFile(std::filesystem::is_directory(text) ? Path(text) / "case.toml" : Path(text)) : TomlFile();
    if (text == "mesh" || text == "library")
        throw UserError("the poses of grains from meshes are not fitted",
                        {.where = "--shape " + text, .fix = "`porepack image segment` takes grains of any shape"});
    if (!file) all["kind"] = "\"" + text + "\"";
    if (file && !toml.has("shape")) all["kind"] = "\"capsules\"";
    toml.read(
        toml.has("shape") ? "shape" : "", [&](ConfigVisitor& v) { describe(v, config); }, all);
    for (const shapes::ShapeShare& share : make_shapes(config)) found.push_back(share.shape);
    return found;
}

void fit(const Common& common, const std::string& shape) {
    const ImageConfig image = config_of(common);
    const std::vector<shapes::Shape> shapes = shapes_of(shape, common.flags);
    run_on_files(common, {.stage = "fit",
                          .target = common.output.empty() ? Path("fitted") : Path(common.output),
                          .configuration = {{"image", resolved_config(image)}, {"shape", shape}},
                          .inputs = open_volume(common.input, image).header.files,
                          .work = [&](const Path& folder) {
                              return written(fit_image(common.input, image, container_of(common), shapes), folder);
                          }});
}

// "z0,z1"
packing::Section part_of(const std::string& text, const vessels::Container& container) {
    packing::Section part{0.0, container.height()};
    if (text.empty()) return part;
    int used = 0;
    if (std::sscanf(text.c_str(), "%lf,%lf%n", &part.z0_m, &part.z1_m, &used) != 2 || static_cast<std::size_t>(used) != text.size() ||
        !(part.z1_m > part.z0_m))
        throw UserError(fmt::format("\"{}\" is no range of heights", text), {.where = "--part", .allowed = "z0,z1 in metres"});
    if (const double slack = 1e-9 * container.height(); part.z0_m < -slack || part.z1_m > container.height() + slack)
        throw UserError(fmt::format("the part from {:g} to {:g} m reaches out of the container", part.z0_m, part.z1_m),
                        {.where = "--part", .allowed = fmt::format("0 to {:g} m", container.height())});
    return part;
}

void simulate(const Common& common, const std::string& target, const std::string& text) {
    const auto config = config_from_flags<scans::ScannerConfig>(common.flags);
    const packing::Packing packing = packing::read_packing(common.input);
    const packing::Section part = part_of(text, packing.container);
    if (common.dry_run) {
        print_result(common, {{"would_write", target},
                              {"configuration", resolved_config(config)},
                              {"memory", human_bytes(scans::scan_memory_bytes(packing.container, part, config))}});
        return;
    }
    const scans::SimulatedScan scan = scans::scan_packing(packing, part, config);
    write(common, target, source_of(scan.grid, scan.values));
}

void plan(const Common& common, const std::string& text) {
    const auto config = apps::config_of<ScanPlanConfig>(common.flags);
    Flags of_scanner = common.flags;
    for (const char* varied : {"views", "counts"}) of_scanner.erase(varied);
    const auto scanner = apps::config_of<scans::ScannerConfig>(of_scanner);
    const packing::Packing packing = packing::read_packing(common.input);
    const packing::Section part = part_of(text, packing.container);
    const Json configuration = {{"scanner", resolved_config(scanner)}, {"plan", resolved_config(config)}, {"part", text}};
    if (common.dry_run)
        return print_result(common, {{"configuration", configuration},
                                     {"scans", number_of_scans(config)},
                                     {"expected", "each scan is simulated, fitted and solved: some minutes each"}});
    run_on_files(common, {.stage = "plan",
                          .target = common.output.empty() ? Path("scan_plan") : Path(common.output),
                          .configuration = configuration,
                          .inputs = {common.input},
                          .work = [&](const Path& folder) { return written(plan_scan(packing, part, scanner, config, folder), folder); }});
}

Box box_of(const std::string& text) {
    Box box;
    long long n[6] = {};
    int used = 0;
    if (std::sscanf(text.c_str(), "%lld,%lld,%lld,%lld,%lld,%lld%n", &n[0], &n[1], &n[2], &n[3], &n[4], &n[5], &used) != 6 ||
        static_cast<std::size_t>(used) != text.size())
        throw UserError(fmt::format("\"{}\" is no box", text), {.where = "--box", .allowed = "x0,x1,y0,y1,z0,z1 in voxels, from 0"});
    for (std::size_t i = 0; i < 3; ++i) {
        box.low[i] = n[2 * i];
        box.high[i] = n[2 * i + 1];
    }
    return box;
}

void segment(const Common& common) {
    const auto config = config_from_flags<SegmentConfig>(common.flags);
    const ImageConfig image = config_of(common);
    run_on_files(common, {.stage = "segment",
                          .target = common.output.empty() ? Path("segmented") : Path(common.output),
                          .configuration = {{"segment", resolved_config(config)}, {"image", resolved_config(image)}},
                          .inputs = open_volume(common.input, image).header.files,
                          .work = [&](const Path& folder) {
                              return written(segment_image(common.input, image, container_of(common), config), folder);
                          }});
}

constexpr const char* an_image = "an image: a file, or a folder with one file per layer (docs/images.md)";
constexpr const char* packing_with_walls = "packing.json, in a container without periodic sides";
constexpr const char* image_written = ".raw, .mhd, .nrrd, .npy or .vti";

template <typename Config>
void add_keys_of(CommandLine& line, Command command, const std::vector<std::string>& without = {}) {
    line.add_keys(
        command,
        [](ConfigVisitor& v) {
            static Config config;
            describe(v, config);
        },
        without);
}

// info, convert, crop, bin: of any image, without a container.
void add_conversions(CommandLine& line, Command image) {
    Common& common = line.common;
    const auto target = std::make_shared<std::string>(), box = std::make_shared<std::string>();
    const auto add = [&](const std::string& name, const std::string& help, const std::string& example, bool writes,
                         const std::function<void()>& action) {
        auto command = line.add_below(image, name, help, example, action);
        command.add_option("input", common.input, an_image).type_name("path").required();
        if (writes) command.add_option("target", *target, image_written).type_name("path").required();
        line.add_image_keys(command, {"pore", "threshold", "pore_side", "walls", "smoothing_voxels", "gray_levels", "find_container",
                                      "fitted_sizes", "fit_memory_bytes"});
        return command;
    };
    add("info", "format, voxels, orientation and values", "porepack image info scan.nrrd", false, [&common] { info(common); });
    add("convert", "the same image in another format, with x, y, z in order",
        "porepack image convert scan.raw scan.nrrd --image-dims 400,400,600 --image-type uint16 --image-voxel-size 6.6e-5", true,
        [&common, target] { write(common, *target, open_volume(common.input, config_of(common))); });
    add("crop", "a part of an image", "porepack image crop scan.nrrd part.nrrd --box 0,200,0,200,50,150", true,
        [&common, target, box] { write(common, *target, cropped(open_volume(common.input, config_of(common)), box_of(*box))); })
        .add_option("--box", *box, "voxels, the upper ends excluded")
        .type_name("x0,x1,y0,y1,z0,z1")
        .required();
    const auto factor = std::make_shared<long>(2);
    add("bin", "means of cubes of voxels", "porepack image bin scan.nrrd coarse.nrrd --factor 4", true,
        [&common, target, factor] { write(common, *target, binned(open_volume(common.input, config_of(common)), *factor)); })
        .add_option("--factor", *factor, "edge length of the cubes in voxels; default 2")
        .type_name("number");
}

void add_container(Command& command, Common& common) {
    command.add_option("--container", common.container, "container that the image shows; default: the box of the image")
        .type_name(vessels::container_forms() + " [m]");
}

void add_segment(CommandLine& line, Command image) {
    Common& common = line.common;
    auto command =
        line.add_below(image, "segment", "grains of a scan: threshold, cavities filled, watershed, incomplete grains removed",
                       "porepack image segment scan.nrrd --container cylinder:0.1,0.3 --output segmented", [&common] { segment(common); });
    command.add_option("input", common.input, an_image).type_name("path").required();
    add_container(command, common);
    add_keys_of<SegmentConfig>(line, command);
    line.add_image_keys(command, {"pore", "walls", "fitted_sizes", "fit_memory_bytes"});
}

void add_fit(CommandLine& line, Command image) {
    Common& common = line.common;
    const auto shape = std::make_shared<std::string>();
    auto command = line.add_below(image, "fit", "grains of a known shape in a scan: a packing of exact poses",
                                  "porepack image fit scan.nrrd --shape tetrapod --sphericity 0.53 --volume 7.33e-7 --image-find-container",
                                  [&common, shape] { fit(common, *shape); });
    command.add_option("input", common.input, "a scan: a file, or a folder with one file per layer (docs/images.md)")
        .type_name("path")
        .required();
    command
        .add_option("--shape", *shape,
                    "tetrapod, dolos, tetrahedron, star, sphere or rod with the keys below; or packing.json, a case, or a TOML file, whose "
                    "shapes are taken")
        .type_name("name or path")
        .required();
    add_container(command, common);
    line.add_keys(command, "shape", {"kind", "file", "unit_m"});
    line.add_image_keys(command, {"pore", "walls"});
}

void add_simulate(CommandLine& line, Command image) {
    Common& common = line.common;
    const auto target = std::make_shared<std::string>(), part = std::make_shared<std::string>();
    auto command =
        line.add_below(image, "simulate", "an X-ray scan of a packing: projections with noise, rings and blur, and the image from them",
                       "porepack image simulate packing.json scan.nrrd --voxel-size 3e-4 --part 0.02,0.08",
                       [&common, target, part] { simulate(common, *target, *part); });
    command.add_option("input", common.input, packing_with_walls).type_name("path").required();
    command.add_option("target", *target, image_written).type_name("path").required();
    command.add_option("--part", *part, "range of heights; default: the whole container").type_name("z0,z1 [m]");
    add_keys_of<scans::ScannerConfig>(line, command);
}

void add_plan(CommandLine& line, Command image) {
    Common& common = line.common;
    const auto part = std::make_shared<std::string>();
    auto command = line.add_below(image, "plan", "scans at several settings simulated and fitted: which is good enough for k?",
                                  "porepack image plan packing.json --part 0.02,0.08 --voxel-sizes 3e-4,5e-4 --counts 20000,2000",
                                  [&common, part] { plan(common, *part); });
    command.add_option("input", common.input, packing_with_walls).type_name("path").required();
    command.add_option("--part", *part, "range of heights; default: the whole container").type_name("z0,z1 [m]");
    add_keys_of<ScanPlanConfig>(line, command);
    add_keys_of<scans::ScannerConfig>(line, command, {"voxel_size_m", "views", "counts"});
}

}  // namespace

void add_image_commands(CommandLine& line) {
    const auto image = line.add_group("image", "scans and segmented images: look at them, convert, crop, bin, segment, simulate");
    add_conversions(line, image);
    add_segment(line, image);
    add_fit(line, image);
    add_simulate(line, image);
    add_plan(line, image);
}

}  // namespace porepack::apps
