"""Test helper: a publisher of a robot description, or a client, in a process of its own.

python another_participant.py describe TOPIC: publishes the description on standard input, latched, until it is killed.
python another_participant.py check_motion PREFIX: calls this service once, and prints the verdict and the time [s] from its start.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

DEADLINE = 60.0  # [s] for one call, from the start of the process


def _start(arguments, domain_id, **pipes):
    command = [sys.executable, "-B", Path(__file__).resolve(), *arguments]
    return subprocess.Popen(command, env=os.environ | {"ROS_DOMAIN_ID": str(domain_id)}, text=True, **pipes)


class Describer:
    """Publisher of a robot description."""

    def __init__(self, topic, description, domain_id):
        self._process = _start(["describe", topic], domain_id, stdin=subprocess.PIPE)
        self._process.stdin.write(description)
        self._process.stdin.close()

    def kill(self):
        self._process.kill()
        self._process.wait()


def call_of_another_client(prefix, domain_id):
    """The verdict on a short motion of the two-link robot, from a client that comes, calls once and goes; and the time [s] that it took."""
    process = _start(["check_motion", prefix], domain_id, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)
    output, _ = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0, output
    verdict, seconds = output.split()
    return int(verdict), float(seconds)


def _describe(topic):
    import rclpy
    from peer import LATCHED
    from std_msgs.msg import String

    rclpy.init()
    node = rclpy.create_node("describer", enable_rosout=False, start_parameter_services=False)
    publisher = node.create_publisher(String, topic, LATCHED)
    publisher.publish(String(data=sys.stdin.read()))
    rclpy.spin(node)


def _check_motion(prefix):
    from motions import Motions
    from peer import Peer

    class Prefix:
        def private(self, name):
            return f"{prefix}/{name}"

    start = time.monotonic()
    with Peer(int(os.environ["ROS_DOMAIN_ID"])) as peer:
        verdict = Motions(peer, Prefix()).check((0, 0), (0.1, 0)).verdict
        print(verdict, time.monotonic() - start, flush=True)


if __name__ == "__main__":
    {"describe": _describe, "check_motion": _check_motion}[sys.argv[1]](sys.argv[2])
