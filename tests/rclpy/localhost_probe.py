"""Test helper: counts the packets of a node on an interface other than loopback, with a peer on localhost.

Run it in a network namespace of its own: localhost_probe.py DOMAIN_ID [VARIABLE=VALUE of the node]...
"""

import os
import subprocess
import sys
from pathlib import Path

from cell import Cell
from peer import Peer

# A pair of virtual Ethernet ends: what goes out of one counts as sent, and the other is nobody.
# Without IPv6 the kernel itself sends nothing there.
NETWORK = """
ip link set lo up
ip link set lo multicast on
ip link add out type veth peer name nobody
[ ! -e /proc/sys/net/ipv6 ] || echo 1 > /proc/sys/net/ipv6/conf/out/disable_ipv6
ip addr add 10.0.0.1/24 dev out
ip link set nobody up
ip link set out up
ip route add 224.0.0.0/4 dev {multicast}
"""


def packets_sent(interface):
    lines = Path("/proc/self/net/dev").read_text().splitlines()
    fields = next(line.split(":")[1].split() for line in lines if line.split(":")[0].strip() == interface)
    return int(fields[9])


def main(domain_id, *of_node):
    of_node = dict(assignment.split("=") for assignment in of_node)
    subprocess.run(["sh", "-euc", NETWORK.format(multicast="lo" if of_node else "out")], check=True)

    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": None} | of_node
    # Without a driver: Fast DDS sends joint states by multicast to a RustDDS subscriber, and on every interface
    # whatever its own discovery range is, so they would be counted as the node's.
    with Peer(int(domain_id)) as peer, Cell(peer, environment=environment, driving=False) as cell:
        peer.wait_for(lambda: len(cell.states.all()) >= 100, "100 states")
        print(packets_sent("out"))


main(*sys.argv[1:])
