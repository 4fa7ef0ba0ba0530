"""Test helper: publishes the pose of a robot's root in the world on `tf`."""

from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage


class Localization:
    """Publishes where the root is in `odom`, 50 times a second."""

    def __init__(self, cell):
        self.x = 0.0
        self.reported = 0  # transforms so far
        self.turn = 1.0  # the real part of the quaternion; there is no other
        self._peer = cell.peer
        self._publisher = cell.peer.node.create_publisher(TFMessage, cell.node.relative("tf"), 10)
        self._timer = cell.peer.node.create_timer(0.02, self._tick)

    def fall_silent(self):
        self._timer.cancel()

    def _tick(self):
        message = TransformStamped(child_frame_id="base")
        message.header.frame_id = "odom"
        message.header.stamp = self._peer.now().to_msg()
        message.transform.translation.x = self.x
        message.transform.rotation.w = self.turn
        self._publisher.publish(TFMessage(transforms=[message]))
        self.reported += 1
