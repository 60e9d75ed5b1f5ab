"""Pictures of motions for comparison: contact sheets, and animations of motions side by side."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError, did_you_mean
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, Side
from motionsplice.pictures.brush import WHITE, Brush, Colour, canvas, mixed, reduced
from motionsplice.pictures.camera import VIEWS, Camera, Take
from motionsplice.pictures.hand_figure import HandFigure
from motionsplice.pictures.stick_figure import GHOST, LEFT, RIGHT, TORSO, TRUNK, StickFigure

Row = tuple[str, Clip, Roles]
Font = ImageFont.FreeTypeFont | ImageFont.ImageFont

TEXT: Colour = (38, 42, 48)
QUIET: Colour = (118, 125, 134)
FLOOR: Colour = (222, 225, 229)
HELD = 0.6  # how pale a figure is that is held at its last frame

SHEET_WIDTH, LABEL_WIDTH, MARGIN, FOOTER, PADDING = 1200, 130, 24, 54, 10
MIN_LABEL_WIDTH, MIN_CELL_WIDTH, MAX_FIGURE_HEIGHT = 70, 44, 250
PANEL_WIDTH, PANEL_HEIGHT = 270, 280
MAX_COLUMNS, MAX_ROWS, MAX_PANELS, MAX_FRAMES = 100, 40, 8, 750
MAX_RATE = 50.0
SHADES = 20


def contact_sheet(
    rows: Sequence[Row],
    *,
    columns: int = 10,
    start: float = 0.0,
    end: float | None = None,
    view: str = "three-quarter",
    ghost: Clip | None = None,
    hand: Side | None = None,
) -> Image.Image:
    """Draws one row of stick figures per motion, all at the same times.

    All figures have the same scale and are centred on their roots. The camera turns with a motion and so stays on the
    same side of it. Left limbs are blue, right limbs vermilion. A motion that has ended holds its last frame, drawn
    paler.

    Args:
        rows: 1 to 40 motions: label, clip and roles.
        columns: The number of figures in a row, 1 to 100, at evenly spaced times.
        start: The time of the first figure, in seconds.
        end: The time of the last figure, in seconds; None for the end of the longest motion.
        view: "side", "front" or "three-quarter".
        ghost: A motion with the same joints as the rows', drawn in grey behind every row.
        hand: "left" or "right" to draw a close-up of this hand instead of whole figures.

    Returns:
        The picture, 1200 pixels wide, or wider if the columns need it.

    Raises:
        SettingsError: A value is out of range, `start` is after `end`, the view is unknown, or the ghost's joints
            differ.
    """
    if not 1 <= columns <= MAX_COLUMNS:
        raise SettingsError(f"cannot draw {columns} columns", mend=f"Choose 1 to {MAX_COLUMNS} columns")
    start, end = _checked(rows, MAX_ROWS, start, end, view, ghost)
    times = np.linspace(start, end, columns)
    takes = [_takes(row, times, view, ghost, hand) for row in rows]

    heading = _font(15)
    labels = [_wrapped(label, heading, LABEL_WIDTH, lines=3) for label, _, _ in rows]
    label_width = max(heading.getlength(line) for lines in labels for line in lines)
    left = MARGIN + round(max(label_width, MIN_LABEL_WIDTH)) + 16
    cell = max((SHEET_WIDTH - left - MARGIN) / columns, MIN_CELL_WIDTH)
    low, _, high, _ = _bounds([take for row in takes for take in row])
    extents = [_bounds(row) for row in takes]
    tallest = max(top - bottom for _, bottom, _, top in extents)
    scale = min(cell / (1.04 * (high - low)), MAX_FIGURE_HEIGHT / tallest)
    heights = [round((top - bottom) * scale) + 2 * PADDING for _, bottom, _, top in extents]
    width, baseline = left + round(cell * columns) + MARGIN, MARGIN + sum(heights) + 18
    sheet = Image.new("RGB", (width, MARGIN + sum(heights) + FOOTER), WHITE)
    draw = ImageDraw.Draw(sheet)

    middles = [(column + 0.5) * cell - (low + high) / 2.0 * scale for column in range(columns)]
    floor = np.array([[0.0, 0.0], [columns * cell, 0.0], [columns * cell, -1.5], [0.0, -1.5]])
    y = MARGIN
    for row, lines, height, (*_, top) in zip(takes, labels, heights, extents, strict=True):
        strip = canvas(width - left, height)
        ground = PADDING + top * scale
        if hand is None:
            Brush(strip, (0.0, ground), 1.0).polygon(floor, FLOOR)
        for column, middle in enumerate(middles):
            _paint(Brush(strip, (middle, ground), scale), row, column)
        sheet.paste(reduced(strip), (left, y))
        draw.multiline_text((MARGIN, y + height / 2), "\n".join(lines), TEXT, heading, anchor="lm", spacing=3)
        y += height

    small = _font(12)
    decimals = 1 if np.allclose(times, times.round(1), atol=1e-6) else 2
    labelled_every = int(np.ceil(small.getlength("00.00 s") * 1.1 / cell))
    for column in range(0, columns, labelled_every):
        at = left + (column + 0.5) * cell
        draw.text((at, baseline), f"{times[column]:.{decimals}f} s", QUIET, small, anchor="mm")
    for word, colour, right, down in _legend(rows, ghost, small):
        draw.text((MARGIN + right, baseline + down), word, colour, small, anchor="lm")
    return sheet


def animation(
    rows: Sequence[Row],
    *,
    rate: float = 25.0,
    start: float = 0.0,
    end: float | None = None,
    view: str = "three-quarter",
    ghost: Clip | None = None,
    hand: Side | None = None,
) -> bytes:
    """Draws motions side by side, at true speed, as a looping GIF. Marks on the floor are fixed in the world.

    Args:
        rows: 1 to 8 motions: label, clip and roles.
        rate: Frames per second, 1 to 50. A GIF's frames last whole hundredths of a second, so the rate is rounded to
            the nearest of 50, 33.3, 25, 20 ...
        start: The time of the first frame, in seconds.
        end: The time of the last frame, in seconds; None for the end of the longest motion.
        view, ghost, hand: As in `contact_sheet`.

    Returns:
        The bytes of the GIF.

    Raises:
        SettingsError: As for `contact_sheet`, or for more than 750 frames.
    """
    if not 1.0 <= rate <= MAX_RATE:
        raise SettingsError(f"cannot play {rate} frames per second", mend=f"Choose a rate from 1 to {MAX_RATE:g}")
    start, end = _checked(rows, MAX_PANELS, start, end, view, ghost)
    delay = round(100.0 / rate)
    steps = (end - start) * 100.0 / delay + 1e-6
    if steps >= MAX_FRAMES:
        raise SettingsError(
            f"{end - start:g} s are more than {MAX_FRAMES} frames, the most in one animation",
            mend="Choose a later start, an earlier end or a lower rate",
        )
    count = int(steps) + 1
    times = np.linspace(start, start + (count - 1) * delay / 100.0, count)
    takes = [_takes(row, times, view, ghost, hand) for row in rows]

    panel = min(PANEL_WIDTH, SHEET_WIDTH // len(rows))
    width = panel * len(rows)
    low, bottom, high, top = _bounds([take for row in takes for take in row])
    scale = min(panel / (1.08 * (high - low)), PANEL_HEIGHT / (top - bottom))
    ground = MARGIN + PADDING + top * scale
    height = round(ground - bottom * scale) + 2 * PADDING
    heading, small = _font(15), _font(12)
    labels = ["\n".join(_wrapped(label, heading, panel - 16, lines=2)) for label, _, _ in rows]
    footer = 26 + 18 * max(label.count("\n") for label in labels)
    palette = _palette()
    frames = []
    for number, time in enumerate(times):
        stage = canvas(width, height)
        for index, row in enumerate(takes):
            brush = Brush(stage, ((index + 0.5) * panel - (low + high) / 2.0 * scale, ground), scale)
            if hand is None:
                _paint_floor(brush, row[-1].floor[number], panel / (2.0 * scale))
            _paint(brush, row, number)
        frame = Image.new("RGB", (width, height + footer), WHITE)
        frame.paste(reduced(stage))
        draw = ImageDraw.Draw(frame)
        for index, label in enumerate(labels):
            draw.multiline_text(
                ((index + 0.5) * panel, height), label, TEXT, heading, anchor="ma", align="center", spacing=3
            )
        draw.text((PADDING, PADDING), f"{time:.2f} s", QUIET, small, anchor="lt")
        frames.append(frame.quantize(palette=palette, dither=Image.Dither.NONE))
    file = io.BytesIO()
    frames[0].save(file, "GIF", save_all=True, append_images=frames[1:], duration=10 * delay, loop=0, disposal=1)
    return file.getvalue()


def _checked(
    rows: Sequence[Row], most: int, start: float, end: float | None, view: str, ghost: Clip | None
) -> tuple[float, float]:
    """Checks the arguments that both pictures share. Returns start and end in seconds."""
    if not rows:
        raise SettingsError("no motion to draw", mend="Give at least one row: label, clip, roles")
    if len(rows) > most:
        raise SettingsError(f"{len(rows)} motions do not fit in one picture", mend=f"Draw at most {most}")
    if view not in VIEWS:
        raise SettingsError(f"unknown view {view!r}", mend=did_you_mean(view, VIEWS))
    end = max(clip.duration for _, clip, _ in rows) if end is None else end
    if not (np.isfinite([start, end]).all() and 0.0 <= start <= end):
        raise SettingsError(f"cannot draw from {start:g} s to {end:g} s", mend="Choose 0 <= start <= end, in seconds")
    for label, clip, _ in rows:
        if ghost is not None and ghost.skeleton.names != clip.skeleton.names:
            mend = "Put it on that skeleton with `motionsplice convert --skeleton`"
            raise SettingsError(f"the ghost's joints differ from those of {label!r}", mend=mend)
    return start, end


def _takes(row: Row, times: Floats, view: str, ghost: Clip | None, hand: Side | None) -> tuple[Take, ...]:
    """Returns the takes of a row: of the ghost, if any, and of the motion."""
    _, clip, roles = row
    figure = HandFigure.of(clip.skeleton, roles, hand) if hand else StickFigure.of(clip.skeleton, roles)
    camera = Camera.beside(clip, roles, times, view)
    return tuple(Take.of(motion, figure, times, camera) for motion in (ghost, clip) if motion is not None)


def _bounds(takes: Sequence[Take]) -> tuple[float, float, float, float]:
    """Left, bottom, right and top in metres of all figures; the floor, at 0, is always within."""
    bounds = np.array([take.figure.bounds(take.points)[:, :2] for take in takes])
    (left, bottom), (right, top) = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    return float(left), float(min(bottom, 0.0)), float(right), float(top)


def _paint(brush: Brush, row: tuple[Take, ...], number: int) -> None:
    """A row's figure at one time, over its ghost if it has one."""
    *ghosts, take = row
    for ghost in ghosts:
        ghost.figure.paint_ghost(brush, ghost.points[number])
    take.figure.paint(brush, take.points[number], fade=HELD if take.held[number] else 0.0)


