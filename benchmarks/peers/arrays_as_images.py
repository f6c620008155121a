#!/usr/bin/env python3
"""A simple cubic array of spheres (c = 0.343) as an image, by OpenPNM on a network of PoreSpy, by taufactor, and by PorePack: error and seconds.

    PYTHONPATH=build/python build/venv/bin/python benchmarks/peers/arrays_as_images.py arrays_as_images.csv

k is known to seven digits, the tortuosity factor to some 1e-4 (Sangani & Acrivos 1983). The image has 27 spheres for k by a network, which
has no periodic sides, and one for all else. taufactor and OpenPNM of PyPI need different versions of NumPy beside Debian's torch: the stored
table is of two environments. PorePack gets the same voxels, with walls half-way between them and with smoother ones, and
then the exact spheres. A program that is not installed is skipped, which the table says.
"""

import csv
import importlib.metadata
import math
import sys
import time

import numpy

import porepack

FRACTION, EXACT_TAU = 0.343, 1.182495
RADIUS = (3 * FRACTION / (4 * math.pi)) ** (1 / 3)
EXACT_K = 2 * RADIUS**2 / (9 * FRACTION * 15.39949)  # of a cell of edge 1
CELLS = (16, 32, 64)
rows = []


def image(voxels, repeats):
    x, y, z = numpy.meshgrid(*[((numpy.arange(repeats * voxels) + 0.5) / voxels) % 1.0 - 0.5] * 3, indexing="ij")
    return x * x + y * y + z * z > RADIUS * RADIUS


def version(package):
    return importlib.metadata.version(package)


def measure(quantity, voxels, code, exact, value):
    """The least of two runs."""
    seconds = math.inf
    for _ in range(2):
        begin = time.perf_counter()
        found = value()
        seconds = min(seconds, time.perf_counter() - begin)
    rows.append([quantity, voxels, code, f"{found / exact - 1:.4f}", f"{seconds:.2f}"])
    print(*rows[-1], flush=True)


def by_network(pores, voxel):
    import openpnm
    import porespy

    net = openpnm.io.network_from_porespy(porespy.networks.snow2(pores, voxel_size=voxel).network)
    net["pore.diameter"] = net["pore.equivalent_diameter"]
    net["throat.diameter"] = net["throat.inscribed_diameter"]
    net.add_model(propname="throat.hydraulic_size_factors", model=openpnm.models.geometry.hydraulic_size_factors.pyramids_and_cuboids)
    water = openpnm.phase.Phase(network=net)
    water["pore.viscosity"] = 1.0
    water.add_model(propname="throat.hydraulic_conductance", model=openpnm.models.physics.hydraulic_conductance.generic_hydraulic)
    flow = openpnm.algorithms.StokesFlow(network=net, phase=water)
    flow.set_value_BC(pores=net.pores("zmin"), values=1.0)
    flow.set_value_BC(pores=net.pores("zmax"), values=0.0)
    flow.run()
    return flow.rate(pores=net.pores("zmin"), mode="group")[0] / (pores.shape[0] * voxel)


def by_taufactor(pores):
    import taufactor

    solver = taufactor.PeriodicSolver(pores.astype(int), device="cpu")
    solver.solve(verbose=False)
    return float(solver.tau[0])


def main():
    sphere = porepack.Shape("sphere", diameter_m=2 * RADIUS)
    box = porepack.Vessel("box", size_m=[1, 1, 1], periodic=[True, True, True])
    packing = porepack.Packing(sphere, box, positions_m=[[0.5, 0.5, 0.5]], orientations=[[1, 0, 0, 0]])
    exact_space = porepack.PoreSpace(packing)
    for n in CELLS:
        pores = image(n, 1)
        for name, package, call, exact in (
            ("k", "openpnm", lambda: by_network(image(n, 3), 1 / n), EXACT_K),
            ("tortuosity factor", "taufactor", lambda: by_taufactor(pores), EXACT_TAU),
        ):
            try:
                measure(name, n, f"{package} {version(package)}", exact, call)
            except (ImportError, importlib.metadata.PackageNotFoundError) as missing:
                rows.append([name, n, package, "skipped", str(missing)])
                print(*rows[-1])
        ours = "PorePack"
        for walls in ("half_way", "balls"):
            space = porepack.PoreSpace(pores, voxel_size_m=1 / n, periodic=(True, True, True), walls=walls)
            measure("k", n, f"{ours}, image, {walls}", EXACT_K, lambda: porepack.permeability(space).value_m2)
            measure("tortuosity factor", n, f"{ours}, image, {walls}", EXACT_TAU, lambda: porepack.tortuosity(space).value)
        measure("k", n, f"{ours}, exact", EXACT_K, lambda: porepack.permeability(exact_space, voxel_size_m=1 / n).value_m2)
        measure("tortuosity factor", n, f"{ours}, exact", EXACT_TAU, lambda: porepack.tortuosity(exact_space, voxel_size_m=1 / n).value)
    with open(sys.argv[1] if len(sys.argv) > 1 else "arrays_as_images.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([["quantity", "voxels_per_cell", "code", "error", "seconds"], *rows])


if __name__ == "__main__":
    main()
