"""The command ``clearance``: the command line of the binary, in this process."""

from __future__ import annotations

import signal
import sys

from ._clearance import _run_command


def main() -> int:
    """Runs the command line of this process and returns its exit code."""
    # Python's handler would only act once the command has ended; a signal that is ignored stays so, as in the binary
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _run_command(["clearance", *sys.argv[1:]])
