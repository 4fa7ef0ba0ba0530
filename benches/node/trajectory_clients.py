"""Load generator: clients that call `~/check_trajectory` without pause.

Usage: python trajectory_clients.py SERVICE COUNT JOINTS.

Says `ready` when the service is met, and when asked to end how many answers of which verdict came.
"""

import signal
import sys
import time
from collections import Counter

import rclpy
from clearance_msgs.srv import CheckTrajectory
from rclpy.qos import QoSProfile
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

BURST = QoSProfile(depth=200)  # every client hears the answers to all others
PATIENCE = 60.0  # [s]
REACH = 0.2  # [rad, m] from zero
VERDICTS = {0: "error", 1: "free", 2: "contact", 3: "undecided"}


def trajectory(joints, number):
    """There and back, a little different for each client."""
    reach = REACH * (1 + 0.1 * number)
    points = [[0.0] * len(joints), [reach] * len(joints), [-reach] * len(joints), [0.0] * len(joints)]
    return JointTrajectory(joint_names=joints, points=[JointTrajectoryPoint(positions=point) for point in points])


def main(service, count, joints):
    rclpy.init()
    node = rclpy.create_node("trajectory_clients", enable_rosout=False)
    verdicts = Counter()
    ended = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))

    def ask(client, request):
        def responded(future):
            response = future.result()
            verdicts[response.reason_code or VERDICTS[response.verdict]] += 1
            ask(client, request)

        client.call_async(request).add_done_callback(responded)

    clients = [node.create_client(CheckTrajectory, service, qos_profile=BURST) for _ in range(int(count))]
    deadline = time.monotonic() + PATIENCE
    while not all(client.service_is_ready() for client in clients):
        if time.monotonic() > deadline:
            sys.exit(f"{service} was not met in {PATIENCE:g} s")
        rclpy.spin_once(node, timeout_sec=0.05)
    for number, client in enumerate(clients):
        ask(client, CheckTrajectory.Request(trajectory=trajectory(joints.split(","), number)))
    start = time.monotonic()
    print("ready", flush=True)
    while not ended:
        rclpy.spin_once(node, timeout_sec=0.05)
    seconds = time.monotonic() - start
    reported = ", ".join(f"{number} {verdict}" for verdict, number in verdicts.items()) or "none"
    print(f"{verdicts.total() / seconds:.1f} answers a second ({reported})", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
