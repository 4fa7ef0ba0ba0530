"""Report section on edges: times, certificates, and agreement of results."""

from __future__ import annotations

from .edge_comparison import MOST_CAST_PAIRS, MOST_FCL_PAIRS
from .edge_measures import EDGE_MEASURES, EdgeMeasure, EdgeMeasured
from .edge_sets import JUDGED_EVERY
from .markdown import microseconds, table
from .results import RobotResult, Results


def edges(results: Results) -> list[str]:
    if not any(robot.edges for robot in results.robots):
        return []
    return [
        "## Edges",
        "",
        "Straight motions in joint space, self-collision only; lengths are Euclidean norms over all joints.",
        f"Coal sampled every {JUDGED_EVERY} rad tells the free ones from those that collide. `clearance` proves the"
        " whole edge, with a tolerance of 0.5 mm; samples prove nothing.",
        "µs an edge: best round / median round (ratio of medians to `clearance`). FCL's advancement is asked about robots"
        f" of at most {MOST_FCL_PAIRS} pairs, Tesseract's cast of at most {MOST_CAST_PAIRS}.",
        "",
        *results.edge_notes,
        *([""] if results.edge_notes else []),
        *(line for key, measure in EDGE_MEASURES.items() for line in _times(results, key, measure)),
        *_certificates(results),
        *_responses(results),
    ]


def _times(results: Results, key: str, measure: EdgeMeasure) -> list[str]:
    voices = [peer.name for peer in measure.peers]
    rows = [
        [robot.name, f"{length:g}", str(measured.count), *(_cell(measured, v) for v in ("clearance", *voices))]
        for robot in results.robots
        for length in measure.lengths
        if (measured := robot.edges.get((key, length)))
    ]
    head = ["robot", "length (rad)", "edges", "`clearance`", *(f"`{voice}`" for voice in voices)]
    return [f"### {measure.title}", "", *table(head, rows)] if rows else []


def _cell(measured: EdgeMeasured, voice: str) -> str:
    if voice not in measured.timings:
        return "–"
    timing, ratio = measured.timings[voice], measured.ratio(voice)
    times = f"{microseconds(timing.best)} / {microseconds(timing.median)}"
    return times if voice == "clearance" or ratio is None else f"{times} ({ratio:.2f}x)"


def _certificates(results: Results) -> list[str]:
    parts = ["### Certificates", "", "Making one is checking the edge and writing down the proof.", ""]
    rows = [_certificate(robot) for robot in results.robots if robot.certificates]
    if not rows:
        return [*parts, "Not measured yet.", ""]
    head = ["robot", "edges", "intervals an edge", "making (µs)", "verifying (µs)", "multiple"]
    return [*parts, *table(head, rows)]


def _certificate(robot: RobotResult) -> list[str]:
    words = robot.certificates
    count, intervals = int(words["edges"]), float(words["intervals"])
    making, verifying = (float(words[key]) * 1e6 / count for key in ("making_s", "verifying_s"))
    multiple = f"{verifying / making:.1f}x"
    return [robot.name, str(count), f"{intervals / count:.0f}", microseconds(making), microseconds(verifying), multiple]


def _responses(results: Results) -> list[str]:
    """Every disagreement is told; what samples miss and what hulls invent is counted."""
    rows: dict[str, list[int]] = {}
    reported: list[str] = []
    undecided: dict[tuple[str, str, float], tuple[int, int]] = {}
    for robot in results.robots:
        for (key, length), measured in robot.edges.items():
            measure = EDGE_MEASURES[key]
            # the same edges may be asked about in several measures, few of them in some
            before = undecided.get((robot.name, measure.kind, length), (0, 0))
            undecided[robot.name, measure.kind, length] = max(before, (measured.undecided, measured.count))
            for agreement in measured.agreements:
                counts = rows.setdefault(agreement.voice, [0, 0, 0, 0])
                found = (agreement.compared, agreement.disagreements, agreement.missed, agreement.false_alarms)
                rows[agreement.voice] = [a + b for a, b in zip(counts, found)]
                if agreement.disagreements:
                    asked = f"{measure.kind} edges of {length:g} rad, {agreement.example}"
                    reported.append(f"- **{robot.name}, {asked}: free here, a hit of `{agreement.voice}`.**")
    count, asked_about = (sum(numbers) for numbers in zip(*undecided.values()))
    return [
        "### Answers about edges",
        "",
        "- disagreements: free here, yet a sample hits, which must not be;",
        "- missed: contact here, none there;",
        "- false alarms: free here, a hit there that is no sample's;",
        f"- undecided here, nearer to contact than the tolerance: {count} of {asked_about}.",
        "",
        *table(
            ["contestant", "answers", "disagreements", "missed", "false alarms"],
            [[f"`{voice}`", *map(str, counts)] for voice, counts in rows.items()],
        ),
        *reported,
        *([""] if reported else []),
    ]
