"""A shape, a bed of it that is poured and tapped, its porosity and permeability, and the flow field."""

import porepack

shape = porepack.Shape("tetrapod", sphericity=0.53, volume_m3=1e-7)
tube = porepack.Vessel("cylinder", diameter_m=0.03, height_m=0.2)
bed = porepack.pour(shape, tube, 100, seed=1, protocol=[{"kind": "tap", "number": 2, "height_m": 0.002}])
print(bed)
for step in bed.report["protocol"]["steps"]:
    print(f"after {step['kind']}: porosity {step['porosity']:.4f}")

space = porepack.PoreSpace(bed)
k = porepack.permeability(space, voxel_size_m=4e-4, flow=True)
print(k)
print("half widths of the interval (m²):", {name: f"{part:.1g}" for name, part in k.budget_m2.items()})
speed = (k.flow.velocity_m_per_s**2).sum(axis=-1) ** 0.5
print(f"largest speed over superficial velocity: {speed.max() / 5e-5:.1f}")
