#!/usr/bin/env bash
# Makes a Python environment with what the tests of the Python package import, and prints its path. It does not contain the package.
# Nothing is installed outside the cache folder:
#   ${CLEARANCE_CACHE:-${XDG_CACHE_HOME:-~/.cache}/clearance}/python-<hash of all that it is made from>
# Needs CPython 3.9 or newer with venv, and the network once.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
unset PYTHONPATH PYTHONHOME

say() { echo "environment of the Python package: $*" >&2; }

python=${PYTHON:-python3}
"$python" -c 'import sys, venv; sys.exit(sys.version_info < (3, 9))' \
    || { say "needs CPython 3.9 or newer with venv (Debian: apt-get install python3-venv)"; exit 1; }
hash=$({ "$python" --version; cat "$here/environment.sh"; } | sha256sum | cut -c1-16)
venv="${CLEARANCE_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/clearance}/python-$hash"
mkdir -p "$(dirname "$venv")"

# Two test runs at once wait for each other; the lock ends with this process.
exec 9>"$venv.lock"
flock 9

# The stamp is written last: a folder without it is what an interrupted build left behind.
if [ ! -e "$venv/.complete" ]; then
    say "building $venv"
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check numpy pytest pytest-timeout xacro
    # 5 MB; not for every Python
    "$venv/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: ompl==2.0.1 \
        || say "no wheel of ompl for this Python: the tests of clearance.ompl will be skipped"
    # 70 MB; not for every Python
    "$venv/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: 'ray>=2.40,<3' \
        || say "no wheel of ray for this Python: the test of examples/roadmap_ray.py will be skipped"
    touch "$venv/.complete"
fi
echo "$venv"
