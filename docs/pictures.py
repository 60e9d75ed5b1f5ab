"""Draws the pictures of the documentation: `make pictures`, or `PYTHONPATH=. python docs/pictures.py` in the root."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from bench.characters.aim_charts import aim_chart
from bench.characters.slide_charts import slide_chart
from bench.clips import bank_of
from bench.generated import Size, generate
from bench.quality.additive import add
from bench.quality.charts import pair_chart, ratio_grid
from bench.quality.pair_list import grid_pairs, truth_of
from bench.quality.scores import Form, score_pair, splice_pair
from bench.retarget.kinds import KINDS
from bench.retarget.rigs import on_rig
from bench.speed import flatness
from bench.speed.frames import batches
from bench.speed.speed_charts import speed_chart
from bench.structure.layers import layers_picture, read_contracts
from docs.screenshots import take_screenshots
from motionsplice.commands.demo import demo_command
from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.procedural.library import make, truth
from motionsplice.motion.procedural.stances import fair, standing_action, standing_truth
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.by_roles import retarget
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import Side, find_roles
from motionsplice.pictures.correlation_charts import draw_chart
from motionsplice.pictures.hand_charts import draw_alignment
from motionsplice.pictures.sheets import contact_sheet
from motionsplice.precompute.hands.merge import merge_hands
from motionsplice.precompute.hands.settings import HandSettings
from motionsplice.precompute.hands.splice import splice_hands
from motionsplice.precompute.preparation.standing import measure_standing
from motionsplice.precompute.splice import splice_naive, splice_standing
from motionsplice.precompute.study.body_angles import View
from motionsplice.precompute.study.correlation import study
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import Aim, Look
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Posture
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage

PROJECT = Path(__file__).parents[1]
IMAGES = PROJECT / "docs" / "images"
FORMS: tuple[Posture, ...] = ("off", "absolute", "relative")


def main() -> None:
    """Writes all pictures to docs/images."""
    IMAGES.mkdir(exist_ok=True)
    (IMAGES / "layers.png").write_bytes(layers_picture(read_contracts(PROJECT / "pyproject.toml")))
    draw_study()
    draw_hands()
    draw_retargeting()
    draw_standing()
    draw_speed()
    with tempfile.TemporaryDirectory() as folder:
        demo_command(Path(folder) / "demo")
        for picture in ("curve+carry_cup.png", "curve+carry_cup.gif"):
            (IMAGES / picture).write_bytes((Path(folder) / "demo" / picture).read_bytes())
        take_screenshots(Path(folder) / "demo" / "bank", IMAGES)
        bank = bank_of(None, "walk", Path(folder))
        evaluator, true_clip = Evaluator(bank), truth("stairs_up", "carry_box")
        rows = [(form, evaluator.clip(Splice("stairs_up", "carry_box", posture=form)), bank.roles) for form in FORMS]
        contact_sheet(rows, columns=8, start=1.0, end=3.0, ghost=true_clip).save(IMAGES / "postures.png")
        draw_mirror_images(evaluator)
        draw_characters(evaluator)
        draw_feet(Stage(evaluator))
        draw_aiming(evaluator)
        draw_quality(evaluator)


SCENE: dict[float, tuple[str, Any, dict[str, float]]] = {
    1.5: ("act", Action("carry_box"), {}),
    4.5: ("play", "run", {"blend": 0.5}),
    7.5: ("stop", None, {}),
    9.0: ("act", Action("wave", mask="right_arm", loop=False), {}),
    11.5: ("play", {"walk": 0.5, "run": 0.5}, {"blend": 0.5}),
    14.0: ("act", Action("punch", when="left_foot"), {}),
    16.0: ("play", "curve", {"blend": 0.5}),
    18.0: ("stop", None, {}),
}  # seconds: method of Characters, argument, options


def draw_characters(evaluator: Evaluator) -> None:
    """Draws twenty seconds of a character in rows of five seconds."""
    characters = Characters(Stage(evaluator), 60.0)
    characters.add(1, "walk")

    def command(frame: int) -> None:
        method, argument, options = SCENE.get(frame / 60.0, ("", None, {}))
        if method:
            getattr(characters, method)([0], *([argument] if argument else []), **options)

    roots, rotations = played(characters, 20 * 60 + 1, command)
    rows = []
    for start in range(0, 20, 5):
        part = slice(60 * start, 60 * start + 301)
        clip = Clip(f"{start} s", evaluator.bank.skeleton, 60.0, roots[part], rotations[part])
        rows.append((f"{start} s to {start + 5} s", clip, evaluator.bank.roles))
    contact_sheet(rows, columns=12).save(IMAGES / "characters.png")


def played(characters: Characters, frames: int, command: Callable[[int], None]) -> tuple[Floats, Floats]:
    """Returns root positions [F, 3] and rotations [F, J, 4] of a character that is commanded before each frame."""
    poses, roots, rotations = characters.stage.evaluator.poses(1), list[Floats](), list[Floats]()
    for frame in range(frames):
        command(frame)
        characters.evaluate(poses)
        roots.append(poses.root_positions[0].astype(np.float64))
        rotations.append(poses.rotations[0].astype(np.float64))
        characters.advance()
    return np.array(roots), np.array(rotations)


BESIDE = (-3.0, 1.6, 7.0)  # metres: a point to the right of the way
AIMED: dict[str, tuple[str, Any, Any]] = {
    "run, push": ("run", None, None),
    "it looks at a point to its right": ("run", Look(BESIDE), None),
    "and aims there": ("run", Look(BESIDE), Aim(BESIDE, steady=1.0)),
    "walk, the right arm aims": ("walk", Look(BESIDE), Aim(BESIDE, part="right_arm")),
}  # row: locomotion, look, aim


def draw_aiming(evaluator: Evaluator) -> None:
    """Draws characters that pass a point, and look and aim at it; and head and hands beside an aim offset."""
    stage, rows = Stage(evaluator), []
    for label, (locomotion, look, aim) in AIMED.items():
        characters = Characters(stage, 60.0)
        characters.add(1, locomotion)
        if locomotion == "run":
            characters.act([0], Action("push", blend=0.0))
        characters.look([0], look, blend=0.5)
        characters.aim([0], aim, blend=0.5)
        clip = Clip(label, evaluator.bank.skeleton, 60.0, *played(characters, 109, lambda frame: None))
        rows.append((label, clip, evaluator.bank.roles))
    contact_sheet(rows, columns=10, view="front").save(IMAGES / "aiming.png")
    (IMAGES / "aim-offset.png").write_bytes(aim_chart(stage))
    reduce(IMAGES / "aim-offset.png")


def draw_mirror_images(evaluator: Evaluator) -> None:
    """A splice, the splice of the action's mirror image, and that of both mirror images."""
    splices = {
        "curve+wave": Splice("curve", "wave"),
        "wave~mirror": Splice("curve", "wave~mirror"),
        "both ~mirror": Splice("curve~mirror", "wave~mirror"),
    }
    rows = [(label, evaluator.clip(splice), evaluator.bank.roles) for label, splice in splices.items()]
    contact_sheet(rows, columns=8, start=1.0, end=4.0, view="front").save(IMAGES / "mirror.png")


