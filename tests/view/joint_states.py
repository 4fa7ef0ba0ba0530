"""Test helper: publishes joint states ("q1 q2", rad) of the two-link robot from stdin; an empty line pauses it."""

import sys
import threading

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState

PERIOD = 0.05  # [s]


def main():
    rclpy.init()
    node = Node("driver", enable_rosout=False)
    publisher = node.create_publisher(JointState, "joint_states", 10)
    position = []

    def publish():
        if position:
            message = JointState(name=["joint1", "joint2"], position=list(position))
            message.header.stamp = node.get_clock().now().to_msg()
            publisher.publish(message)

    node.create_timer(PERIOD, publish)
    threading.Thread(target=rclpy.spin, args=[node], daemon=True).start()
    for line in sys.stdin:
        position[:] = map(float, line.split())


main()
