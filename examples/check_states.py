#!/usr/bin/env python3
"""Asks a running node about a state of its robot:  check_states.py [--node /clearance] joint=position ...

Joints that are not named stand where the robot is; where that is not known, at their defaults, and the answer says so.
Exit code 0: free; 1: not; 2: no answer.
"""

import argparse
import sys

import rclpy
from clearance_msgs.srv import CheckStates

ANSWER_WITHIN = 10.0  # [s]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--node", default="/clearance", help="the node's name with its namespace")
    parser.add_argument("joints", nargs="+", metavar="joint=position", help="rad or m")
    arguments = parser.parse_args()
    request = CheckStates.Request(with_distance=True)
    for word in arguments.joints:
        name, _, position = word.partition("=")
        try:
            request.positions.append(float(position))
        except ValueError:
            parser.error(f"'{word}' is not joint=position")
        request.joint_names.append(name)

    rclpy.init()
    node = rclpy.create_node("check_states_example")
    client = node.create_client(CheckStates, f"{arguments.node}/check_states")
    if not client.wait_for_service(ANSWER_WITHIN):
        print(f"{arguments.node} is not there: is it running, with this ROS_DOMAIN_ID?", file=sys.stderr)
        return 2
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=ANSWER_WITHIN)
    response = future.result()
    if response is None or response.verdict == CheckStates.Response.ERROR:
        print(response.message if response else "no answer came", file=sys.stderr)
        return 2
    if response.message:
        print(response.message)
    for verdict, distance, a, b in zip(response.verdicts, response.distances, response.pair_a, response.pair_b):
        word = {CheckStates.Response.FREE: "FREE", CheckStates.Response.COLLIDING: "COLLIDING"}.get(verdict, "UNKNOWN")
        pair = f": {response.bodies[a]} and {response.bodies[b]}" if a >= 0 else ""
        print(f"{word}, least distance {distance:.4f} m{pair}")
    return 0 if response.verdict == CheckStates.Response.FREE else 1


if __name__ == "__main__":
    sys.exit(main())
