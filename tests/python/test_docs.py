"""The scripts of the page about Python print what the page shows."""

import re
import subprocess
import sys

import pytest

from conftest import ROOT

PAGE = "docs/plan/python.md"
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```)?", re.MULTILINE | re.DOTALL)
SCRIPTS = BLOCK.findall((ROOT / PAGE).read_text())


@pytest.mark.parametrize("code, output", SCRIPTS, ids=[code.splitlines()[0][:40] for code, _ in SCRIPTS])
def test_a_script_prints_what_the_page_shows(code, output, tmp_path):
    for name in ("urdf", "config"):
        (tmp_path / name).symlink_to(ROOT / name)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout == output


def test_there_are_scripts():
    assert len(SCRIPTS) >= 4
