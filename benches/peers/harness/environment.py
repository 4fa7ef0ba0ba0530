"""Installs and builds the contestants: PyPI wheels, the C++ programs for Coal and FCL, and this library's program."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PEERS = Path(__file__).resolve().parent.parent
ROOT = PEERS.parent.parent

# What the pkg-config file of the coal wheel says; cmeel's wheels put headers and libraries under one prefix.
COAL_DEFINITIONS = ["COAL_HAS_OCTOMAP", "COAL_HAVE_OCTOMAP"] + [
    f"OCTOMAP_{part}_VERSION={value}" for part, value in (("MAJOR", 1), ("MINOR", 10), ("PATCH", 0))
]


class MissingTool(Exception):
    """Something that the comparison needs is not on this machine; the message says what to do."""


@dataclass(frozen=True)
class Environment:
    python: Path
    coal: Path
    # None where its library is not installed; `notes` say so.
    fcl: Path | None
    clearance: Path
    # None where it cannot be installed; `notes` say why.
    tesseract: Path | None
    versions: dict[str, str]
    notes: list[str]


def prepare() -> Environment:
    """Makes what is missing; minutes at first, seconds later."""
    if sys.version_info < (3, 10):
        raise MissingTool("needs Python 3.10 or newer")
    tools = {"g++": "apt-get install g++", "cargo": "https://rustup.rs", "git": "apt-get install git"}
    for tool, source in tools.items():
        if shutil.which(tool) is None:
            raise MissingTool(f"needs {tool} ({source})")
    with _venv("peers", PEERS / "requirements.txt") as venv:
        coal = _build_coal(venv)
    notes: list[str] = []
    fcl_version = _fcl_version()
    if fcl_version is None:
        notes.append("FCL from C++ is left out: it needs apt-get install libfcl-dev pkg-config")
    fcl = _build_fcl(fcl_version) if fcl_version else None
    # apart from the others, so that neither takes the other's NumPy, and so that all else goes on without it
    tesseract = None
    try:
        with _venv("tesseract", PEERS / "requirements-tesseract.txt") as apart:
            tesseract = apart / "bin/python"
    except MissingTool as missing:
        notes.append(f"Tesseract is left out: {str(missing).strip().splitlines()[-1]}")
    python = venv / "bin/python"
    versions = _versions(python, tesseract) | ({"FCL": fcl_version} if fcl_version else {})
    return Environment(python, coal, fcl, clearance(), tesseract, versions, notes)


@contextmanager
def _venv(name: str, requirements: Path) -> Iterator[Path]:
    """A Python environment, made if it is missing; nobody else adds to it meanwhile."""
    venv = _cache() / f"{name}-{_hash([requirements], sys.version)}"
    venv.parent.mkdir(parents=True, exist_ok=True)
    with open(venv.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two runs at once wait for each other
        _make_venv(venv, requirements)
        yield venv


def _cache() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(os.environ.get("CLEARANCE_CACHE") or Path(base) / "clearance")


def _hash(files: list[Path], *texts: str) -> str:
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.read_bytes())
    for text in texts:
        digest.update(text.encode())
    return digest.hexdigest()[:16]


def _run(command: Sequence[str | Path], problem: str) -> str:
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, env=_clean(), check=False)
    if done.returncode != 0:
        raise MissingTool(f"{problem}:\n{done.stdout[-2000:]}{done.stderr[-4000:]}")
    return done.stdout


def _clean() -> dict[str, str]:
    """A sourced ROS or another environment must not mix with the wheels."""
    mixing = ("PYTHONPATH", "PYTHONHOME", "LD_LIBRARY_PATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH")
    return {name: value for name, value in os.environ.items() if name not in mixing}


def _make_venv(venv: Path, requirements: Path) -> None:
    complete = venv / ".complete"  # written last: a folder without it is what an interrupted run left
    if complete.exists():
        return
    print(f"making a Python environment in {venv}", file=sys.stderr)
    shutil.rmtree(venv, ignore_errors=True)
    _run([sys.executable, "-m", "venv", venv], "no virtual environment (Debian: apt-get install python3-venv)")
    pip: list[str | Path] = [venv / "bin/pip", "install", "-q", "--disable-pip-version-check"]
    pip += ["-r", requirements]
    _run(pip, f"the peers cannot be installed for Python {sys.version.split()[0]}")
    complete.touch()


def _build_coal(venv: Path) -> Path:
    folder = PEERS / "contestants"
    source = folder / "coal.cpp"
    program = venv / f"coal-{_hash([source, *sorted(folder.glob('*.hpp'))])}"
    if program.exists():
        return program
    print("building the C++ contestant", file=sys.stderr)
    prefix = next(venv.glob("lib/python*/site-packages/cmeel.prefix"))
    # no -march: it would change the alignment of Eigen's types, which the wheel has fixed
    command: list[str | Path] = ["g++", "-std=c++17", "-O3", "-DNDEBUG", *(f"-D{d}" for d in COAL_DEFINITIONS)]
    command += ["-isystem", prefix / "include", "-isystem", prefix / "include/eigen3", source]
    command += ["-L", prefix / "lib", "-lcoal", f"-Wl,-rpath,{prefix / 'lib'}", "-o", program]
    _run(command, "the C++ contestant does not build")
    return program


def _build_fcl(version: str) -> Path:
    """Against the distribution's library: its wheel has no headers."""
    folder = PEERS / "contestants"
    sources = [folder / name for name in ("fcl.cpp", "neutral.hpp", "protocol.hpp")]
    program = _cache() / f"fcl-{_hash(sources, version)}"
    if not program.exists():
        print("building the contestant of FCL", file=sys.stderr)
        command = ["g++", "-std=c++17", "-O3", "-DNDEBUG", "-isystem", "/usr/include/eigen3", sources[0]]
        command += ["-lfcl", "-loctomap", "-loctomath", "-lccd", "-o", program]
        _run(command, "the contestant of FCL does not build")
    return program


