"""Test helper: a node under test that subscribes to point clouds, with the two-link robot.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0). Every point has a radius of 0.02.
"""

from math import inf, pi

from clearance_msgs.msg import BodyPair
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2

from cell import Cell
from scene_client import SceneClient

ACCURACY = 1e-5  # [m] coordinates of single precision
RADIUS = 0.02
STRETCHED = {"joint1": 0, "joint2": 0}
FOLDED = {"joint1": 0, "joint2": 5 * pi / 6}
NEARBY = {"influence_distance": 0.5, "distance_limit": 3.0}
# Points that touch the robot would be taken for it.
UNFILTERED = {"self_filter_padding": 0.0}
AGELESS = UNFILTERED | {"point_cloud_topics": ["points"], "point_radius": RADIUS, "point_cloud_ttl": 3600.0}
QOS = QoSProfile(depth=10)

# 0.2 before the ball, and farther away all around.
WALL = [(2.3, y / 10, z / 10) for y in range(-5, 6) for z in range(-5, 6)]


class PointCloudNode(Cell):
    """A node that subscribes to the topic `points`."""

    def __init__(self, peer, *arguments, parameters=None, **options):
        super().__init__(peer, *arguments, parameters=NEARBY | AGELESS | (parameters or {}), **options)

    def __enter__(self):
        super().__enter__()
        self.scene = SceneClient(self)
        self.driver.report(**STRETCHED)
        return self

    def sees(self, message, qos=QOS):
        """The first state judged with this cloud, which gets a stamp of now."""
        message.header.stamp = self.peer.now().to_msg()
        self.scene.topic(PointCloud2, "points", qos)
        return self.scene.change(message, topic="points")

    def live(self, seconds):
        """From now on clouds count so long."""
        self.parameters.succeed(point_cloud_ttl=seconds)

    def reports(self, message, *words, qos=QOS):
        """The complaint about this cloud, which changes nothing."""
        message.header.stamp = self.peer.now().to_msg()
        self.scene.topic(PointCloud2, "points", qos)
        return self.scene.rejected(message, *words, topic="points")


def to_cloud(state):
    """The least distance to a body that is no link."""
    return min(
        (near.distance for near in state.pair_distances if BodyPair.OBSTACLE in (near.pair.type_a, near.pair.type_b)),
        default=inf,
    )
