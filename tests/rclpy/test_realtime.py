"""`use_realtime_priority`: which threads run before all others, and what is said where the system refuses it."""

import os
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

import pytest

import two_link
from node_process import BINARY
from realtime import may_be_realtime

WANTED = {"use_realtime_priority": True}
URGENT = ("RustDDS", "monitor")
AS_ANY_OTHER = ("loader", "motions", "states", "validity", "world", "services", "blocking-")


def policies(process_id):
    """Of the threads that there are, with their names."""
    for task in Path(f"/proc/{process_id}/task").iterdir():
        with suppress(FileNotFoundError, ProcessLookupError):
            yield (task / "comm").read_text().strip(), os.sched_getscheduler(int(task.name))


def test_a_node_runs_as_any_other(cell):
    cell.judged(joint1=0, joint2=0)
    assert {policy for _, policy in policies(cell.node.process_id)} == {os.SCHED_OTHER}


@pytest.mark.skipif(not may_be_realtime(), reason="the system refuses SCHED_FIFO to this user")
def test_what_hears_and_judges_runs_first(start):
    cell = start(parameters=WANTED)
    cell.judged(joint1=0, joint2=0)
    found = list(policies(cell.node.process_id))
    for names, wanted in ((URGENT, os.SCHED_FIFO), (AS_ANY_OTHER, os.SCHED_OTHER)):
        theirs = [(name, policy) for name, policy in found if name.startswith(names)]
        assert {name for name, _ in theirs} != set()
        assert all(policy == wanted for _, policy in theirs), theirs


def test_where_it_is_refused_the_node_does_not_start():
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
