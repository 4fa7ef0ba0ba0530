"""Test helper: extracts the commands and scripts that README, CONTRIBUTING and docs show."""

import re
from dataclasses import dataclass

from node_process import ROOT

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```\n(?:\n```text\n(.*?)^```)?", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Snippet:
    file: str
    language: str
    code: str
    output: str  # what the page shows below it, or nothing

    def __str__(self):
        return f"{self.file}: {self.code.splitlines()[0][:60]}"


def snippets(language):
    """Those of a language, in the order of the pages."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [
        Snippet(str(page.relative_to(ROOT)), found[1], found[2], found[3] or "")
        for page in pages
        for found in BLOCK.finditer(page.read_text())
        if found[1] == language
    ]
