"""Test helper: the binary under test, as a process of its own."""

import os
import signal
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BINARY = os.environ.get("CLEARANCE_BIN", str(ROOT / "target/release/clearance"))

EXIT_DEADLINE = 10.0  # [s] a node that needs longer to end than this does not end


class NodeProcess:
    """`clearance node` with a name and a namespace of its own.

    `environment` changes that of this process; None unsets a variable. `output` is where it writes to instead of a file,
    `prefix` a command that runs it.
    As a context it must end cleanly: only when asked to, with exit code 0, without a panic.
    """

    running = []

    def __init__(
        self, *arguments, domain_id, name="clearance", namespace="", parameters=None, ros_arguments=(), environment=None, output=None, prefix=()
    ):
        self.name = name
        self.namespace = namespace
        command = [*prefix, BINARY, "node", *map(str, arguments), "--ros-args", "-r", f"__node:={name}"]
        if namespace:
            command += ["-r", f"__ns:={namespace}"]
        for key, value in (parameters or {}).items():
            command += ["-p", f"{key}:={yaml_text(value)}"]
        command += ros_arguments

        self._asked_to_end = False
        self._output = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            command,
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=output or self._output,
            stderr=subprocess.STDOUT,
            env=environment_of_node(domain_id, environment or {}),
        )

    def __enter__(self):
        NodeProcess.running.append(self)
        return self

    def __exit__(self, kind, *_):
        try:
            if kind is None:
                if not self._asked_to_end:
                    assert self.exit_code is None, f"{self.path} ended by itself with {self.exit_code}"
                    assert self.stop() == 0, f"{self.path} ended with {self.exit_code}"
                assert "panicked" not in self.output(), f"{self.path} panicked"
        except AssertionError as error:
            raise AssertionError(f"{error}\n{self.output()}") from None
        finally:
            NodeProcess.running.remove(self)
            self.kill()

    @property
    def path(self):
        """The fully qualified name."""
        return f"{self.namespace}/{self.name}"

    def private(self, topic):
        """The absolute name of `~/topic`."""
        return f"{self.path}/{topic}"

    def relative(self, topic):
        """The absolute name of a relative topic."""
        return f"{self.namespace}/{topic}"

    @property
    def process_id(self):
        return self._process.pid

    @property
    def exit_code(self):
        """None while the process runs."""
        return self._process.poll()

    def ended(self):
        """The exit code of a process that was to end by itself."""
        self._asked_to_end = True
        return self._process.wait(EXIT_DEADLINE)

    def stop(self, by=signal.SIGINT):
        """Asks the process to end and gives its exit code; one that does not end is killed and fails the test."""
        self._asked_to_end = True
        self._process.send_signal(by)
        try:
            return self._process.wait(EXIT_DEADLINE)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f"{self.path} still ran {EXIT_DEADLINE} s after {by.name}") from None

    def kill(self):
        """Ends the process as a crash does."""
        self._asked_to_end = True
        self._process.kill()
        self._process.wait()

    def output(self):
        """What it has written to stdout and stderr so far."""
        size = os.fstat(self._output.fileno()).st_size
        return os.pread(self._output.fileno(), size, 0).decode(errors="replace")


def environment_of_node(domain_id, changes):
    """That of a user: without what the wheels of rclpy set so that their libraries find each other."""
    of_the_wheels = {"LD_LIBRARY_PATH": None, "_ROS_WHEELS_BOOTSTRAP_COMPLETE": None}
    environment = os.environ | of_the_wheels | {"ROS_DOMAIN_ID": str(domain_id)} | changes
    return {variable: value for variable, value in environment.items() if value is not None}


def yaml_text(value):
    """A parameter value as ROS 2 reads it from a command line."""
    return str(value).lower() if isinstance(value, bool) else str(value)
