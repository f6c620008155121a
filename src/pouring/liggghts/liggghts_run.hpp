// Data shared by the writing and the reading of a LIGGGHTS run. Only for the sources of this folder.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"
#include "geometry/triangle_wall.hpp"
#include "pouring/liggghts/liggghts.hpp"

namespace porepack::pouring::liggghts {

// The grain in LIGGGHTS: clump about the centre of mass, axes along the principal axes, so that the body frame
// computed by LIGGGHTS is this frame.
struct ClumpBody {
    std::vector<shapes::Capsule> spheres;
    double mass = 0.0;
    shapes::Vec3 inertia = shapes::Vec3::Zero();
    shapes::Vec3 centre = shapes::Vec3::Zero();                // in the shape's frame
    shapes::Quaternion turn = shapes::Quaternion::Identity();  // from the principal frame to the shape's frame
};

[[nodiscard]] ClumpBody clump_body(const shapes::Shape& shape, const PackingConfig& config);

// Its file name holds the number of poured batches, settling parts, consecutive parts below the energy limit, and time steps; then the
// number of finished steps of [protocol], and of repetitions of the one after them.
struct Snapshot {
    std::string file = "none";
    long poured = 0, settled = 0, calm = 0, step = 0, finished = 0, repeated = 0;
    [[nodiscard]] bool in_protocol() const { return finished + repeated > 0; }
};

struct Run {
    const std::vector<shapes::ShapeShare>& shapes;
    const vessels::Container& container;
    const PackingConfig& config;
    const ProtocolConfig& protocol;
    PourPlan plan;
    std::vector<ClumpBody> bodies;  // by shape
    core::Path folder;
    double top_m = 0.0;                                  // no grain is created above it
    std::vector<std::vector<std::size_t>> batches = {};  // the shapes of each batch's grains, in the order of creation
    double max_energy_J = 0.0;                           // total potential energy of all grains, and what a vessel that is shaken adds

    [[nodiscard]] long grains_after(long batch) const;
    [[nodiscard]] long spheres_after(long batch) const;
};

/// The name of the walls' script (walls_NAME.in): box, cylinder, annulus, mesh (also a cone); empty: other walls.
[[nodiscard]] std::string wall_script(const vessels::Container& container);
/// Write batch_1.in ..., parameters.in and grains.in with the clumps; the batches' shapes are kept in `run`.
void write_batches(Run& run, const Pour& pour);
void write_parameters(const Run& run, const Snapshot& snapshot);
void write_grains(const Run& run);
/// Writes protocol.in, with the steps that `snapshot` has not finished, and the plate.
void write_protocol(const Run& run, const Snapshot& snapshot);

/// A triangle mesh as an ASCII STL file, which LIGGGHTS reads.
void write_triangles(const geometry::TriangleMesh& mesh, const core::Path& path);

/// Rows of a LIGGGHTS dump of `columns` numbers, sorted by the first one, the number of the body or sphere: their order in the file is not
/// that of creation. A file may hold several dumps: the last one counts. `step` gets its time step.
[[nodiscard]] std::vector<std::vector<double>> read_dump(const core::Path& file, std::size_t columns, long* step = nullptr);
/// The packing of a dump of bodies.
[[nodiscard]] Packing packing_of(const Run& run, const std::vector<std::vector<double>>& bodies);
/// Contacts between the clumps of other grains per grain, which LIGGGHTS saw; `largest_overlap_m` if asked for.
struct ClumpContacts {
    double coordination_number = 0.0, largest_overlap_m = 0.0;
};
[[nodiscard]] ClumpContacts clump_contacts(const Run& run, const Packing& packing);
/// The bed after the pour (bodies of the file `pour`) and after each step, read from the files after.STEP.ROW.bodies.
[[nodiscard]] std::vector<ProtocolRow> read_protocol(const Run& run);

}  // namespace porepack::pouring::liggghts