def draw_standing() -> None:
    """A wave captured standing, on a run: replaced, added, spliced, each in front of the truth."""
    performer, wave = fair(1), standing_action("hail", fair(1))
    run, true_clip = make("run", seed=3), standing_truth("run", "hail", performer, locomotion_seed=3)
    roles = find_roles(run.skeleton)
    measured = measure_standing(wave, wave.frame_count, None, None, roles)
    replaced = splice_naive(run, wave, roles)
    results = {
        "replaced": replaced,
        "additive": add(run, replaced, roles),
        "splice": splice_standing(run, wave, roles, measured.standing),
    }
    rows = [(label, clip, roles) for label, clip in results.items()]
    sheet = contact_sheet(rows, columns=10, start=0.8, end=4.2, view="front", ghost=true_clip)
    sheet.save(IMAGES / "standing.png")
    reduce(IMAGES / "standing.png")


def draw_quality(evaluator: Evaluator) -> None:
    """Draws two charts of the quality report: the grid of built-in motions, and one pair."""
    bank, forms, scores = evaluator.bank, (Form("naive"), Form("splice")), []
    for pair in grid_pairs():
        splices = [splice_pair(evaluator, pair.locomotion, pair.action, form) for form in forms]
        scores.append(score_pair(evaluator, pair.locomotion, pair.action, truth_of(pair, bank), splices))
    (IMAGES / "quality-grid.png").write_bytes(ratio_grid(scores, "splice"))
    splices = [splice_pair(evaluator, "curve", "punch", form) for form in (*forms, Form("exact"))]
    (IMAGES / "quality-pair.png").write_bytes(pair_chart(bank, "curve", "punch", truth("curve", "punch"), splices))
    for name in ("quality-grid.png", "quality-pair.png"):
        reduce(IMAGES / name)


