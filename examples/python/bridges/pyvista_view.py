"""PyVista shows the flow between the grains: surface, streamlines, speed. Writes flow.png."""

import numpy
import pyvista

import porepack

box = porepack.Vessel("box", size_m=[0.022, 0.022, 0.06], periodic=[True, True, False])
bed = porepack.pour(porepack.Shape("tetrapod", sphericity=0.7, volume_m3=1e-7), box, 40, seed=1)
space = porepack.PoreSpace(bed, trim_m=0.006)
flow = porepack.permeability(space, 8e-4, flow=True).flow

grid = pyvista.ImageData(dimensions=numpy.array(flow.phase.shape) + 1, spacing=flow.spacing_m, origin=flow.origin_m)
grid.cell_data["phase"] = flow.phase.ravel(order="F")
grid.cell_data["velocity (m/s)"] = flow.velocity_m_per_s.reshape(-1, 3, order="F")
grid.cell_data["pressure (Pa)"] = flow.pressure_Pa.ravel(order="F")

found = porepack.surface(bed, surface_deviation_m=1e-4, contact_gap_m=2e-5)  # contacts are joined by bridges 20 µm thick
grains = pyvista.PolyData.from_regular_faces(found.vertices, found.faces)
low, high = space.section_m
source = pyvista.Plane(center=grid.center, i_size=0.02, j_size=0.02, i_resolution=12, j_resolution=12)
lines = grid.cell_data_to_point_data().streamlines_from_source(source, "velocity (m/s)")

plotter = pyvista.Plotter(off_screen=True)
plotter.add_mesh(grains.clip("y", origin=grid.center).clip("z", origin=(0, 0, high)), color="tan")
plotter.add_mesh(lines.tube(radius=1e-4), scalars="velocity (m/s)", log_scale=True, clim=[1e-5, 1e-3])
plotter.screenshot("flow.png")
print(f"{grid.n_cells} cells, {lines.n_lines} streamlines, pressure from {flow.pressure_Pa.min():.3g} to {flow.pressure_Pa.max():.3g} Pa")