def _fcl_version() -> str | None:
    if shutil.which("pkg-config") is None:
        return None
    reported = subprocess.run(["pkg-config", "--modversion", "fcl"], capture_output=True, text=True, check=False)
    return reported.stdout.strip() if reported.returncode == 0 else None


def clearance() -> Path:
    """Builds this library's contestant."""
    print("building clearance (cargo bench --no-run)", file=sys.stderr)
    command = ["cargo", "bench", "--no-run", "--bench", "peer", "--no-default-features"]
    out = _run([*command, "--message-format=json-render-diagnostics"], "clearance does not build")
    for line in out.splitlines():
        message = json.loads(line) if line.startswith("{") else {}
        if message.get("executable") and message.get("target", {}).get("name") == "peer":
            return Path(message["executable"])
    raise MissingTool("cargo built no program 'peer'")


def _versions(python: Path, tesseract: Path | None) -> dict[str, str]:
    found = _wheels(python, ("pin", "coal", "python-fcl", "numpy", "cmeel-eigen"))
    if tesseract:
        found |= _wheels(tesseract, ("tesseract-robotics",))
    found["Python"] = sys.version.split()[0]
    found["rustc"] = _run(["rustc", "--version"], "no rustc").split()[1]
    found["g++"] = _run(["g++", "-dumpfullversion"], "no g++").strip()
    found["clearance"] = commit()
    return found


def commit() -> str:
    """The commit that is measured, with a remark if files were changed since."""
    name = _run(["git", "rev-parse", "--short", "HEAD"], "no commit").strip()
    changed = _run(["git", "status", "--porcelain", "--untracked-files=no"], "no status").strip()
    return name + (" with changes" if changed else "")


def _wheels(python: Path, wanted: tuple[str, ...]) -> dict[str, str]:
    wheels = json.loads(_run([python, "-m", "pip", "list", "--format=json"], "pip does not list"))
    return {wheel["name"]: wheel["version"] for wheel in wheels if wheel["name"] in wanted}
