"""The entries of a bank's manifest: clips, hands and the baseline."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ClipEntry:
    """One clip of a bank: its rows in the tables, and the quality of its alignment.

    Attributes:
        name: Name of the clip.
        kind: `locomotion` or `action`.
        tags: Words of the user's choice.
        rate: Frames per second.
        first_row: Its first row in the tables.
        frame_count: Number of its own frames, which come first.
        row_count: Number of all its rows: its own frames, then the frames of its seam, which lead back to an earlier
            stride.
        first_cell: Its first cell in `frame_of_phase`.
        cell_count: Number of its cells.
        first_phase: Phase of its first row, cycles of the baseline.
        last_phase: Phase of its last row, cycles of the baseline.
        cycles: Cycles that its own frames take.
        loop: Whole strides by which the seam leads back; 0 if the clip cannot loop.
        gait: Whether its legs move like the baseline's. Without a gait, its phase means little.
        mean_mismatch: Mean distance of the alignment, metres.
        worst_mismatch: Largest distance of the alignment, metres.
        shoulder_motion: How far its torso moves beyond the gait of its neutral, radians.
        repetition: Mean distance of its upper body from itself a stride later, metres; 0 if it has less than a stride
            and a half, or no gait.
        stance: Row of its stance in the table `stances`; -1 if it is no standing action.
        parts: Bits of the parts that a standing action drives (`motion.parts`).
        uses: Names of the parts that a standing action uses.
        stretches: Names of the clips that a hybrid action plays one after another; empty for any other clip.
        enters: Real-valued frame at which a stretch of a hybrid takes over; 0 for any other clip.
        leaves: Real-valued frame at which it hands over to the next; 0 for any other clip.
        warnings: Problems found by the offline job.
        notes: Remarks of the offline job.
        source: Digest of the file.
    """

    name: str
    kind: str
    tags: tuple[str, ...]
    rate: float
    first_row: int
    frame_count: int
    row_count: int
    first_cell: int
    cell_count: int
    first_phase: float
    last_phase: float
    cycles: float
    loop: int
    gait: bool
    mean_mismatch: float
    worst_mismatch: float
    shoulder_motion: float
    repetition: float
    stance: int
    parts: int
    uses: tuple[str, ...]
    stretches: tuple[str, ...]
    enters: float
    leaves: float
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    source: str

    @property
    def stands(self) -> bool:
        """Whether it is a standing action: without a gait, laid on a locomotion as what it adds to its stance."""
        return self.stance >= 0

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.frame_count - 1) / self.rate


@dataclass(frozen=True)
class BaselineEntry:
    """The stride that a bank is aligned to.

    Attributes:
        clip: Name of the clip.
        start: Seconds into the clip at which the stride starts.
        end: Seconds into the clip at which it ends.
        loop: Distance between the poses at the stride's ends, divided by the distance between poses half a stride
            apart.
        cells: Number of cells of its ring.
    """

    clip: str
    start: float
    end: float
    loop: float
    cells: int


@dataclass(frozen=True)
class HandsEntry:
    """A hands clip aligned to a clip of the bank.

    Attributes:
        name: Name of the hands clip.
        body: Name of the clip that it is aligned to.
        first_row: Its first row in the tables of hands; it has as many rows as the body.
        rate: Frames per second of the hands clip.
        hand: `left`, `right`, `both` (both hands by one alignment) or `each` (each hand by its own).
        wrist: Whether wrists and the twist of forearms come from the hands clip too, not fingers alone.
        pairs: Frame pairs that the user gave, as text.
        mismatch: Mean phase cost along the path divided by the mean over the band: 0 for identical gestures, about 1
            for unrelated ones.
        warnings: Problems found by the offline job.
        source: Digest of the file.
    """

    name: str
    body: str
    first_row: int
    rate: float
    hand: str
    wrist: bool
    pairs: tuple[str, ...]
    mismatch: float
    warnings: tuple[str, ...]
    source: str
