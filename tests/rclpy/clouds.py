"""Test helper: `PointCloud2` messages in the memory layouts of sensor drivers."""

from dataclasses import dataclass
from math import nan

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

FLOAT32, FLOAT64 = PointField.FLOAT32, PointField.FLOAT64
_TYPES = {FLOAT32: "f4", FLOAT64: "f8", PointField.UINT8: "u1", PointField.UINT16: "u2"}


@dataclass(frozen=True)
class Layout:
    """Where the numbers of a point stand: (name, offset, type) for each field, in the order of the message."""

    fields: tuple = (("x", 0, FLOAT32), ("y", 4, FLOAT32), ("z", 8, FLOAT32))
    point_step: int = 12
    big_endian: bool = False
    height: int = 1
    row_padding: int = 0  # bytes after each row

    def dtype(self):
        order = ">" if self.big_endian else "<"
        return np.dtype(
            {
                "names": [name for name, _, _ in self.fields],
                "formats": [order + _TYPES[kind] for _, _, kind in self.fields],
                "offsets": [offset for _, offset, _ in self.fields],
                "itemsize": self.point_step,
            }
        )


PLAIN = Layout()


def cloud(points, frame="base", layout=PLAIN, stamp=None):
    """The message of these points, an array of n by 3. What is no coordinate is filled with noise that no point may come from."""
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    width = -(-len(points) // layout.height)
    # as a depth camera does where it sees nothing
    padded = np.full((width * layout.height, 3), nan)
    padded[: len(points)] = points

    noise = np.random.default_rng(1).integers(0, 256, len(padded) * layout.point_step, dtype=np.uint8)
    records = noise.view(layout.dtype())
    for name, values in zip("xyz", padded.T, strict=True):
        if name in records.dtype.names:
            records[name] = values
    rows = records.view(np.uint8).reshape(layout.height, width * layout.point_step)
    rows = np.pad(rows, ((0, 0), (0, layout.row_padding)), constant_values=0xA5)

    message = PointCloud2(height=layout.height, width=width, is_bigendian=layout.big_endian)
    message.header.frame_id = frame
    if stamp:
        message.header.stamp = stamp.to_msg()
    message.fields = [PointField(name=name, offset=at, datatype=kind, count=1) for name, at, kind in layout.fields]
    message.point_step = layout.point_step
    message.row_step = rows.shape[1]
    message.is_dense = not np.isnan(padded).any()
    message.data = rows.tobytes()
    return message
