"""taufactor and PorePack: with half-way walls both give the same tortuosity factor; walls smoother than the voxels give a smaller one."""

import numpy
import taufactor

import porepack

cells = 40
x, y, z = numpy.meshgrid(*[2.0 * numpy.pi * (numpy.arange(cells) + 0.3) / cells] * 3, indexing="ij")
pores = numpy.sin(x) * numpy.cos(y) + numpy.sin(y) * numpy.cos(z) + numpy.sin(z) * numpy.cos(x) < 0.0
solver = taufactor.PeriodicSolver(pores.astype(int), device="cpu")  # along the first axis, periodic along the others
solver.solve(verbose=False)
print(f"taufactor: {float(solver.tau[0]):.4f}")
for walls in ("half_way", "balls"):
    space = porepack.PoreSpace(pores, voxel_size_m=1e-5, axes="zxy", periodic=(True, True, False), walls=walls)
    print(f"{walls}: {porepack.tortuosity(space)}")
