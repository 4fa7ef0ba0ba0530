"""Test helper: prints a `std_msgs/Bool` topic, received with Cyclone DDS. cyclone_reader.py DOMAIN TOPIC

A process of its own: the libraries of rclpy's middleware are not to be mixed with these.
"""

import os
import sys
from dataclasses import dataclass

# what the machine has beside the loopback interface is none of its business
INTERFACE = '<NetworkInterface name="lo" multicast="true"/>'
os.environ["CYCLONEDDS_URI"] = (
    f"<CycloneDDS><Domain><General><Interfaces>{INTERFACE}</Interfaces></General></Domain></CycloneDDS>"
)

from cyclonedds.core import Policy, Qos  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.idl import IdlStruct  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402


@dataclass
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


def main(domain, name):
    qos = Qos(
        Policy.Reliability.Reliable(duration(seconds=1)),
        Policy.History.KeepLast(10),
        # as in other ROS clients: plain CDR, not the XCDR2 that Cyclone DDS asks for when it is left alone
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )
    participant = DomainParticipant(domain)
    reader = DataReader(participant, Topic(participant, "rt" + name, Bool, qos=qos), qos=qos)
    # whoever started this ends it
    while True:
        for sample in reader.take_iter(timeout=duration(seconds=1)):
            print(sample.data, flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
