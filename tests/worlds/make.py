#!/usr/bin/env python3
"""Writes the octree and point cloud files of this folder, with the programs that define their formats.

    pip install octomap-python pypcd4 plyfile numpy
    python3 make.py
"""
import json

import numpy as np
import octomap
from plyfile import PlyData, PlyElement
from pypcd4 import Encoding, PointCloud

random = np.random.default_rng(7)

# a scan of a bent wall, seen from above the origin: occupied, free and unknown cells, some of them pruned to larger ones
tree = octomap.OcTree(0.05)
u, v = np.meshgrid(np.linspace(-0.4, 0.4, 40), np.linspace(-0.3, 0.3, 30))
wall = np.stack([1.0 + 0.3 * u.ravel() ** 2, u.ravel(), v.ravel()], axis=1)
tree.insertPointCloud(wall, np.array([0.4, 0.02, 0.01]))
for x, y, z in np.ndindex(8, 8, 8):
    tree.updateNode(np.array([-1.6 + 0.05 * x + 0.025, -0.8 + 0.05 * y + 0.025, 0.05 * z + 0.025]), True)
tree.updateInnerOccupancy()
tree.write(b"map.ot")


def leaves(of):
    """Centres in half finest cells, edges in finest cells, occupied or free."""
    half = of.getResolution() / 2
    cells = (i for i in of.begin_tree() if i.isLeaf())
    return sorted(
        [*(round(c / half) for c in i.getCoordinate()), round(i.getSize() / half / 2), int(of.isNodeOccupied(i))]
        for i in cells
    )


# the binary form is rounded to free and occupied, and pruned again
full = leaves(tree)
tree.writeBinary(b"map.bt")
read = octomap.OcTree(0.05)
read.readBinary(b"map.bt")
json.dump({"ot": full, "bt": leaves(read)}, open("map.json", "w"), separators=(",", ":"))

# on a grid, so that there is something to compress
points = (random.integers(-9, 10, size=(60, 3)) / 8).astype(np.float32)
points[10] = np.nan
intensity = np.full((60, 1), 0.5, dtype=np.float32)
cloud = PointCloud.from_points(
    np.hstack([intensity, points]), fields=("intensity", "x", "y", "z"), types=(np.float32,) * 4
)
for encoding in [Encoding.ASCII, Encoding.BINARY, Encoding.BINARY_COMPRESSED]:
    cloud.save(f"cloud_{encoding.value.lower()}.pcd", encoding=encoding)

vertex = np.empty(60, dtype=[("z", "f8"), ("red", "u1"), ("x", "f4"), ("y", "f4")])
vertex["x"], vertex["y"], vertex["z"] = points.T
vertex["red"] = 200
face = np.empty(1, dtype=[("vertex_indices", "i4", (3,))])
face["vertex_indices"] = [0, 1, 2]
for name, text, order in [("ascii", True, "="), ("little", False, "<"), ("big", False, ">")]:
    elements = [PlyElement.describe(vertex, "vertex"), PlyElement.describe(face, "face")]
    PlyData(elements, text=text, byte_order=order).write(f"cloud_{name}.ply")

json.dump([p.tolist() for p in points if np.isfinite(p).all()], open("cloud.json", "w"), separators=(",", ":"))
