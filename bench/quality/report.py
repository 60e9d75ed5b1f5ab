"""The quality report: one HTML page with embedded pictures."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader

from bench.quality import charts
from bench.quality.claims import CLAIMS
from bench.quality.pair_list import Pair
from bench.quality.scores import ClipScore, PairScore, Spliced
from bench.quality.targets import OURS, Target
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.pictures.sheets import contact_sheet
from motionsplice.runtime.bank import Bank

PAIR_NOTE = (
    "ratio: mean error divided by that of the naive splice. oracle, cm: the error of a splice that knows the truth and "
    "picks the best frames of the action. floor: how much the truth differs from itself a stride later, spliced in the "
    "same way. best lag, best time, best torso, oracle: the ratio that the bank's splice would have with the best "
    "constant lag, the best time that never goes back, the best turn of the torso at each frame, or the best frames of "
    "the action. lag, degrees: how far the timing of the arms is from the truth's (or the locomotion's, if unknown). "
    "jitter, excursion: motion of the neck over the root, divided by that of the larger source. hands: how fast hands "
    "move as seen from the chest, divided by how fast they do in the action's clip (99th percentiles). speed: speed of "
    "the action's time relative to its own. legs: distance between the legs at aligned frames. posture: angle from the "
    "posture that the form promises. within halves: largest angle of a joint in either half from its source."
)
CLIP_NOTE = (
    "knee passes: moments at which the left knee passes the right one going forward. strides between: strides between "
    "the first and the last of these. concentration: how similar the phases at the knee passes are (1: all equal). "
    "shoulders: motion that an action's shoulders add to its gait, and that all postures but relative lose."
)


@dataclass(frozen=True)
class Cell:
    """The text of a table's cell, and its grade: good, fair, bad or empty."""

    text: str
    grade: str = ""


@dataclass(frozen=True)
class Picture:
    """The two pictures of a pair, as base64 of PNG, and whether they are open when the page loads."""

    title: str
    strip: str
    chart: str
    open: bool


@dataclass(frozen=True)
class ClaimRow:
    """The number of a claim about one example: for each method, for the truth and for the action alone."""

    example: str
    pair: str
    label: str
    values: tuple[str, ...]


def pair_table(scores: Sequence[PairScore]) -> tuple[list[str], list[list[Cell]]]:
    """Returns the columns and rows of the table of pairs."""
    methods = [one.method for one in scores[0].methods]
    columns = ["locomotion <- action", *(f"{name}\ncm mean / p95" for name in methods)]
    columns += [*(f"{name}\nratio" for name in methods[1:]), "expected\nratio", "oracle\ncm", "floor\ncm"]
    columns += [f"{name}\nratio" for name in ("best lag", "best time", "best torso", "oracle")]
    columns += [*(f"{name}\n{what}" for what in ("posture °",) for name in methods[1:])]
    columns += [*(f"{name}\n{what}" for what in ("lag °", "jitter", "excursion") for name in (methods[0], OURS))]
    columns += [f"{OURS}\nhands", f"{OURS}\nspeed", f"{OURS}\nlegs cm", f"{OURS}\nwithin halves °"]
    rows = []
    for one in scores:
        ours, naive = one.of(OURS), one.methods[0]
        row = [Cell(one.name)]
        row += [Cell("" if m.error is None else f"{m.error:.1f} / {m.worst_error:.1f}") for m in one.methods]
        row += [_graded(m.ratio, 0.45, 0.7) for m in one.methods[1:]]
        row += [_graded(one.expected, 0.45, 0.8), _graded(one.oracle), _graded(one.floor)]
        row += [_graded(one.lacking.get(name)) for name in ("lag", "time", "torso", "oracle")]
        row += [_graded(m.posture, 1.5, 3.0) for m in one.methods[1:]]
        row += [
            _graded(naive.lag),
            _graded(ours.lag, 15.0, 30.0),
            _graded(naive.jitter),
            _graded(ours.jitter, 1.1, 1.5),
        ]
        row += [_graded(naive.excursion), _graded(ours.excursion, 1.2, 1.6)]
        low, high = ours.slopes or (0.0, 0.0)
        row += [_graded(ours.hands, 1.3, 2.0)]
        row += [Cell(f"{low:.2f} to {high:.2f}", "" if ours.monotone else "bad"), _graded(ours.mismatch)]
        rows.append([*row, Cell("" if ours.change is None else f"{ours.change:.1e}")])
    return columns, rows


def means_table(scores: Mapping[str, Sequence[PairScore]]) -> tuple[list[str], list[list[Cell]]]:
    """Returns columns and rows: mean and worst ratio to the naive splice of pairs with a truth, by group and over all.

    There is a row for each method and, below, for what the bank's splice lacks.
    """
    groups = {name: found for name, some in scores.items() if (found := [one for one in some if one.truth])}
    groups["all"] = [one for some in groups.values() for one in some]
    rows = []
    for method in (one.method for one in groups["all"][0].methods[1:]):
        ratios = [[one.of(method).ratio or 0.0 for one in some] for some in groups.values()]
        rows.append([Cell(method), *(_mean_and_worst(found) for found in ratios)])
    for name in groups["all"][0].lacking:
        ratios = [[one.lacking[name] for one in some if one.lacking] for some in groups.values()]
        rows.append(
            [Cell("oracle" if name == "oracle" else f"best {name}"), *(_mean_and_worst(found) for found in ratios)]
        )
    return ["mean / worst", *(f"{name} ({len(some)})" for name, some in groups.items())], rows


