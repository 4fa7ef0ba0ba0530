"""Test that a client with Cyclone DDS receives `~/is_free` of the node."""

import subprocess
import sys
import threading
from contextlib import contextmanager
from math import pi
from pathlib import Path

from node_process import environment_of_node

READER = Path(__file__).with_name("cyclone_reader.py")


@contextmanager
def received(peer, topic):
    """What Cyclone DDS hears on a topic of Bools: a list that grows."""
    command = [sys.executable, str(READER), str(peer.domain_id), topic]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env=environment_of_node(peer.domain_id, {"AMENT_PREFIX_PATH": None})
    )
    said = []

    def listen():
        for line in process.stdout:
            with peer.changed:
                said.append({"True": True, "False": False}[line.strip()])
                peer.changed.notify_all()

    listener = threading.Thread(target=listen, daemon=True)
    listener.start()
    try:
        yield said
        assert process.poll() is None, "the reader ended by itself"
    finally:
        process.kill()
        process.wait()
        listener.join()


def test_is_free_is_received_by_cyclone_dds(cell, peer):
    cell.evaluate(joint1=0, joint2=0)
    with received(peer, cell.node.private("is_free")) as said:
        peer.wait_for(lambda: True in said, "FREE by Cyclone DDS", deadline=60.0)
        before = len(said)
        cell.evaluate(joint1=0, joint2=pi)
        peer.wait_for(lambda: False in said[before:], "a collision by Cyclone DDS")
        before = len(said)
        cell.grows_old()
        cell.driver.pause()
        cell.unknown("stale")
        peer.wait_for(lambda: len(said) > before + 2, "more answers")
        assert said[-1] is False
        cell.driver.resume()
        cell.evaluate(joint1=0, joint2=0)
        peer.wait_for(lambda: said[-1] is True, "FREE again")
