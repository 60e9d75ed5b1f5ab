from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from PIL.GifImagePlugin import GifImageFile

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.pictures.brush import Brush, Colour, canvas, reduced
from motionsplice.pictures.camera import Camera, Take
from motionsplice.pictures.sheets import MAX_COLUMNS, MAX_FRAMES, animation, contact_sheet
from motionsplice.pictures.stick_figure import GHOST, LEFT, RIGHT, StickFigure

BONES = (
    ("hips", "", (0.0, 0.0, 0.0)),
    ("spine", "hips", (0.0, 0.1, 0.0)),
    ("chest", "spine", (0.0, 0.3, 0.0)),
    ("neck", "chest", (0.0, 0.15, 0.0)),
    ("head", "neck", (0.0, 0.1, 0.02)),
    *(
        (
            f"{name}_{side}",
            f"{parent}_{side}" if parent in ("arm", "forearm", "thigh", "calf", "foot") else parent,
            bone,
        )
        for side, sign in (("l", 1.0), ("r", -1.0))
        for name, parent, bone in (
            ("arm", "chest", (0.18 * sign, 0.05, 0.0)),
            ("forearm", "arm", (0.28 * sign, 0.0, 0.0)),
            ("hand", "forearm", (0.25 * sign, 0.0, 0.0)),
            ("thigh", "hips", (0.1 * sign, -0.05, 0.0)),
            ("calf", "thigh", (0.0, -0.42, 0.0)),
            ("foot", "calf", (0.0, -0.4, 0.0)),
            ("toe", "foot", (0.0, -0.06, 0.14)),
        )
    ),
)
NAMES = tuple(name for name, _, _ in BONES)
AT = {name: index for index, name in enumerate(NAMES)}
LIMBS = ("thigh", "calf", "foot", "toe")
ROLES = Roles(
    0,
    1,
    (2,),
    3,
    4,
    *(AT[f"{name}_{side}"] for side in "lr" for name in LIMBS),
    *(AT[f"{name}_{side}"] for side in "lr" for name in ("arm", "forearm", "hand")),
)


def rig(*, ends: bool = True, fingers: int = 0) -> Skeleton:
    names, parents, offsets = (
        list(NAMES),
        [AT.get(parent, -1) for _, parent, _ in BONES],
        [bone for *_, bone in BONES],
    )
    for finger in range(fingers):
        names.append(f"finger{finger}")
        parents.append(AT["hand_l"])
        offsets.append((0.12, 0.0, 0.02 * finger - 0.04))
    tips = (AT["hand_l"], AT["hand_r"]) if ends else ()
    reach = np.array([[0.15, 0.0, 0.0], [-0.15, 0.0, 0.0]])[: len(tips)]
    return Skeleton(tuple(names), np.array(parents), np.array(offsets), np.array(tips, np.int64), reach.reshape(-1, 3))


def walk(
    seconds: float = 1.0,
    *,
    skeleton: Skeleton | None = None,
    turn: float = 0.0,
    swing: float = 0.5,
    rate: float = 30.0,
) -> Clip:
    """Walks along +Z, or along a curve of `turn` radians per second, with the arms hanging."""
    skeleton = skeleton or rig()
    clock = np.arange(round(seconds * rate) + 1) / rate
    wave, heading = np.sin(2.0 * np.pi * clock), turn * clock
    rotations = np.tile(quaternion.IDENTITY, (len(clock), skeleton.joint_count, 1))
    rotations[:, 0] = quaternion.about([0.0, 1.0, 0.0], heading)
    for side, sign in (("l", 1.0), ("r", -1.0)):
        hang = quaternion.about([0.0, 0.0, 1.0], np.full(len(clock), -1.3 * sign))
        rotations[:, AT[f"arm_{side}"]] = quaternion.multiply(
            quaternion.about([1.0, 0.0, 0.0], -swing * sign * wave), hang
        )
        rotations[:, AT[f"thigh_{side}"]] = quaternion.about([1.0, 0.0, 0.0], 0.4 * sign * wave)
    steps = np.stack([np.sin(heading), 0.0 * heading, np.cos(heading)], axis=-1) * 1.3 / rate
    return Clip("walk", skeleton, rate, np.array([0.0, 0.92, 0.0]) + np.cumsum(steps, axis=0), rotations)


def pixels(image: Image.Image) -> NDArray[np.int64]:
    return np.asarray(image.convert("RGB")).astype(np.int64)


def where(image: Image.Image, colour: Colour, tolerance: int = 12) -> NDArray[np.bool_]:
    return np.abs(pixels(image) - colour).max(axis=-1) <= tolerance


def test_a_sheet_is_1200_pixels_wide_and_grows_with_its_rows() -> None:
    row = ("walk", walk(), ROLES)
    one, two = contact_sheet([row]), contact_sheet([row, row])
    assert one.width == two.width == 1200
    assert two.height - one.height > 100
    assert contact_sheet([row], columns=MAX_COLUMNS).width > 4000


