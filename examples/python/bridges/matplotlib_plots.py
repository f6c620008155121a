"""matplotlib draws a section of the flow and the convergence of k. Writes plots.png."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

import porepack

box = porepack.Vessel("box", size_m=[0.01] * 3, periodic=[True] * 3)
balls = porepack.Packing(porepack.Shape("sphere", diameter_m=0.008), box, [[0.002, 0.002, 0.002], [0.007, 0.007, 0.007]])
k = porepack.permeability(porepack.PoreSpace(balls), 2.5e-4, flow=True)
speed = numpy.linalg.norm(k.flow.velocity_m_per_s, axis=-1)[:, 8]  # the plane y = 2.1 mm

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
picture = left.imshow(1e3 * speed.T, origin="lower", extent=[0, 10, 0, 10])
figure.colorbar(picture, ax=left, label="speed (mm/s)")
left.set(xlabel="x (mm)", ylabel="z (mm)")
right.plot([1e3 * grid.voxel_size_m for grid in k.grids], [grid.permeability_m2 for grid in k.grids], "o-", label="grids")
right.axhspan(*k.interval_m2, alpha=0.3, label="interval of k, 95 %")
right.set(xlabel="voxel size (mm)", ylabel="k (m²)", xlim=(0, None))
right.legend()
figure.savefig("plots.png", dpi=100)
print(k)
