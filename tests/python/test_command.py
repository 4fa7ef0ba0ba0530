"""Tests of the command `clearance` of the package: output, exit codes and signals, as of the binary."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import clearance as cl
from conftest import ROOT, SRDF, URDF, WORLD

COMMAND = Path(sys.executable).with_name("clearance")
MODEL = ["--urdf", str(URDF), "--srdf", str(SRDF), "--world", str(WORLD)]


def run(*arguments, command=(str(COMMAND),), **options):
    return subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=120, cwd=ROOT, **options)


@pytest.mark.parametrize(
    "arguments, code, output, errors",
    [
        (["check", *MODEL, "--state", "joint2=0.1 joint4=-1.6"], 0, "state 0: free", ""),
        (["check", *MODEL, "--state", "joint2=1.7"], 1, "COLLIDING", ""),
        (["check", *MODEL, "--state", "joint9=1"], 2, "", "joint9"),
        (["check", "--urdf", "none.urdf", "--state", "j=1"], 2, "", "clearance: none.urdf"),
        (["chekc"], 2, "", "chekc"),
        (["--version"], 0, f"clearance {cl.__version__}\n", ""),
        (["check", "--help"], 0, "Usage: clearance check", ""),
    ],
)
def test_exit_codes_and_output(arguments, code, output, errors):
    ended = run(*arguments)
    assert (ended.returncode, output in ended.stdout, errors in ended.stderr) == (code, True, True), ended
    assert (not ended.stderr) == (not errors) and (not ended.stdout) == (not output)
    module = run(*arguments, command=(sys.executable, "-m", "clearance"))
    assert (module.returncode, module.stderr) == (ended.returncode, ended.stderr)


def test_a_certificate_of_the_command_is_read(tmp_path, robot, world):
    file = tmp_path / "proof.json"
    ends = ["--from", "joint2=0.1 joint4=-1.6", "--to", "joint2=0.15 joint4=-1.6"]
    assert run("motion", *MODEL, *ends, "--certificate", str(file)).returncode == 0
    edge = (robot.configuration({"joint2": 0.1, "joint4": -1.6}), robot.configuration({"joint2": 0.15, "joint4": -1.6}))
    certificate = cl.Certificate.load(file)
    assert cl.verify(certificate, robot, world, edge=edge)
    assert cl.Checker(robot, world).check_motion(*edge, certificate=True).certificate == certificate
    certificate.save(tmp_path / "again.json")
    assert run("verify", *MODEL, str(tmp_path / "again.json"), *ends).returncode == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_command_at_once(number):
    """As without Python: the process ends by the signal. A shell ignores SIGINT in what it starts in the background."""
    command = [str(COMMAND), "bench", "--urdf", str(URDF), "--states", "1000000", "--obstacles", "1000"]
    restored = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(command, cwd=ROOT, **silent, **restored) as process:
        try:
            wait_for_threads(process)
            process.send_signal(number)
            assert process.wait(60) == -number
        finally:
            process.kill()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_node_ends_in_order(number):
    arguments = ["node", "--urdf", str(URDF), "--srdf", str(SRDF), "--log-level", "info"]
    environment = {**os.environ, "ROS_LOCALHOST_ONLY": "1"}
    with subprocess.Popen([str(COMMAND), *arguments], stderr=subprocess.PIPE, text=True, env=environment) as process:
        try:
            first = process.stderr.readline()
            assert first
            while "joint_states" not in first:
                first = process.stderr.readline()
                assert first, "the node ended"
            process.send_signal(number)
            process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 0


def wait_for_threads(process):
    """Until Python has started the command, which starts threads."""
    while process.poll() is None and len(os.listdir(f"/proc/{process.pid}/task")) == 1:
        pass
    assert process.poll() is None
