"""Tests of `use_realtime_priority`: which threads get priority, and the error where the system rejects it."""

import os
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

import pytest

import two_link
from node_process import BINARY
from realtime import may_be_realtime
from states import States

WANTED = {"use_realtime_priority": True}
URGENT = ("RustDDS", "monitor")
AS_ANY_OTHER = ("loader", "motions", "states", "validity", "world", "services", "blocking-")


def policies(process_id):
    """Of the threads that there are, with their names."""
    for task in Path(f"/proc/{process_id}/task").iterdir():
        with suppress(FileNotFoundError, ProcessLookupError):
            yield (task / "comm").read_text().strip(), os.sched_getscheduler(int(task.name))


def test_a_node_runs_as_any_other(cell):
    cell.evaluate(joint1=0, joint2=0)
    assert {policy for _, policy in policies(cell.node.process_id)} == {os.SCHED_OTHER}


@pytest.mark.skipif(not may_be_realtime(), reason="the system refuses SCHED_FIFO to this user")
def test_receiving_and_evaluating_threads_run_first(start):
    cell = start(parameters=WANTED)
    cell.evaluate(joint1=0, joint2=0)
    theirs = lambda names: [(name, policy) for name, policy in policies(cell.node.process_id) if name.startswith(names)]
    urgent = theirs(URGENT)
    assert urgent and all(policy == os.SCHED_FIFO for _, policy in urgent), urgent
    assert theirs(AS_ANY_OTHER)
    # While they call the network library they have its priority.
    is_given_back = lambda: all(policy == os.SCHED_OTHER for _, policy in theirs(AS_ANY_OTHER))
    cell.peer.wait_for(is_given_back, "threads as any other")


@pytest.mark.skipif(not may_be_realtime(), reason="the system refuses SCHED_FIFO to this user")
def test_services_answer_with_priorities_lent_and_given_back(start):
    cell = start(parameters=WANTED)
    cell.evaluate(joint1=0, joint2=0)
    states = States(cell.peer, cell.node)
    for _ in range(100):
        assert states.check([[0.0, 0.0]]).reason_code == ""
    is_given_back = lambda: all(
        policy == os.SCHED_OTHER for name, policy in policies(cell.node.process_id) if name.startswith(AS_ANY_OTHER)
    )
    cell.peer.wait_for(is_given_back, "threads as any other")


def test_where_it_is_rejected_the_node_does_not_start():
    without = []
    if may_be_realtime():
        if not shutil.which("setpriv"):
            pytest.skip("setpriv is not here")
        without = ["setpriv", "--bounding-set=-sys_nice", "--inh-caps=-sys_nice", "prlimit", "--rtprio=0"]
    command = [*without, BINARY, "node", "--urdf", two_link.URDF, "--ros-args", "-p", "use_realtime_priority:=true"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 2
    assert "use_realtime_priority: the system refuses it (Operation not permitted" in ended.stderr
    assert "rtprio" in ended.stderr
