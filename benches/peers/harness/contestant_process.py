"""Process of one contestant: starts it, sends it one line per command, and reads one line per response."""

from __future__ import annotations

import subprocess
from contextlib import suppress
from pathlib import Path


class Failed(Exception):
    """A contestant broke, or refused what it was given."""


class Child:
    def __init__(self, name: str, command: list[str | Path]) -> None:
        self.name = name
        self._process = subprocess.Popen(
            [str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    @property
    def pid(self) -> int:
        return self._process.pid

    def ask(self, *words: object) -> list[str] | None:
        """The words of the answer; None if the contestant does not know the question."""
        assert self._process.stdin and self._process.stdout
        try:
            self._process.stdin.write("\t".join(str(word) for word in words) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except BrokenPipeError:
            line = ""
        status, _, rest = line.rstrip("\n").partition("\t")
        if status == "unsupported":
            return None
        if status != "ok":
            ended = f"ended with code {self._process.wait()}" if not line else rest
            raise Failed(f"{self.name}, asked {' '.join(str(word) for word in words[:3])}: {ended}")
        return rest.split("\t")

    def close(self) -> None:
        assert self._process.stdin
        with suppress(BrokenPipeError):  # it has ended already
            self._process.stdin.close()
        self._process.wait()
