"""Tests that the scripts of pages that use the Python package print what the pages show."""

import re
import subprocess
import sys

import pytest

from conftest import ROOT

PAGES = ["docs/plan/python.md", "docs/plan/motions.md", "docs/plan/planner.md", "docs/plan/ompl.md"]
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```)?", re.MULTILINE | re.DOTALL)
SCRIPTS = [script for page in PAGES for script in BLOCK.findall((ROOT / page).read_text())]


@pytest.mark.parametrize("code, output", SCRIPTS, ids=[code.splitlines()[0][:40] for code, _ in SCRIPTS])
def test_a_script_prints_what_the_page_shows(code, output, tmp_path):
    if "ompl" in code:
        pytest.importorskip("ompl", exc_type=ImportError)
    for name in ("urdf", "config"):
        (tmp_path / name).symlink_to(ROOT / name)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout == output


def test_there_are_scripts():
    assert len(SCRIPTS) >= 5
