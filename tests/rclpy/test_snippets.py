"""Tests that every script and command that README and docs show runs as the first action of a fresh process."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import two_link
from node_process import BINARY, ROOT, environment_of_node
from snippets import snippets

TIMEOUT = 100.0  # [s]
POSE = {"joint1": 0.0, "joint2": 0.18, "joint3": 0.0, "joint4": -1.873, "joint5": 0.0, "joint6": 0.0, "joint7": 0.0}
POSE |= {"finger_joint1": 0.0, "finger_joint2": 0.0}
# What differs from run to run, and hashes, of which pages show the first 12 digits.
VARYING = [re.compile(r"(?:loaded|decided) in \S+ s|planned in \S+ ms"), re.compile(r"\b[0-9a-f]{12}(…|[0-9a-f]{52}\b)")]
# Commands whose pages show the output for another robot than the one here.
SHOWN_FOR_ANOTHER_ROBOT = ("clearance doctor",)
# Snippets that cannot run here, by their beginning, and why.
NOT_HERE = {
    "cargo run --release": "builds the release",
    "cargo test": "runs this",
    "cargo install": "builds the release, and installs it for the machine",
    "ros2 topic echo": "needs ROS's command line, which has no wheels",
    "cd ~/ws": "needs colcon and ROS's command line",
    "pip install": "builds the release",
    "cmake -S": "builds the release",
    "python3 benches/plans/run.py --shared": "takes an hour, and needs the other planners",
    "python examples/roadmap_ray.py": "runs in tests/python, on a cluster",
    "clearance view": "runs in tests/view, in a browser",
    "crates/python/build_wheels.sh": "builds the release",
    "clearance replay run.mcap --save-test": "needs a recording that differs, as test_recording.py makes one",
}
# Exit codes of commands by a word of the output that the page shows; others end with 0.
EXIT_CODES = {"CONTACT": (1,), "COLLIDING": (1,), "WRONG": (0, 1)}


def is_run(snippet):
    return not any(snippet.code.startswith(beginning) for beginning in NOT_HERE)


def serves(snippet):
    """Whether it starts nodes, which go on until they are interrupted."""
    return snippet.code.startswith("clearance node")


COMMANDS = [snippet for snippet in snippets("sh") if is_run(snippet)]
# scripts of the Python package run in tests/python
SCRIPTS = [snippet for snippet in snippets("python") if "import clearance as cl" not in snippet.code]


@pytest.fixture
def demo(start):
    """The demo robot in its world, under the names that the pages use."""
    arguments = ["--srdf", "urdf/demo_arm/demo_arm.srdf", "--world", "config/demo_world.yaml"]
    cell = start(*arguments, urdf=Path("urdf/demo_arm/demo_arm.urdf"), name="clearance", namespace="")
    cell.evaluate(**POSE)
    return cell


@pytest.fixture
def home(tmp_path):
    """A user's folder: this repository's files, a folder of the path with `clearance` and this Python, and a robot of the user's own."""
    for entry in ROOT.iterdir():
        (tmp_path / entry.name).symlink_to(entry)
    # the environment's name depends on these files, and links are none
    (tmp_path / "interfaces").unlink()
    shutil.copytree(ROOT / "interfaces", tmp_path / "interfaces")
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/clearance").symlink_to(BINARY)
    python = tmp_path / "bin/python3"
    python.write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    python.chmod(0o755)
    (tmp_path / "ws/src").mkdir(parents=True)
    shutil.copy(ROOT / two_link.URDF, tmp_path / "robot.urdf")
    (tmp_path / "robot.srdf").write_text('<robot name="two_link"/>')
    (tmp_path / "scene.yaml").write_text("world:\n  collision_objects: []\n")
    return tmp_path


def process(command, home, domain_id, **options):
    """A process of a user."""
    path = f"{home / 'bin'}{os.pathsep}{os.environ['PATH']}"
    environment = environment_of_node(domain_id, {"PATH": path, "HOME": str(home)})
    environment.setdefault("CLEARANCE_CACHE", str(Path.home() / ".cache/clearance"))
    return subprocess.Popen(command, env=environment, cwd=home, text=True, **options)


def run(command, home, domain_id):
    """Exit code, stdout and stderr."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with process(command, home, domain_id, **pipes) as running:
        output, errors = running.communicate(timeout=TIMEOUT)
    return running.returncode, output, errors


def without_varying(output):
    for varying in VARYING:
        output = varying.sub("", output)
    return output


@pytest.mark.parametrize("snippet", SCRIPTS, ids=str)
def test_a_script_runs(demo, home, snippet):
    code, output, errors = run([sys.executable, "-c", snippet.code], home, demo.peer.domain_id)
    assert (code, errors) == (0, "")
    assert output.strip()


@pytest.mark.parametrize("snippet", SCRIPTS, ids=str)
def test_a_script_without_a_node_says_so_and_ends(home, domain_id, snippet):
    hurried = re.sub(r"timeout ?= ?10\.0", "timeout = 0.5", snippet.code)
    assert hurried != snippet.code
    code, _, errors = run([sys.executable, "-c", hurried], home, domain_id)
    assert code == 1
    assert "is the node running" in errors


@pytest.mark.parametrize("snippet", [snippet for snippet in COMMANDS if not serves(snippet)], ids=str)
def test_a_command_prints_what_the_page_shows(demo, home, snippet):
    domain_id = demo.peer.domain_id
    code, output, errors = run(["bash", "-c", snippet.code], home, domain_id)
    codes = next((codes for word, codes in EXIT_CODES.items() if word in snippet.output), (0,))
    assert code in codes, errors
    if snippet.output and not snippet.code.startswith(SHOWN_FOR_ANOTHER_ROBOT):
        assert without_varying(output) == without_varying(snippet.output)


@pytest.mark.parametrize("snippet", [snippet for snippet in COMMANDS if serves(snippet)], ids=str)
def test_a_node_starts_and_what_follows_it_runs(peer, home, snippet):
    """The first command goes on until it is interrupted; each further line runs after that."""
    lines = snippet.code.replace("\\\n", " ").splitlines()
    log = home / "log"
    with log.open("w") as output, process(["bash", "-c", f"exec {lines[0]}"], home, peer.domain_id, stderr=output) as node:
        peer.wait_for(lambda: "listens to" in log.read_text() or node.poll() is not None, "the node")
        node.send_signal(signal.SIGINT)
        assert node.wait(TIMEOUT) == 0, log.read_text()
    for line in lines[1:]:
        code, _, errors = run(["bash", "-c", line], home, peer.domain_id)
        assert code == 0, errors
