"""k of voxelised packings by the walls around the largest balls, and by half-way walls, against k with the exact walls.

Usage: PYTHONPATH=build/python /usr/bin/python3 benchmarks/walls_of_masks.py FIRST_SEED COUNT [--turned]

One line per seed: spheres, rods, tetrapods or dolosse of 10 mm thickness at random places and turns, overlapping, or an array of spheres
whose lattice is shifted at random; 7 to 19 voxels per thickness; in a periodic box. With --turned: arrays of spheres that are turned and
shifted at random, cut by a box with walls, 10 or 20 voxels per diameter.
"""

import sys
import warnings

import numpy

import porepack

THICKNESS_M = 0.01
CELLS = {
    "sc": [[0, 0, 0]],
    "bcc": [[0, 0, 0], [0.5, 0.5, 0.5]],
    "fcc": [[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]],
}


def periodic_box(side_m):
    return porepack.Vessel("box", size_m=[side_m] * 3, periodic=[True] * 3)


def boolean_model(shape, grains, side_m, seed):
    random = numpy.random.default_rng(seed)
    turns = random.normal(size=(grains, 4))
    turns /= numpy.linalg.norm(turns, axis=1)[:, None]
    return porepack.Packing(shape, periodic_box(side_m), random.random((grains, 3)) * side_m, turns, overlap_allowed=True)


def array_of_spheres(kind, cell_m, cells, seed):
    random, side_m = numpy.random.default_rng(seed), cell_m * cells
    range_of_cells = range(cells)
    places = [
        (numpy.array(place) + [i, j, k]) / cells
        for place in CELLS[kind]
        for i in range_of_cells
        for j in range_of_cells
        for k in range_of_cells
    ]
    shifted = (numpy.array(places) + random.random(3)) % 1.0 * side_m
    return porepack.Packing(porepack.Shape("sphere", diameter_m=THICKNESS_M), periodic_box(side_m), shifted, overlap_allowed=True)


def scene(seed):
    """A packing, its name, and the number of voxels per thickness."""
    random, d = numpy.random.default_rng(seed), THICKNESS_M
    kind, side_m, voxels = random.integers(0, 7), d * random.uniform(3.5, 5.0), int(random.integers(7, 20))
    volume = (side_m / 0.045) ** 3
    if kind == 0:
        return (
            boolean_model(porepack.Shape("sphere", diameter_m=d), int(random.integers(20, 110) * volume), side_m, seed),
            "spheres",
            voxels,
        )
    if kind == 1:
        rod = porepack.Shape("rod", diameter_m=d, length_m=d * random.uniform(0.5, 3))
        return boolean_model(rod, int(random.integers(10, 30) * volume) + 1, side_m, seed), "rods", voxels
    if kind == 2:
        tetrapod = porepack.Shape("tetrapod", diameter_m=d, length_m=d * random.uniform(0.8, 1.6))
        return boolean_model(tetrapod, int(random.integers(5, 14) * volume) + 1, side_m, seed), "tetrapods", voxels
    if kind == 3:
        return array_of_spheres("sc", d * random.uniform(1.0, 1.3), 3, seed), "sc", voxels
    if kind == 4:
        return array_of_spheres("bcc", d * random.uniform(1.155, 1.5), 3, seed), "bcc", voxels
    if kind == 5:
        return array_of_spheres("fcc", d * random.uniform(1.44, 1.8), 2, seed), "fcc", voxels
    dolos = porepack.Shape("dolos", diameter_m=d * 0.8, length_m=d * 1.3)
    return boolean_model(dolos, int(random.integers(6, 16) * volume) + 1, side_m, seed), "dolos", voxels


def turned_array(seed):
    """The same of an array whose axes are not those of the voxels; the box is a whole number of voxels."""
    random = numpy.random.default_rng(seed)
    name, voxels = ("sc", "bcc", "fcc")[random.integers(0, 3)], (10, 20)[random.integers(0, 2)]
    cell_m = THICKNESS_M * {"sc": random.uniform(1.0, 1.3), "bcc": random.uniform(1.155, 1.5), "fcc": random.uniform(1.44, 1.8)}[name]
    side_m = THICKNESS_M / voxels * round(voxels * random.uniform(3.0, 4.0))
    reach = range(-5, 6)
    places = cell_m * numpy.array([numpy.array(place) + [i, j, k] for place in CELLS[name] for i in reach for j in reach for k in reach])
    turn, _ = numpy.linalg.qr(random.normal(size=(3, 3)))
    places = places @ turn + side_m * random.random(3)
    inside = ((places > -0.5 * THICKNESS_M) & (places < side_m + 0.5 * THICKNESS_M)).all(axis=1)
    box = porepack.Vessel("box", size_m=[side_m] * 3)
    return (
        porepack.Packing(porepack.Shape("sphere", diameter_m=THICKNESS_M), box, places[inside], overlap_allowed=True),
        f"turned {name}",
        voxels,
    )


def compare(seed, turned):
    packing, name, voxels = turned_array(seed) if turned else scene(seed)
    side_m = packing.vessel.height_m
    whole = {"section_m": [0.0, side_m], "ends": "planes"} if turned else {}
    space = porepack.PoreSpace(packing, **whole)
    phases = space.voxels(side_m / round(side_m / THICKNESS_M * voxels))
    mask, size_m = phases == 1, side_m / phases.shape[2]
    exact = porepack.permeability(space, THICKNESS_M / 14).value_m2

    def flow(walls):
        return porepack.permeability(porepack.PoreSpace(mask, size_m, periodic=[not turned] * 3, walls=walls))

    balls, half_way = flow("balls"), flow("half_way")
    low, high = balls.interval_m2 or (float("nan"), float("nan"))
    percent = [100.0 * (k / exact - 1.0) for k in (half_way.value_m2, balls.value_m2, low, high)]
    holds = "holds" if low <= exact <= high else "MISSES"
    print(
        f"{seed} {name}, {voxels} voxels, porosity {mask.mean():.3f}: half-way {percent[0]:+.1f} %, balls {percent[1]:+.1f} % "
        f"({percent[2]:+.1f} to {percent[3]:+.1f}), {holds}",
        flush=True,
    )


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    first, count = int(sys.argv[1]), int(sys.argv[2])
    for number in range(first, first + count):
        compare(number, "--turned" in sys.argv)
