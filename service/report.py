"""The findings of `bench.quality` for a bank, as the page /view/report shows them."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, Field, ValidationError

from motionsplice.runtime.format.manifest import Mark, mark_of
from motionsplice.service.problems import ReportError

MAKE = "Write it with `python -m bench.quality --bank BANK --out FOLDER`"
MOST_WRONG = 3  # faults of a file that an error names


class MethodReport(BaseModel):
    """The scores of one splice of a pair. Null where a number has no meaning."""

    method: str = Field(description="`naive`: plain replacement, `additive`, `exact`: the papers', `splice`: ours")
    seconds: float
    error: float | None = Field(description="mean error of the upper body's joints, cm")
    worst_error: float | None = Field(description="95th percentile of the error, cm")
    ratio: float | None = Field(description="error divided by the naive splice's")
    posture: float | None = Field(description="angle from the posture that the form promises, degrees")
    lag: float | None = Field(description="timing of the arms against the truth's, degrees of a stride")
    jitter: float | None = Field(description="jerk of the neck divided by the larger source's")
    excursion: float | None = Field(description="largest distance of the neck divided by the larger source's")
    monotone: bool | None = Field(description="whether the action's time always increases")
    slopes: tuple[float, float] | None = Field(description="smallest and largest speed of the action's time")
    hands: float | None = Field(description="hands' speed seen from the chest / the action's, 99th percentiles")
    mismatch: float | None = Field(description="distance of the legs at aligned frames, cm")
    change: float | None = Field(description="largest change within either half, degrees")


class LackingReport(BaseModel):
    """The error that the bank's splice would have if one thing were known from the truth, divided by `naive`'s."""

    lag: float = Field(description="with the best constant lag of the action's time")
    lag_seconds: float = Field(description="that lag, seconds; positive plays later frames")
    time: float = Field(description="with the best time that never goes back")
    torso: float = Field(description="with the best turn of the torso at each frame")
    oracle: float = Field(description="with the best frames of the action, without regard to time")


class WorstMoment(BaseModel):
    """The moment at which the bank's splice is worst."""

    time: float = Field(description="seconds into the locomotion")
    value: float = Field(description="cm")


class PairReport(BaseModel):
    """One pair: its scores, and where in time they are worst."""

    locomotion: str
    action: str
    truth: str = Field(description="a clip that shows what the splice should be; it may not be in the bank")
    example: str = Field(description="title of the pair")
    oracle: float | None = Field(description="error of a splice that knows the truth, cm")
    floor: float | None = Field(description="difference of the truth from itself a stride later, cm")
    expected: float | None = Field(description="error / naive's, estimated without the truth")
    lacking: LackingReport | None = Field(description="what the bank's splice lacks; null without a truth")
    group: str = Field(description="of pairs that were averaged together")
    methods: list[MethodReport]
    measure: Literal["error", "legs"] = Field(
        description="what is measured over time: the error, or without a truth the legs"
    )
    over_time: dict[str, list[float]] = Field(description="by method: cm at each moment, `rate` of them per second")
    worst: WorstMoment


class TargetReport(BaseModel):
    """A number, the bound that it should keep, and whether it does."""

    what: str
    found: str
    wanted: str
    met: bool


class QualityReport(BaseModel):
    """How close splices of a bank are to the true motion."""

    bank: str = Field(description="digest of the bank that was judged")
    version: str = Field(description="version of motionsplice")
    rate: float = Field(description="moments per second of `over_time`")
    targets: list[TargetReport]
    pairs: list[PairReport]


class ReportFile:
    """A report on disk. It is read again only when it changes."""

    def __init__(self, file: Path | None) -> None:
        self._file = file
        self._known: tuple[Mark | None, bytes] = (None, b"")

    @property
    def exists(self) -> bool:
        """Whether there is such a file, readable or not."""
        return self._file is not None and self._file.is_file()

    def read(self) -> bytes:
        """Returns the report as JSON. Raises ReportError if there is none, or if it is not valid."""
        if self._file is None:
            raise ReportError(
                "this service has no report", mend=f"{MAKE}, and start the service with --report FOLDER/scores.json"
            )
        mark = mark_of(self._file)
        if mark is None or mark != self._known[0]:
            try:
                report = QualityReport.model_validate_json(self._file.read_bytes())
            except OSError as error:
                raise ReportError(
                    f"the report cannot be read: {error.strerror}", file=self._file.name, mend=MAKE
                ) from None
            except ValidationError as error:
                problem = f"not a report of bench.quality: {_faults(error)}"
                raise ReportError(problem, file=self._file.name, mend=MAKE) from None
            self._known = mark, report.model_dump_json().encode()
        return self._known[1]


def _faults(error: ValidationError) -> str:
    """Returns what is wrong with a file, and where."""
    faults = error.errors()[:MOST_WRONG]
    return "; ".join(": ".join(filter(None, (".".join(map(str, one["loc"])), one["msg"]))) for one in faults)
