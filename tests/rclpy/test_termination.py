"""The node ends within 2 s of a signal, whatever it is doing."""

import os
import signal
import time

import pytest
from std_msgs.msg import String

import two_link

LIMIT = 2.0  # [s] what the interface promises
TIMES = int(os.environ.get("CLEARANCE_SIGNALS", "1"))  # of every load and signal


def chain(links):
    """A chain of boxes, of which almost every pair has to be checked: it takes seconds to build."""
    box = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    text = [f'<robot name="chain"><link name="l0">{box}</link>']
    for number in range(1, links):
        text.append(
            f'<link name="l{number}">{box}</link><joint name="j{number}" type="revolute"><parent link="l{number - 1}"/>'
            f'<child link="l{number}"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    return "".join(text) + "</robot>"


def building_a_model(cell):
    """A large description has arrived and is being read or built."""
    publisher = cell.peer.latch(String(data=two_link.description()), cell.node.relative("robot_description"))
    cell.has_model()
    publisher.publish(String(data=chain(800)))
    cell.unknown("model_swap")


def flooded(cell):
    """Joint states as fast as they can be published."""
    for _ in range(2000):
        cell.driver.report(joint1=0, joint2=0)


def idle(cell):
    cell.unknown("no_model")


@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGINT], ids=lambda by: by.name)
@pytest.mark.parametrize("load", [idle, building_a_model, flooded], ids=lambda load: load.__name__)
def test_the_node_ends_in_time_under_load(start, load, by):
    for _ in range(TIMES):
        cell = start(urdf=None)
        cell.unknown("no_model")
        load(cell)
        begin = time.monotonic()
        code = cell.node.stop(by)
        assert code == 0, f"ended with {code}"
        assert time.monotonic() - begin < LIMIT
