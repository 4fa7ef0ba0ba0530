"""Data type of one measurement of the node benchmarks, and the Markdown page with the table of all."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    measure: str
    required: str
    found: str
    reached: bool | None  # None: not measured
    note: str = ""
    works: bool = True  # whether what is measured was there, however fast

    @property
    def word(self):
        return {True: "yes", False: "**no**", None: "not measured"}[self.reached]


def markdown(rows, facts):
    lines = ["# The node, measured", ""]
    lines += ["For operators who need latencies, losses, memory and restart times of the node.", ""]
    lines += ["Written by `benches/node/run.sh`, whose README (`benches/node/README.md`) says what is measured and how.", ""]
    lines += [f"- {name}: {fact}" for name, fact in facts.items()] + [""]
    lines += ["| measure | at least | found | reached |", "|---|---|---|---|"]
    lines += [f"| {row.measure} | {row.required} | {row.found} | {row.word} |" for row in rows]
    notes = [f"- {row.measure}: {row.note}" for row in rows if row.note]
    return "\n".join(lines + ([""] + notes if notes else [])) + "\n"
