"""Test helper: reads capsules from the markers of `~/swept_volume`."""

from math import dist

import pytest
from visualization_msgs.msg import Marker


def xyz(vector):
    return vector.x, vector.y, vector.z


def capsules(markers, link):
    """Ends and radius of a link's capsules in their order; each has its cylinder, if it is longer than a ball."""
    assert all((marker.action, marker.header.frame_id) == (Marker.ADD, "base") for marker in markers)
    shown = [marker for marker in markers if marker.ns == link]
    cylinders = {marker.id: marker for marker in shown if marker.type == Marker.CYLINDER}
    found = []
    for balls in (marker for marker in shown if marker.type == Marker.SPHERE_LIST):
        a, b = xyz(balls.points[0]), xyz(balls.points[-1])
        if len(balls.points) > 1:
            cylinder = cylinders.pop(balls.id - 1)
            assert xyz(cylinder.pose.position) == pytest.approx([(p + q) / 2 for p, q in zip(a, b, strict=True)])
            assert xyz(cylinder.scale) == pytest.approx((balls.scale.x, balls.scale.x, dist(a, b)))
        found.append((a, b, balls.scale.x / 2))
    assert not cylinders
    return found


def room(point, capsule):
    """How far inside a capsule a point is."""
    a, b, radius = capsule
    axis = [q - p for p, q in zip(a, b, strict=True)]
    along = sum(d * (x - p) for d, x, p in zip(axis, point, a, strict=True)) / (sum(d * d for d in axis) or 1)
    along = min(max(along, 0), 1)
    return radius - dist(point, [p + along * d for p, d in zip(a, axis, strict=True)])


def colours(markers, link):
    return [(marker.color.r, marker.color.g) for marker in markers if marker.ns == link and marker.color.a > 0]
