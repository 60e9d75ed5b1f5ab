from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numba
import pytest
from hypothesis import settings

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.procedural.joined import joined
from motionsplice.motion.procedural.library import make
from motionsplice.motion.procedural.stances import Performer, fair, standing_action
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank

# No deadline: a first call may compile a kernel, and CI machines stall.
settings.register_profile("motionsplice", deadline=None)
settings.load_profile("motionsplice")

TESTS = Path(__file__).parent
LONGEST = ("viewer", "clients", "bench", "test_pages.py", "service", "oracles")
REAL_MOTION = Path(__file__).parents[2] / "shared" / "mocap" / "cmu"

CLIPS = {
    "walk": make("walk", seed=1, seconds=5.0),
    "run": make("run", seed=2, seconds=3.0),
    "side_step": make("side_step", seed=3, seconds=4.0),
    "turn_180": make("turn_180", seed=4, seconds=5.0, rate=30.0),
    "stairs_up": make("stairs_up", seed=5, seconds=4.0),
    "carry_box": make("walk", "carry_box", seed=6, seconds=4.0),
    "wave": make("walk", "wave", seed=7, seconds=2.5),
}
SETTINGS = """
[carry_box]
kind = "action"
neutral = "walk"
tags = ["carry"]
[wave]
kind = "action"
"""


@pytest.hookimpl(optionalhook=True)  # pytest runs without xdist too
def pytest_xdist_auto_num_workers() -> int:
    """Returns one worker more than there are processors, because tests of services and clients also wait."""
    return 1 + (os.cpu_count() or 1)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Moves what takes longest to the front, so that no worker is left with a long file at the end."""
    rank = {name: number for number, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path.relative_to(TESTS).parts[0], len(rank)))


def written(folder: Path, clips: Mapping[str, Clip], settings: str) -> Path:
    """Writes clips as BVH files with a `clips.toml` to a folder, and returns the folder."""
    for name, clip in clips.items():
        (folder / f"{name}.bvh").write_bytes(dump_bvh(clip))
    (folder / "clips.toml").write_text(settings)
    return folder


def built(clips: Path, path: Path) -> Bank:
    """Builds the bank of a folder of clips, and opens it."""
    outcome = build_bank([clips], path, baseline="walk", jobs=1)
    assert not outcome.failed
    return Bank.open(path)


@pytest.fixture(scope="session")
def clip_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven built-in clips as BVH files, two of them actions."""
    return written(tmp_path_factory.mktemp("clips"), CLIPS, SETTINGS)


@pytest.fixture(scope="session")
def bank(clip_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """The bank of `clip_folder`; tests must not change it."""
    return built(clip_folder, tmp_path_factory.mktemp("banks") / "bank")


STANDING_CLIPS = {
    "walk": CLIPS["walk"],
    "run": CLIPS["run"],
    "hail": standing_action("hail", Performer(), seed=1),
    "jab": standing_action("jab", fair(2), seed=2),
    "bow": standing_action("bow", fair(3), seed=3, rate=30.0),
    "idle": standing_action("bow", Performer(), seed=4).frames(0, 60),
    "holding": standing_action("reload", Performer(), seed=5).frames(120, 180),
}
STANDING_SETTINGS = """
[hail]
kind = "action"
[jab]
kind = "action"
neutral = "idle"
[bow]
kind = "action"
neutral = "walk"
[holding]
kind = "action"
mask = "arms"
"""


@pytest.fixture(scope="session")
def standing_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two locomotions, an idle, and four actions that were captured standing."""
    return written(tmp_path_factory.mktemp("standing"), STANDING_CLIPS, STANDING_SETTINGS)


@pytest.fixture(scope="session")
def standing_bank(standing_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """The bank of `standing_folder`; tests must not change it."""
    return built(standing_folder, tmp_path_factory.mktemp("banks") / "standing")


@pytest.fixture(scope="session")
def talk_bank(tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """A long walk, a run, and `talk`, a person who walks, stops and hails, and walks on; tests must not change it."""
    parts = [make("walk", seconds=4.0), standing_action("hail", Performer()), make("walk", seconds=4.0, seed=1)]
    clips = {"walk": make("walk", seconds=14.0, seed=2), "run": make("run", seed=3), "hail": parts[1]}
    settings = '[talk]\nkind = "action"\n[hail]\nkind = "action"'
    folder = written(tmp_path_factory.mktemp("talk"), clips | {"talk": joined("talk", parts)}, settings)
    return built(folder, tmp_path_factory.mktemp("banks") / "talk")


COUNTING = gesture_pair(3, kinds=["count", "point", "wave"], seconds=4.5, hand_rate=50.0)
OTHERS = gesture_pair(4, kinds=["open_close", "count"], seconds=4.0, hand="right")
HANDS = """
[[hands]]
body = "counting"
hands = "counting_hands"

[[hands]]
body = "run"
hands = "counting_hands"
wrist = true

[[hands]]
body = "counting"
hands = "other_hands"
hand = "right"
"""


@pytest.fixture(scope="session")
def hands_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Clips without fingers, an action with fingers, and two hands clips that are aligned to some of them."""
    clips = {name: CLIPS[name] for name in ("walk", "run", "wave")}
    hands = {"counting": COUNTING.body, "counting_hands": COUNTING.hands, "other_hands": OTHERS.hands}
    settings = '[wave]\nkind = "action"\n[counting]\nkind = "action"\n'
    folder = written(tmp_path_factory.mktemp("hands"), {**clips, **hands}, settings)
    (folder / "hands.toml").write_text(HANDS)
    return folder


@pytest.fixture(scope="session")
def hands_bank(hands_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """The bank of `hands_folder`; tests must not change it. Its kernels are compiled: plain ones take a minute."""
    path = tmp_path_factory.mktemp("banks") / "hands"
    if not numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return built(hands_folder, path)
    command = [sys.executable, "-m", "motionsplice", "precompute", str(hands_folder), "--out", str(path)]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "0"}
    subprocess.run([*command, "--baseline", "walk"], env=environment, capture_output=True, check=True)
    return Bank.open(path)


@pytest.fixture(scope="session")
def real_motion() -> Path:
    """The folder of real motion capture, which is not part of the project; skips the test if it is missing."""
    if not REAL_MOTION.is_dir():
        pytest.skip("real motion capture not found (../shared/mocap/cmu)")
    return REAL_MOTION