def test_pictures_are_reproducible_byte_for_byte() -> None:
    rows = [("walk", walk(), ROLES)]
    assert contact_sheet(rows).tobytes() == contact_sheet(rows).tobytes()
    assert animation(rows, end=0.2) == animation(rows, end=0.2)


@pytest.mark.parametrize("view", ["side", "front", "three-quarter"])
def test_hands_are_painted_at_their_projection_in_their_own_colours(view: str) -> None:
    clip, times = walk(swing=1.2), np.array([0.25])
    camera = Camera.beside(clip, ROLES, times, view)
    take = Take.of(clip, StickFigure.of(clip.skeleton, ROLES), times, camera)
    image = canvas(400, 500)
    take.figure.paint(Brush(image, (200.0, 450.0), 200.0), take.points[0])
    picture = reduced(image)
    for side, end, colour in (("l", 0, LEFT), ("r", 1, RIGHT)):
        middle = take.points[0, [AT[f"hand_{side}"], len(NAMES) + end], :2].mean(axis=0)
        x, y = 200.0 + 200.0 * middle[0], 450.0 - 200.0 * middle[1]
        assert where(picture, colour)[round(y), round(x)]


def test_the_left_hand_is_right_in_the_front_view_and_the_side_view_walks_to_the_right() -> None:
    clip, times = walk(), np.array([0.5])
    wrists = [AT["hand_l"], AT["hand_r"]]
    figure = StickFigure.of(clip.skeleton, ROLES)
    front, side = (
        Take.of(clip, figure, times, Camera.beside(clip, ROLES, times, view)).points[0] for view in ("front", "side")
    )
    assert front[wrists[0], 0] > 0.1 > -0.1 > front[wrists[1], 0]
    assert side[AT["toe_l"], 0] > side[AT["foot_l"], 0] + 0.05
    assert side[wrists[1], 2] > side[wrists[0], 2]


def test_the_camera_turns_with_the_character() -> None:
    times = np.linspace(2.0, 3.0, 5)
    views = []
    for turn in (0.0, 0.8):
        clip = walk(5.0, turn=turn)
        camera = Camera.beside(clip, ROLES, times, "side")
        views.append(Take.of(clip, StickFigure.of(clip.skeleton, ROLES), times, camera).points)
    np.testing.assert_allclose(views[0], views[1], atol=1e-3)


def test_floor_marks_are_fixed_in_the_world() -> None:
    clip, times = walk(), np.array([0.5, 0.6])
    take = Take.of(clip, StickFigure.of(clip.skeleton, ROLES), times, Camera.beside(clip, ROLES, times, "side"))
    before, after = (marks[np.abs(marks[:, 0]) < 0.5] for marks in take.floor)
    moved = before - [1.3 * 0.1, 0.0, 0.0]
    assert all(np.linalg.norm(after - mark, axis=1).min() < 1e-6 for mark in moved if mark[0] > -0.5)


def test_all_rows_have_the_same_scale() -> None:
    clip = walk()
    half = replace(clip, skeleton=clip.skeleton.scaled(0.5), root_positions=clip.root_positions * 0.5)
    sheet = contact_sheet([("adult", clip, ROLES), ("child", half, ROLES)], columns=1, view="front")
    lines = np.flatnonzero((pixels(sheet)[:-54, 200:] < 120).any(axis=(1, 2)))
    gap = int(np.argmax(np.diff(lines)))
    adult, child = lines[gap] - lines[0], lines[-1] - lines[gap + 1]
    assert adult > 150
    assert child == pytest.approx(adult / 2, abs=3)


def test_times_between_frames_and_after_the_end_have_a_floor() -> None:
    clip = walk()
    for time in (0.0, 0.512, 1.0, 7.0):
        camera = Camera.beside(clip, ROLES, np.array([time]), "side")
        assert camera.ground == pytest.approx(0.0, abs=0.15)
        assert contact_sheet([("walk", clip, ROLES)], columns=1, start=time, end=time).width == 1200


def test_a_motion_that_has_ended_is_held_and_drawn_paler() -> None:
    rows = [("long", walk(2.0), ROLES), ("short", walk(0.5), ROLES)]
    sheet = contact_sheet(rows, columns=4)
    strong = where(sheet, LEFT)[:-54]
    upper, lower = np.array_split(strong[:, 900:], 2)
    assert upper.any()
    assert not lower.any()
    assert np.array_split(strong[:, 110:350], 2)[1].any()


def test_a_ghost_is_visible_where_it_differs() -> None:
    rows = [("walk", walk(), ROLES)]
    same, other = contact_sheet(rows, ghost=walk()), contact_sheet(rows, ghost=walk(swing=-0.9))
    assert where(other, GHOST, 3).sum() > where(same, GHOST, 3).sum() + 200


