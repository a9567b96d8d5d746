"""Tables of the worlds: by factor, the worst, and one configuration against another.

Tracked is a pose in whichever sub-map; where a bag was opened out of sight of all that was mapped, no more can be had.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from slam_report import Report

FAILED = (0.8, 5.0)  # share of the frames tracked, percent of the path
UNKNOWN = 100.0  # percent, where there is no trajectory to compare

Facts = dict[str, Any]


def by_factor(rows: Sequence[Facts], report: Report) -> None:
    """A line for all worlds, and one for every value of every factor."""
    headings = [
        *(
            "Worlds",
            "Tracked, least and median",
            "In one map, least and median",
            "ATE m, median",
            "ATE % of path, median and worst",
            "Spread over starts",
        ),
        *("Lost", "Wrong", "Failed", "CPU ms"),
    ]
    table = [["all", "", *_cells(rows)]]
    for name in rows[0]["factors"]:
        table += [[name, value, *_cells(group)] for value, group in _groups(rows, name)]
    print()
    report.table(["By", "", *headings], table)


def _groups(rows: Sequence[Facts], name: str) -> Iterator[tuple[str, list[Facts]]]:
    for value in sorted({row["factors"][name] for row in rows}):
        yield value, [row for row in rows if row["factors"][name] == value]


def _cells(rows: Sequence[Facts]) -> list[str]:
    runs = [run for row in rows for run in row["runs"]]
    shares, tracked = [share_of(row) for row in rows], [run["tracked"] for run in runs]
    joined = [run["joined"] for run in runs]
    metres = [run["ate_m"] for run in runs if run["ate_m"] is not None]
    spreads = [spread for row in rows if (spread := _spread(row)) is not None]
    return [
        str(len(rows)),
        f"{min(tracked):.0%}, {np.median(tracked):.1%}",
        f"{min(joined):.0%}, {np.median(joined):.1%}",
        f"{np.median(metres):.3f}" if metres else "none",
        f"{np.median(shares):.2f}, {max(shares):.2f}",
        f"{np.median(spreads):.2f}x" if spreads else "-",
        str(sum(run["lost"] for run in runs)),
        str(sum(run["wrong"] for run in runs)),
        f"{sum(map(has_failed, rows))} of {len(rows)}",
        f"{np.median([run['all_ms'] for run in runs]):.0f}",
    ]


def share_of(row: Facts) -> float:
    """Percent of the path, the median of a world's starts."""
    return float(np.median([UNKNOWN if run["ate_percent"] is None else run["ate_percent"] for run in row["runs"]]))


def has_failed(row: Facts) -> bool:
    """Whether any start did."""
    return any(
        run["tracked"] < FAILED[0] or run["ate_percent"] is None or run["ate_percent"] > FAILED[1] or run["wrong"] > 0
        for run in row["runs"]
    )


def _spread(row: Facts) -> float | None:
    """By how much the worst start is worse than the best one."""
    known = [run["ate_m"] for run in row["runs"] if run["ate_m"]]
    return max(known) / min(known) if len(known) > 1 else None


def worst(rows: Sequence[Facts], report: Report, count: int = 12) -> None:
    """The worlds with the most to mend."""
    ranked = sorted(rows, key=lambda row: (has_failed(row), share_of(row)), reverse=True)
    print(f"\n{sum(map(has_failed, rows))} of {len(rows)} worlds failed; the worst:")
    table = []
    for row in ranked[:count]:
        run = max(row["runs"], key=lambda each: (each["wrong"], -each["tracked"]))
        ate = "none" if run["ate_m"] is None else f"{run['ate_m']:.3f}"
        factors = " ".join(row["factors"].values())
        table.append([
            row["world"], f"{run['tracked']:.1%}", f"{run['joined']:.0%}", ate, f"{share_of(row):.2f}",
            str(run["lost"]), str(run["submaps"]), str(run["wrong"]), factors,
        ])  # fmt: skip
    report.table(
        ["World", "Tracked", "In one map", "ATE m", "% of path", "Lost", "Sub-maps", "Wrong", "Factors"], table
    )


def text_by_factor(rows: Sequence[Facts], report: Report) -> None:
    """Recall and precision of signs, over all worlds and by place, light, depth and motion."""
    scored = [row for row in rows if "expected" in row.get("text", {})]
    if not scored:
        return
    table = [["all", "", *_text_cells(scored)]]
    for name in ("place", "light", "depth", "motion", "size", "exposure"):
        table += [[name, value, *_text_cells(group)] for value, group in _groups(scored, name)]
    print()
    report.table(["Text by", "", "Worlds", "Recall", "Precision"], table)


def _text_cells(rows: Sequence[Facts]) -> list[str]:
    total = {key: sum(row["text"][key] for row in rows) for key in ("expected", "found", "landmarks", "right")}
    recall = f"{total['found'] / total['expected']:.1%} of {total['expected']}" if total["expected"] else "none"
    right = f"{total['right'] / total['landmarks']:.1%} of {total['landmarks']}" if total["landmarks"] else "none"
    return [str(len(rows)), recall, right]


def in_ratios(first: Sequence[Facts], second: Sequence[Facts], report: Report) -> None:
    """The second configuration against the first, world by world: below 1 is better."""
    pairs = list(zip(first, second, strict=True))
    table = [["all", "", *_ratio_cells(pairs)]]
    for name in first[0]["factors"]:
        table += [
            [name, value, *_ratio_cells([pair for pair in pairs if pair[0]["factors"][name] == value])]
            for value in sorted({row["factors"][name] for row in first})
        ]
    print("\nsecond configuration / first, over pairs:")
    report.table(["By", "", "Worlds", "ATE, median", "ATE, geometric mean", "Worst", "Better", "Tracked", "CPU"], table)


def _ratio_cells(pairs: Sequence[tuple[Facts, Facts]]) -> list[str]:
    ratios = np.array([max(share_of(b), 1e-6) / max(share_of(a), 1e-6) for a, b in pairs])
    tracked = [
        np.mean([r["tracked"] for r in b["runs"]]) - np.mean([r["tracked"] for r in a["runs"]]) for a, b in pairs
    ]
    cost = [np.mean([r["all_ms"] for r in b["runs"]]) / np.mean([r["all_ms"] for r in a["runs"]]) for a, b in pairs]
    return [
        str(len(pairs)),
        f"{np.median(ratios):.3f}",
        f"{np.exp(np.log(ratios).mean()):.3f}",
        f"{ratios.max():.2f}",
        f"{int((ratios < 1).sum())} of {len(ratios)}",
        f"{100 * float(np.mean(tracked)):+.1f} %",
        f"{np.median(cost):.2f}",
    ]