def _paint_floor(brush: Brush, marks: Floats, reach: float) -> None:
    """Paints the marks [m, 3] within `reach` metres of a figure, paler with distance."""
    for mark, distance in zip(marks, np.linalg.norm(marks, axis=-1), strict=True):
        if distance < reach:
            brush.disc(mark[:2], 0.03, mixed(QUIET, 0.3 + 0.7 * distance / reach), flatness=0.4)


def _font(size: float) -> Font:
    return ImageFont.load_default(size)


def _wrapped(label: str, font: Font, width: float, *, lines: int) -> list[str]:
    """Breaks `label` at spaces into at most `lines` lines; lines longer than `width` pixels are cut."""
    wrapped = [""]
    for word in label.split():
        longer = f"{wrapped[-1]} {word}".strip()
        if not wrapped[-1] or font.getlength(longer) <= width:
            wrapped[-1] = longer
        else:
            wrapped.append(word)
    if len(wrapped) > lines:
        wrapped[lines - 1 :] = [" ".join(wrapped[lines - 1 :])]
    return [_cut(line, font, width) for line in wrapped]


def _cut(line: str, font: Font, width: float) -> str:
    if font.getlength(line) <= width:
        return line
    line = line[: int(width)]
    while line and font.getlength(f"{line}…") > width:
        line = line[:-1]
    return f"{line}…"


def _legend(rows: Sequence[Row], ghost: Clip | None, font: Font) -> list[tuple[str, Colour, float, float]]:
    """Returns the words of the legend, their colours, and their offsets to the right and down, in pixels."""
    words = [("left", LEFT, 0.0, 0.0), ("right", RIGHT, font.getlength("left  "), 0.0)]
    if ghost is not None:
        name = next((label for label, clip, _ in rows if clip is ghost), ghost.name)
        words.append((_cut(f"grey: {name}", font, SHEET_WIDTH / 2), QUIET, 0.0, 17.0))
    return words


def _palette() -> Image.Image:
    """Returns the palette of all frames: every colour in equal steps to white, for smooth edges."""
    shades = [mixed(base, step / SHADES) for base in (TEXT, TRUNK, LEFT, RIGHT, QUIET) for step in range(SHADES)]
    image = Image.new("P", (1, 1))
    image.putpalette([value for colour in [WHITE, *shades, GHOST, TORSO] for value in colour])
    return image