def by_part(scores: Sequence[PairScore], part: str) -> dict[str, list[PairScore]]:
    """Returns scores by the pair's `locomotion` or `action`."""
    names = dict.fromkeys(getattr(one, part) for one in scores)
    return {name: [one for one in scores if getattr(one, part) == name] for name in names}


def clip_table(scores: Sequence[ClipScore]) -> tuple[list[str], list[list[Cell]]]:
    """Returns the columns and rows of the table of clips."""
    columns = ["clip", "kind", "strides", "knee passes", "strides between", "concentration", "shoulders °"]
    rows = []
    for one in scores:
        value = one.concentration
        grade = "" if value is None else "good" if value >= 0.95 else "fair" if value >= 0.9 else "bad"
        numbers = (f"{one.strides:.1f}", str(one.passes), f"{one.strides_between:.2f}")
        row = [Cell(one.clip), Cell(one.kind), *map(Cell, numbers)]
        rows.append([*row, Cell("" if value is None else f"{value:.3f}", grade), _graded(one.shoulder_motion)])
    return columns, rows


def claim_row(pair: Pair, values: Mapping[str, float]) -> ClaimRow:
    """Formats the numbers of a pair's claim for the report."""
    claim = CLAIMS[pair.claim]
    texts = tuple(f"{value:.1f}" if abs(value) >= 10.0 else f"{value:.2f}" for value in values.values())
    label = f"{claim.label}, {claim.unit}" if claim.unit else claim.label
    return ClaimRow(pair.example, f"{pair.locomotion} <- {pair.action}", label, texts)


def picture(
    bank: Bank, score: PairScore, example: str, truth: Clip | None, splices: Sequence[Spliced], *, expanded: bool
) -> Picture:
    """Draws a pair's stick figures (papers, Figures 4 and 4.7) and its charts."""
    rows = [(one.form.label, one.clip, bank.roles) for one in splices if one.form.how != "exact"]
    if truth is not None:
        rows.append(("truth", truth, bank.roles))
    end = min(4.0, min(clip.duration for _, clip, _ in rows))
    file = io.BytesIO()
    contact_sheet(rows, columns=12, end=end, ghost=truth).save(file, format="png")
    chart = charts.pair_chart(bank, score.locomotion, score.action, truth, splices)
    title = f"{example}: {score.name}" if example else score.name
    return Picture(title, _base64(file.getvalue()), _base64(chart), expanded)


def write_report(
    file: Path,
    *,
    title: str,
    subtitle: str,
    pairs: Sequence[PairScore],
    clips: Sequence[ClipScore],
    judged: Sequence[Target],
    errors: Mapping[str, Mapping[str, Floats]],
    rate: float,
    claims: Sequence[ClaimRow],
    claim_columns: Sequence[str],
    pictures: Sequence[Picture],
    grid: bool,
    means: Sequence[tuple[str, list[str], list[list[Cell]]]],
) -> None:
    """Writes the report to `file`. `errors`: by pair and method, errors [F] in cm at `rate` frames per second."""
    page = Environment(loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True)
    pair_columns, pair_rows = pair_table(pairs)
    clip_columns, clip_rows = clip_table(clips)
    text = page.get_template("report.html.j2").render(
        title=title,
        subtitle=subtitle,
        targets=judged,
        overview=_base64(charts.overview(errors, rate)) if errors else "",
        grid=_base64(charts.ratio_grid(pairs, OURS)) if grid else "",
        means=means,
        pair_columns=pair_columns,
        pair_rows=pair_rows,
        pair_note=PAIR_NOTE,
        claims=claims,
        claim_columns=claim_columns,
        clip_columns=clip_columns,
        clip_rows=clip_rows,
        clip_note=CLIP_NOTE,
        pictures=pictures,
    )
    file.write_text(text, encoding="utf-8")


def _mean_and_worst(ratios: Sequence[float]) -> Cell:
    """Returns a cell graded by the mean."""
    mean = sum(ratios) / len(ratios)
    return Cell(f"{mean:.2f} / {max(ratios):.2f}", _graded(mean, 0.45, 0.7).grade)


def _graded(value: float | None, good: float | None = None, fair: float | None = None) -> Cell:
    """Returns a cell graded good up to `good`, fair up to `fair`, and bad above."""
    if value is None:
        return Cell("")
    if good is None or fair is None:
        return Cell(f"{value:.2f}")
    return Cell(f"{value:.2f}", "good" if value <= good else "fair" if value <= fair else "bad")


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
