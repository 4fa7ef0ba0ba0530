"""The command ``python -m clearance``."""

import sys

from ._command import main

sys.exit(main())
