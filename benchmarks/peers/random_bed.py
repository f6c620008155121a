#!/usr/bin/env python3
"""Permeability of 30 random spheres (c = 0.3, a periodic box) by Peclet and by PorePack, in one run: difference to a fine reference, and seconds.

    POREPACK=build/porepack peers/bin/python benchmarks/peers/random_bed.py random_bed.csv

The reference is PorePack with --tolerance 0.003, whose interval is in the table. Both codes get the exact spheres, and one grid per row.
"""

import csv
import math
import random
import sys
import tempfile
import time

from sphere_arrays import by_peclet, by_porepack, one_grid, versions  # skipped where Peclet is not installed

SPHERES, FRACTION, CELLS = 30, 0.3, (32, 48, 64)
RADIUS = (3 * FRACTION / (4 * math.pi * SPHERES)) ** (1 / 3)


def places():
    """One after the other, where there is room: the same ones in each run."""
    draw, found = random.Random(1), []
    while len(found) < SPHERES:
        at = [draw.random() for _ in range(3)]
        if all(sum(min(abs(a - b), 1 - abs(a - b)) ** 2 for a, b in zip(at, other)) > (2.02 * RADIUS) ** 2 for other in found):
            found.append(at)
    return found


def main():
    centres, version = places(), versions()
    rows = [["cells", "code", "version", "difference", "seconds"]]
    with tempfile.TemporaryDirectory() as folder:
        reference = by_porepack(RADIUS, centres, folder, "--tolerance", 0.003)
        k, (low, high) = reference["permeability_m2"], reference["permeability_interval_m2"]
        rows.append(["reference", "PorePack", version["PorePack"], f"{low / k - 1:.5f} to {high / k - 1:.5f}", f"{reference['wall_time_s']:.1f}"])
        print(*rows[-1], flush=True)
        for cells in CELLS:
            codes = {
                "Peclet": lambda: by_peclet(RADIUS, centres, cells),
                "PorePack": lambda: by_porepack(RADIUS, centres, folder, *one_grid(cells))["permeability_m2"],
            }
            for code, permeability in codes.items():
                begin = time.perf_counter()
                found = permeability()
                rows.append([cells, code, version[code], f"{found / k - 1:.5f}", f"{time.perf_counter() - begin:.2f}"])
                print(*rows[-1], flush=True)
    with open(sys.argv[1] if len(sys.argv) > 1 else "random_bed.csv", "w", newline="") as output:
        csv.writer(output, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    main()
