"""Test helper: a tracker, which publishes pose and velocity of a moving obstacle on `~/obstacle_states`."""

from clearance_msgs.msg import ObstacleState, ObstacleStates
from rclpy.time import Time

from scene import pose


class Tracker:
    """Publishes the state of a cart that moves along x, 50 times a second."""

    def __init__(self, cell, x, speed, name="cart", damage=lambda state: None):
        self.name, self.speed = name, speed
        self._damage = damage
        self._peer = cell.peer
        self._publisher = cell.peer.node.create_publisher(ObstacleStates, cell.node.private("obstacle_states"), 10)
        cell.peer.wait_for(self._publisher.get_subscription_count, "a subscription of ~/obstacle_states")
        self._from = (x, cell.peer.now())
        self._timer = cell.peer.node.create_timer(0.02, self.publish)

    def at(self, stamp):
        """The cart's x at a time."""
        x, since = self._from
        return x + self.speed * (Time.from_msg(stamp) - since).nanoseconds * 1e-9

    def goes_on(self, x, speed):
        self._from, self.speed = (x, self._peer.now()), speed

    def falls_silent(self):
        self._timer.cancel()
        self._peer.between_callbacks(lambda: None)

    def publish(self):
        stamp = self._peer.now().to_msg()
        state = ObstacleState(name=self.name, pose=pose(self.at(stamp), 0, 0))
        state.twist.linear.x = float(self.speed)
        self._damage(state)
        message = ObstacleStates(obstacles=[state])
        message.header.stamp = stamp
        message.header.frame_id = "base"
        self._publisher.publish(message)
