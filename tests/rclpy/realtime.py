"""Test helper: checks whether this user may run threads with realtime priority (SCHED_FIFO, priority 49)."""

import subprocess
import sys


def may_be_realtime():
    take = "import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(49))"
    return subprocess.run([sys.executable, "-c", take], stderr=subprocess.DEVNULL, check=False).returncode == 0
