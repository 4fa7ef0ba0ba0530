"""Test helper: publishes joint states at a steady rate, in a process of its own, with little CPU time.

python joint_state_source.py TOPIC RATE JOINTS: JOINTS is a JSON object, the least and greatest position of each joint by name.
"""

import json
import os
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

MARK = 0.123456789  # a position that stands nowhere else in a message
PERIOD = 20.0  # [s] of a joint's swing
PART = 0.8  # of the way from the middle to a limit
LATE = 0.1  # [s] after which what was missed is not made up for


class Source:
    """Such a process, from the side that starts it."""

    def __init__(self, topic, rate, joints, domain_id):
        command = [sys.executable, "-B", Path(__file__).resolve(), topic, str(rate), json.dumps(joints)]
        environment = os.environ | {"ROS_DOMAIN_ID": str(domain_id)}
        self._process = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()

    def kill(self):
        """Ends the process as a crash does."""
        self._process.kill()
        self._process.wait()


class Template:
    """A serialized joint state in which stamp and positions are replaced in place."""

    STAMP = 4  # bytes of the header of CDR

    def __init__(self, names):
        from rclpy.serialization import serialize_message
        from sensor_msgs.msg import JointState

        message = JointState(name=names, position=[MARK] * len(names))
        self._bytes = bytearray(serialize_message(message))
        self._positions = struct.Struct(f"<{len(names)}d")
        self._at = self._bytes.index(self._positions.pack(*message.position))

    def filled(self, nanoseconds, positions):
        struct.pack_into("<iI", self._bytes, self.STAMP, *divmod(nanoseconds, 10**9))
        self._positions.pack_into(self._bytes, self._at, *positions)
        return bytes(self._bytes)


def swing(joints):
    """All positions at a time [s]: every joint swings about the middle of its range, each with a period of its own."""
    from math import sin, tau

    ranges = [
        ((upper + lower) / 2, PART * (upper - lower) / 2, tau / (PERIOD * (1 + 0.13 * number)))
        for number, (lower, upper) in enumerate(joints.values())
    ]
    return lambda time: [middle + reach * sin(rate * time) for middle, reach, rate in ranges]


def main(topic, rate, joints):
    import rclpy
    from sensor_msgs.msg import JointState

    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    rclpy.init()
    node = rclpy.create_node("joint_state_source", enable_rosout=False, start_parameter_services=False)
    publisher = node.create_publisher(JointState, topic, 10)
    joints = json.loads(joints)
    template, positions = Template(list(joints)), swing(joints)
    start = due = time.monotonic()
    while True:
        publisher.publish(template.filled(time.time_ns(), positions(due - start)))
        due += 1 / float(rate)
        late = time.monotonic() - due
        if late < 0:  # nothing is waited for: this is the rate
            time.sleep(-late)
        elif late > LATE:
            due += late


if __name__ == "__main__":
    main(*sys.argv[1:])
