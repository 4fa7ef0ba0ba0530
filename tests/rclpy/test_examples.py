"""Tests of the example `check_states.py`: its output and exit codes."""

import subprocess
import sys
from math import pi

import pytest

from node_process import ROOT, environment_of_node


def example(cell, *arguments):
    command = [sys.executable, ROOT / "examples/check_states.py", "--node", cell.node.path, *arguments]
    environment = environment_of_node(cell.peer.domain_id, {})
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=100)


@pytest.mark.parametrize(
    ("joint2", "code", "said"),
    [(0.0, 0, "FREE, least distance 0.7000 m: base and tip"), (pi, 1, "COLLIDING, least distance 0.0000 m: base and tip")],
)
def test_a_state_is_asked_about(cell, joint2, code, said):
    cell.evaluate(joint1=0, joint2=0)
    done = example(cell, f"joint2={joint2}")
    assert (done.returncode, done.stderr) == (code, "")
    assert done.stdout.strip() == said


@pytest.mark.parametrize(("word", "said"), [("elbow=1", "'elbow'"), ("joint2", "'joint2'"), ("joint2=abc", "'joint2=abc'")])
def test_what_is_wrong_is_reported(cell, word, said):
    cell.evaluate(joint1=0, joint2=0)
    done = example(cell, word)
    assert done.returncode == 2
    assert said in done.stderr
