"""An array of NumPy: True in the pores. Here a body-centred cubic array of overlapping spheres with a layer closed along x."""

import numpy

import porepack

cells = 48
x, y, z = numpy.meshgrid(*[(numpy.arange(cells) + 0.5) / cells] * 3, indexing="ij")
pores = numpy.ones((cells, cells, cells), dtype=bool)
for centre in ((0.25, 0.25, 0.25), (0.75, 0.75, 0.75)):
    square = sum((abs(a - c) - numpy.round(abs(a - c))) ** 2 for a, c in zip((x, y, z), centre))
    pores &= square > 0.4**2
pores[10, :, :] = False  # a wall across x

for axes in ("yzx", "zxy", "xyz"):  # names of the array's axes: z is the direction of the flow
    along = "xyz"[axes.index("z")]
    space = porepack.PoreSpace(pores, voxel_size_m=1e-5, axes=axes, periodic=(True, True, True))
    try:
        print(f"along {along}: {space.porosity()}, {porepack.tortuosity(space)}, {porepack.permeability(space)}")
    except porepack.NumericalError as error:
        print(f"along {along}: {error.fault}")