def test_bones_outside_the_body_are_left_out() -> None:
    plain = rig()
    names, parents = (*plain.names, "ik_target"), np.append(plain.parents, 0)
    offsets = np.vstack([plain.offsets, [[5.0, 0.0, 5.0]]])
    with_target = Skeleton(names, parents, offsets, plain.end_parents, plain.end_offsets)
    points = [
        figure.bounds(figure.points(clip.root_positions, clip.rotations))
        for skeleton in (plain, with_target)
        for clip in [walk(skeleton=skeleton)]
        for figure in [StickFigure.of(skeleton, ROLES)]
    ]
    np.testing.assert_allclose(points[0], points[1])


def test_fingers_are_thinner_than_a_single_hand_bone() -> None:
    def thickness(skeleton: Skeleton) -> float:
        left_arm = StickFigure.of(skeleton, ROLES).limbs[2]
        return left_arm.bones[-1].stop_radius

    assert thickness(rig(ends=False, fingers=5)) < thickness(rig())


@pytest.mark.parametrize("skeleton", [rig(ends=False), rig(fingers=5)])
def test_rigs_without_a_head_joint_get_a_head(skeleton: Skeleton) -> None:
    roles = replace(ROLES, neck=-1, head=-1)
    clip = walk(skeleton=skeleton)
    head = StickFigure.of(skeleton, roles).points(clip.root_positions, clip.rotations)[0, -2]
    shoulders = StickFigure.of(skeleton, ROLES).points(clip.root_positions, clip.rotations)[0, AT["arm_l"]]
    assert head[1] > shoulders[1]
    assert contact_sheet([("walk", clip, roles)]).width == 1200


def test_long_labels_are_wrapped_and_cut() -> None:
    label = "a label of very many words that goes on and on and on and on and on " + "x" * 200
    assert contact_sheet([(label, walk(), ROLES)]).width == 1200
    assert animation([(label, walk(), ROLES)], end=0.1)


@pytest.mark.parametrize(("rate", "delay"), [(25.0, 40), (30.0, 30), (50.0, 20)])
def test_an_animation_plays_at_true_speed(rate: float, delay: int) -> None:
    rows = [("long", walk(1.2), ROLES), ("short", walk(0.5), ROLES)]
    film = Image.open(io.BytesIO(animation(rows, rate=rate)))
    assert isinstance(film, GifImageFile)
    assert film.n_frames == 1200 // delay + 1
    delays = []
    for frame in range(film.n_frames):
        film.seek(frame)
        delays.append(film.info["duration"])
    assert set(delays) == {delay}
    assert film.info["loop"] == 0


def test_an_animation_draws_each_pose_at_its_time() -> None:
    rows = [("walk", walk(0.8), ROLES)]
    fast, slow = (Image.open(io.BytesIO(animation(rows, rate=rate))) for rate in (25.0, 12.5))
    fast.seek(10)
    pose = pixels(fast)
    apart = []
    for frame in (4, 5, 6):
        slow.seek(frame)
        apart.append(float(np.abs(pixels(slow) - pose).mean()))
    assert apart[1] < 0.2 * min(apart[0], apart[2])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rows": []}, "no motion"),
        ({"rows": [("walk", walk(), ROLES)] * 1000}, "do not fit"),
        ({"start": 2.0, "end": 1.0}, "cannot draw from 2 s to 1 s"),
        ({"start": 2.0}, "cannot draw from 2 s"),
        ({"start": -1.0}, "cannot draw from -1 s"),
        ({"end": float("nan")}, "cannot draw from 0 s to nan s"),
        ({"view": "sid"}, "'side'"),
        ({"ghost": walk(skeleton=rig(fingers=2))}, "joints differ"),
    ],
)
def test_invalid_arguments_are_refused(change: dict[str, Any], words: str) -> None:
    arguments = {"rows": [("walk", walk(), ROLES)], **change}
    for picture in (contact_sheet, animation):
        with pytest.raises(SettingsError, match=words) as caught:
            picture(**arguments)
        assert caught.value.mend


@pytest.mark.parametrize("columns", [0, -3, 10_000])
def test_a_sheet_with_too_few_or_too_many_columns_is_refused(columns: int) -> None:
    with pytest.raises(SettingsError, match="columns"):
        contact_sheet([("walk", walk(), ROLES)], columns=columns)


@pytest.mark.parametrize("rate", [0.0, -25.0, 1e9, float("nan")])
def test_an_animation_at_an_impossible_rate_is_refused(rate: float) -> None:
    with pytest.raises(SettingsError, match="frames per second"):
        animation([("walk", walk(), ROLES)], rate=rate)


@pytest.mark.parametrize("end", [MAX_FRAMES / 25.0, 1e9, 1e307])
def test_an_animation_of_too_many_frames_is_refused(end: float) -> None:
    with pytest.raises(SettingsError, match=f"{MAX_FRAMES} frames"):
        animation([("walk", walk(), ROLES)], end=end)
