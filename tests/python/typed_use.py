# SPDX-License-Identifier: AGPL-3.0-or-later
"""A script as users write it, which mypy --strict accepts; it refuses the lines that say so. Not run."""
import numpy as np
import packmesh
from packmesh import Beyond, Box, Cylinder, Mesh, Region, Species, Sphere

size = np.array([50.0, 50.0, 50.0])
lumen = np.linspace(10, 12, 3, dtype=np.float32)
p: packmesh.Packing = packmesh.pack(box=size, hematocrit=np.float64(0.3), seed=np.int64(3), progress=True)
p = packmesh.pack(box=Box(size, origin=size), hematocrit=lumen[0], max_time=np.float32(3), tile=np.array([2, 2, 1]))
p = packmesh.pack(cylinder=Cylinder(lumen[1], np.int32(40)),
                  species={"RBC": np.int64(5), "PLT": Species(np.int32(3), axis=size)})
p = packmesh.pack(
    sphere=lumen[2], obstacles=[Sphere(np.float32(2), size)],
    regions=[Region(lumen[0], Box(size)),
             Region(count=np.int64(3), body=Beyond(size, size), species={"PLT": np.int32(2)})], clearance=lumen[0])
p = packmesh.pack(vessel=(size.reshape(1, 3), [[0, 0, 0]]), obstacles=Mesh("a.stl", scale=lumen[0], offset=size),
                  fixed={"RBC": size})
centres: float = float(p["RBC"].positions[:, 0].max() + p.period[1] + p.bounds[0][2])
found: bool = packmesh.check("cells", box=size, dx=lumen[0]).clean
gap: "float | None" = packmesh.check(p).certificate.minimum_gap
version: str = packmesh.__version__
step = packmesh.hemocell_output("out")[-1]
count: int = len(step.packing().check().overlapping)
error: float = float(step.packing().fit_errors.max())


def tell(progress: packmesh.Progress) -> None:
    print(progress.text, progress.remaining or 0.0 + progress.seconds)


packmesh.pack(box=size, progress=tell)
packmesh.Pakcing  # refused
p.position  # refused
p["RBC"].position  # refused
packmesh.pack(box=size, hematokrit=0.3)  # refused
packmesh.pack(box=size, hematocrit="0.3")  # refused
packmesh.check("cells", boxes=size)  # refused
