"""Test helper: an octree of voxels, encoded as OctoMap messages and files.

The tree is 16 levels deep. Child i of a node is the half where bit 0 of i is set for +x, bit 1 for +y, bit 2 for +z; the
origin is the corner that the eight children of the root share. A leaf above the lowest level is a voxel of that size.
"""

import struct
from math import floor

from octomap_msgs.msg import Octomap, OctomapWithPose

DEPTH = 16
FREE, OCCUPIED = "free", "occupied"
LOG_ODDS = {FREE: -2.0, OCCUPIED: 3.5}


class Octree:
    def __init__(self, resolution):
        self.resolution = resolution  # [m] edge of the smallest voxel
        self._root = None

    def set(self, state, x, y, z, depth=DEPTH):
        """The voxel of this depth around a point is FREE or OCCUPIED; whatever it held is forgotten."""
        keys = [floor(number / self.resolution) + (1 << (DEPTH - 1)) for number in (x, y, z)]
        if self._root is None:
            self._root = {}
        node = self._root
        for level in range(depth):
            bit = DEPTH - 1 - level
            child = sum((key >> bit & 1) << axis for axis, key in enumerate(keys))
            if level == depth - 1:
                node[child] = state
            elif not isinstance(node.get(child), dict):
                # a leaf that is divided stays what it was in its other seven parts
                node[child] = dict.fromkeys(range(8), node[child]) if child in node else {}
            node = node[child]
        return self

    def fill(self, state, octants=range(8)):
        """These octants, to the end of the tree's world: leaves right below the root."""
        self._root = dict.fromkeys(octants, state)
        return self

    def binary(self):
        """Two bits for each child, 01 free, 10 occupied, 11 with children of its own, and then these in order."""
        return b"" if self._root is None else _binary(self._root)

    def full(self):
        """For each node its log-odds as a float and one bit for each child that exists, and then these in order."""
        return b"" if self._root is None else _full(self._root)

    def file(self):
        """The content of a .bt file."""
        head = "# Octomap OcTree binary file", "id OcTree", f"size {_count(self._root)}", f"res {self.resolution}", "data\n"
        return "\n".join(head).encode() + self.binary()

    def message(self, binary=True, frame="base", stamp=None):
        message = Octomap(binary=binary, id="OcTree", resolution=self.resolution)
        message.header.frame_id = frame
        if stamp:
            message.header.stamp = stamp.to_msg()
        stream = self.binary() if binary else self.full()
        message.data = list(struct.unpack(f"{len(stream)}b", stream))
        return message

    def message_with_pose(self, origin, frame="base", **how):
        message = OctomapWithPose(origin=origin, octomap=self.message(frame=frame, **how))
        message.header.frame_id = frame
        return message


def _binary(node):
    bits = 0
    for child, what in node.items():
        bits |= {FREE: 0b01, OCCUPIED: 0b10}.get(what if isinstance(what, str) else None, 0b11) << 2 * child
    inner = (node[child] for child in range(8) if isinstance(node.get(child), dict))
    return struct.pack("<H", bits) + b"".join(map(_binary, inner))


def _count(node):
    """The number of nodes: this one, and those below it."""
    return 1 + sum(_count(what) if isinstance(what, dict) else 1 for what in node.values())


def _full(node):
    if isinstance(node, str):
        return struct.pack("<fB", LOG_ODDS[node], 0)
    children = sum(1 << child for child in node)
    # an inner node is as occupied as its most occupied child
    return struct.pack("<fB", _most(node), children) + b"".join(_full(node[child]) for child in sorted(node))


def _most(node):
    return LOG_ODDS[node] if isinstance(node, str) else max(map(_most, node.values()))
