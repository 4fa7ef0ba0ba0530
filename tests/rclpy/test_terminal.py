"""Tests of terminal output: the live table of the demo, and no address of a view that is never served."""

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import termios
from time import monotonic

import pytest

from node_process import BINARY, EXIT_DEADLINE, ROOT, environment_of_node

COLUMNS, ROWS = 100, 40
START_DEADLINE = 60.0  # [s]


class Terminal:
    """A program on a terminal, and the screen that it has drawn."""

    def __init__(self, command, domain_id):
        self.pid, self.file = pty.fork()
        if self.pid == 0:
            os.chdir(ROOT)
            os.execve(command[0], command, environment_of_node(domain_id, {"TERM": "xterm"}))
        fcntl.ioctl(self.file, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
        self.written = ""

    def read_until(self, found, deadline):
        end = monotonic() + deadline
        while not found(self.screen()):
            assert monotonic() < end, self.screen()
            if select.select([self.file], [], [], 0.1)[0]:
                try:
                    data = os.read(self.file, 65536)
                except OSError:  # the program has ended
                    return
                if not data:
                    return
                self.written += data.decode(errors="replace")

    def press(self, key):
        os.write(self.file, key)

    def wait(self):
        _, status = os.waitpid(self.pid, 0)
        os.close(self.file)
        return os.waitstatus_to_exitcode(status)

    def screen(self):
        """The lines that a terminal shows after all that was written."""
        lines, row, column = [[]], 0, 0
        for control, number, kind in re.findall(r"(\x1b\[([0-9;]*)([A-Za-z])|[^\x1b])", self.written):
            if kind:
                count = int(number) if number.isdigit() else 1
                if kind == "A":
                    row = max(0, row - count)
                elif kind == "B":
                    row += count
                elif kind == "K":
                    lines[row] = []
            elif control == "\r":
                column = 0
            elif control == "\n":
                row += 1
            elif control < " ":
                pass  # what the terminal echoes of a control key has no width
            else:
                if column == COLUMNS:
                    row, column = row + 1, 0
                while len(lines) <= row:
                    lines.append([])
                line = lines[row]
                line.extend(" " * (column + 1 - len(line)))
                line[column] = control
                column += 1
            while len(lines) <= row:
                lines.append([])
        return ["".join(line).rstrip() for line in lines]


def test_ctrl_c_leaves_one_table_behind(domain_id):
    terminal = Terminal([BINARY], domain_id)
    is_drawn = lambda lines: any("pairs" in line for line in lines) and any("FREE" in line for line in lines)
    terminal.read_until(is_drawn, START_DEADLINE)
    terminal.press(b"\x03")
    terminal.read_until(lambda lines: False, START_DEADLINE)
    assert terminal.wait() == 0
    lines = terminal.screen()
    for label in "status", "nearest", "distance", "self", "world", "rate", "a check":
        assert sum(re.match(rf" *{label}  ", line) is not None for line in lines) == 1, "\n".join(lines)


@pytest.mark.parametrize("world", ["nowhere.yaml", "Cargo.toml"])
def test_the_address_of_a_view_that_is_never_served_is_not_reported(domain_id, world):
    command = [BINARY, "node", "--urdf", "urdf/two_link/two_link.urdf", "--world", world, "--view", "0"]
    environment = environment_of_node(domain_id, {})
    result = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=EXIT_DEADLINE)
    assert result.returncode == 2
    assert world in result.stderr
    assert result.stdout == ""