def draw_study() -> None:
    """Draws the plots of the correlation study."""
    walk = make("walk", seconds=4.0)
    for view in View:
        file = IMAGES / f"study-{view}.png"
        draw_chart(study(walk, find_roles(walk.skeleton)), view, file)
        reduce(file)


def draw_hands() -> None:
    """Draws hands on a body that counts with its fingers, and their alignment."""
    pair = gesture_pair(11, kinds=["count"] * 5, hand="right", seconds=7.5)
    roles, hand_roles = find_roles(pair.body.skeleton), find_roles(pair.hands.skeleton)
    settings = HandSettings("right")
    spliced = splice_hands(pair.body, roles, pair.hands, hand_roles, settings)
    together: dict[Side, Floats] = {"right": np.minimum(np.arange(pair.body.frame_count), pair.hands.frame_count - 1.0)}
    unaligned, _ = merge_hands(pair.body, roles, pair.hands, hand_roles, together)
    rows = [("as captured", unaligned, roles), ("aligned", spliced.clip, roles), ("truth", pair.truth, roles)]
    sheet = contact_sheet(rows, columns=12, start=0.8, end=6.3, view="front", hand="right", ghost=pair.truth)
    sheet.save(IMAGES / "hands.png")
    draw_alignment(spliced, settings, pair.hands.rate, IMAGES / "hands-alignment.png")
    reduce(IMAGES / "hands.png")


def draw_retargeting() -> None:
    """One motion on other rigs, retargeted from the rig with Unreal's bind pose and proportions."""
    source = on_rig(make("walk", "wave"), KINDS["Unreal"])
    roles = find_roles(source.skeleton)
    rows = [("Unreal, as captured", source, roles)]
    for name in ("Mixamo", "VRM", "CMU", "LAFAN1"):
        rig = on_rig(make("walk"), KINDS[name])
        own = find_roles(rig.skeleton)
        pose = standing_pose(rig.skeleton, own, rig)
        rows.append((name, retarget(source, roles, rig.skeleton, own, pose).clip, own))
    contact_sheet(rows, columns=9, start=1.0, end=3.0).save(IMAGES / "retargeting.png")
    reduce(IMAGES / "retargeting.png")


def draw_feet(stage: Stage) -> None:
    """Draws how feet slide while the locomotion changes."""
    (IMAGES / "feet.png").write_bytes(slide_chart(stage))
    reduce(IMAGES / "feet.png")


def draw_speed() -> None:
    """Draws the time per character and frame by clip length, number of clips and batch size."""
    with tempfile.TemporaryDirectory() as folder:
        evaluator = Evaluator(generate(Path(folder) / "bank", Size()))
        summaries = batches(evaluator, [1, 3, 10, 30, 100, 300, 1000, 3000, 10_000], rounds=100)
    series = flatness.measure(100, flatness.LENGTHS, flatness.COUNTS)
    (IMAGES / "speed.png").write_bytes(speed_chart(series, summaries))
    reduce(IMAGES / "speed.png")


def reduce(file: Path) -> None:
    """Reduces a picture to 128 colours, so that its file is small."""
    Image.open(file).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(file, optimize=True)


if __name__ == "__main__":
    main()
