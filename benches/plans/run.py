#!/usr/bin/env python3
"""How many paths collide that planners with sampled edges found:  run.py --shared FOLDER [--seeds 3] [--problems 4] [--output FILE]

Every path goes to check_trajectory. A contact counts only if Coal finds a colliding state in the colliding part of the path. Coal also
checks states of paths that are reported free. FOLDER has robots/ and scenes/. Needs clearance and requirements.txt.
"""

import argparse
from pathlib import Path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, required=True, help="folder with robots/ and scenes/")
    parser.add_argument("--seeds", type=int, default=3, help="searches of each planner on each problem")
    parser.add_argument("--problems", type=int, default=4, help="problems of each scene")
    parser.add_argument("--seconds", type=float, default=5.0, help="limit of a search")
    parser.add_argument("--output", type=Path, help="file for the tables")
    arguments = parser.parse_args()
    # what it needs is imported after --help
    from measure import Measurement

    about, table = Measurement(arguments).run()
    print(f"{about}\n\n{table}")
    if arguments.output:
        arguments.output.write_text(table + "\n")


if __name__ == "__main__":
    main()
