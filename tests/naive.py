"""Slow, readable twins of the kernels: the oracles of their tests."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import lsq_linear, minimize
from scipy.spatial.transform import Rotation

from motion import quaternion
from motion.clip import Clip
from motion.pointcloud import horn_rotation
from motion.quaternion import Floats
from precompute.posture import measure_torso
from precompute.splice import transfer_posture
from runtime.bank import Bank


def planar_distance(a: Floats, b: Floats) -> float:
    """Least sum of squared distances of two clouds [p, 3] over a turn about Y and a floor shift, by search."""

    def apart(parameters: Floats) -> float:
        turn, x, z = parameters
        moved = Rotation.from_euler("Y", turn).apply(b) + np.array([x, 0.0, z])
        return float(np.sum((a - moved) ** 2))

    shift = a.mean(axis=0) - b.mean(axis=0)
    starts = [(turn, shift[0], shift[2]) for turn in np.linspace(-np.pi, np.pi, 7)]
    return min(float(minimize(apart, start, method="BFGS").fun) for start in starts)


def increasing_coefficients(design: Floats, y: Floats, floor: Floats) -> Floats:
    """Least squares with increments of at least `floor`, as SciPy solves it for a first value and increments."""
    count = design.shape[1]
    rise = np.concatenate([np.ones((count, 1)), np.tril(np.ones((count, count - 1)), -1)], axis=1)
    fit = lsq_linear(design @ rise, y, bounds=(np.concatenate([[-np.inf], floor]), np.inf), method="bvls", tol=1e-12)
    return np.asarray(rise @ fit.x)


def cheapest_path_cost(grid: Floats, most_flat: int) -> Floats:
    """Least cost of a slope-limited path from (0, 0) to each cell [n, m], by trying every path."""
    best = np.full(grid.shape, np.inf)

    def walk(i: int, j: int, cost: float, axis: int, run: int) -> None:
        best[i, j] = min(best[i, j], cost)
        for step, (down, right) in enumerate(((1, 1), (1, 0), (0, 1))):
            k, m = i + down, j + right
            longer = run + 1 if step == axis else 1
            if k < grid.shape[0] and m < grid.shape[1] and (step == 0 or longer <= most_flat):
                walk(k, m, cost + float(grid[k, m]), step, longer)

    walk(0, 0, float(grid[0, 0]), 0, 0)
    return best


def ring_cost(distances: Floats, wound: Sequence[int]) -> float:
    """What one way round a ring costs: a frame costs the mean of the cells it passed."""
    cells = distances.shape[1]
    total = float(distances[0, wound[0] % cells])
    for frame, (before, here) in enumerate(itertools.pairwise(wound), 1):
        passed = range(before + 1, here + 1) if here > before else [here]
        total += float(np.mean([distances[frame, cell % cells] for cell in passed]))
    return total


def best_ring_cost(distances: Floats, most_advance: int, most_zero: int) -> float:
    """The least cost of any allowed way round a ring, by trying all."""
    frames, cells = distances.shape
    best = math.inf
    for start in range(cells):
        for steps in itertools.product(range(most_advance + 1), repeat=frames - 1):
            rests = max((len(list(run)) for step, run in itertools.groupby(steps) if step == 0), default=0)
            if rests <= most_zero:
                best = min(best, ring_cost(distances, [start, *(start + np.cumsum(steps)).tolist()]))
    return best


def pose(
    bank: Bank, locomotion: str, time: float, action: str, start: float, method: str, posture: str
) -> tuple[Floats, Floats]:
    """One character's root position [3] and local rotations [J, 4], straight from the bank's tables."""
    entry_l, entry_u, tables = bank.clip(locomotion), bank.clip(action), bank.tables
    pelvis, upper = bank.roles.pelvis, bank.skeleton.subtree(bank.roles.pelvis)

    def between(table: str, entry_first: int, count: int, at: float) -> Floats:
        before = min(max(int(at), 0), count - 2)
        a, b = (np.asarray(tables[table][entry_first + before + step], np.float64) for step in (0, 1))
        t = min(max(at - before, 0.0), 1.0)
        return quaternion.slerp(a, b, np.full(a.shape[:-1], t)) if table in QUATERNIONS else a + t * (b - a)

    frame_l = time * entry_l.rate
    in_l = (entry_l.first_row, entry_l.frame_count, frame_l)
    root, rotations = between("root_positions", *in_l), between("rotations", *in_l)
    if method == "none":
        return root, rotations
    if method == "naive":
        seconds = start + time
        frame_u = (seconds if seconds <= entry_u.duration else seconds % entry_u.duration) * entry_u.rate
    else:
        phase = float(between("phase_of_frame", *in_l))
        start_phase = float(between("phase_of_frame", entry_u.first_row, entry_u.frame_count, start * entry_u.rate))
        phase += math.ceil(start_phase - entry_l.first_phase - 1e-3)
        while phase > entry_u.last_phase and entry_u.loop > 0:
            phase -= entry_u.loop
        rows = slice(entry_u.first_row, entry_u.first_row + entry_u.row_count)
        frame_u = float(np.interp(phase, tables["phase_of_frame"][rows], np.arange(entry_u.row_count)))
    in_u = (entry_u.first_row, entry_u.row_count, frame_u)
    pelvis_l = rotations[pelvis].copy()
    rotations[upper] = between("rotations", *in_u)[upper]
    if method == "naive":
        return root, rotations
    clouds = between("upper_clouds", *in_l), between("upper_clouds", *in_u)
    turned = quaternion.multiply(pelvis_l, horn_rotation(*clouds))
    frame = between("posture_frames", *in_l)
    if posture == "absolute":
        turn = horn_rotation(tables["postures"][bank.number(action)], tables["postures"][bank.number(locomotion)])
    elif posture == "relative":
        own, theirs = between("torso_offsets", *in_l), between("torso_offsets", *in_u)
        turn = quaternion.multiply(theirs, quaternion.conjugate(own))
    else:
        turn = quaternion.IDENTITY
    seen = quaternion.multiply(quaternion.multiply(frame, turn), quaternion.conjugate(frame))
    turned = quaternion.multiply(seen, turned)
    rotations[pelvis] = turned
    return root, rotations


def followed(bank: Bank, splice: Clip, locomotion: str, action: str, time_constant: float) -> Clip:
    """A splice without posture, given that of the action by a running mean of its own."""
    torso, postures = measure_torso(splice, bank.roles), bank.tables["postures"]
    mean, share = postures[bank.number(locomotion)].copy(), 1.0 - math.exp(-1.0 / (splice.rate * time_constant))
    turns = []
    for shoulders in torso.upright[:, -2:]:
        mean += share * (shoulders - mean)
        turns.append(horn_rotation(postures[bank.number(action)], mean))
    return transfer_posture(splice, torso, np.array(turns), bank.roles)


QUATERNIONS = ("rotations", "posture_frames", "torso_offsets")
