"""Slow, readable twins of the kernels: the oracles of their tests."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from scipy.ndimage import minimum_filter1d, uniform_filter1d
from scipy.optimize import lsq_linear, minimize
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.parts import TRUNK, part_of_joint
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.splice import transfer_posture
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.kernels.posture import LEAST_GAP


def planar_distance(a: Floats, b: Floats) -> float:
    """Least sum of squared distances of two clouds [p, 3] over a turn about Y and a floor shift, by search."""

    def apart(parameters: Floats) -> float:
        turn, x, z = parameters
        moved = Rotation.from_euler("Y", turn).apply(b) + np.array([x, 0.0, z])
        return float(np.sum((a - moved) ** 2))

    shift = a.mean(axis=0) - b.mean(axis=0)
    starts = [(turn, shift[0], shift[2]) for turn in np.linspace(-np.pi, np.pi, 7)]
    return min(float(minimize(apart, start, method="BFGS").fun) for start in starts)


def world_transforms(skeleton: Skeleton, root_positions: Floats, rotations: Floats) -> tuple[Floats, Floats]:
    """World positions [F, J, 3] and rotations [F, J, 4], joint by joint for all frames at once."""
    positions, world = np.empty((*rotations.shape[:2], 3)), np.empty_like(rotations)
    positions[:, 0], world[:, 0] = root_positions, rotations[:, 0]
    for joint in range(1, skeleton.joint_count):
        parent = skeleton.parents[joint]
        positions[:, joint] = positions[:, parent] + quaternion.rotate(world[:, parent], skeleton.offsets[joint])
        world[:, joint] = quaternion.multiply(world[:, parent], rotations[:, joint])
    return positions, world


def speeds_and_heights(paths: Floats, step: float, smoothed: int, reach: int) -> tuple[Floats, Floats]:
    """Smoothed speeds [F, n], and heights [F, n] above the lowest point nearby, by the filters of NumPy and SciPy."""
    speeds = np.linalg.norm(np.gradient(paths, step, axis=0), axis=-1)
    lowest = minimum_filter1d(paths[..., 1], reach, axis=0, mode="nearest")
    return uniform_filter1d(speeds, smoothed, axis=0, mode="nearest"), paths[..., 1] - lowest


def increasing_coefficients(design: Floats, y: Floats, floor: Floats) -> Floats:
    """Least squares with increments of at least `floor`: SciPy solves for the first value and the increments."""
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


def ring_cost(distances: Floats, wound: Sequence[int], pace: float, steadiness: float) -> float:
    """The cost of one path round a ring: each frame costs the mean of the cells that it passes, and for its pace."""
    cells = distances.shape[1]
    total = float(distances[0, wound[0] % cells])
    for frame, (before, here) in enumerate(itertools.pairwise(wound), 1):
        passed = range(before + 1, here + 1) if here > before else [here]
        total += float(np.mean([distances[frame, cell % cells] for cell in passed]))
        total += steadiness * (here - before - pace) ** 2
    return total


def best_ring_cost(distances: Floats, pace: float, steadiness: float, most_advance: int, most_zero: int) -> float:
    """The least cost of any allowed path round a ring, by trying every path."""
    frames, cells = distances.shape
    best = math.inf
    for start in range(cells):
        for steps in itertools.product(range(most_advance + 1), repeat=frames - 1):
            rests = max((len(list(run)) for step, run in itertools.groupby(steps) if step == 0), default=0)
            if rests <= most_zero:
                wound = [start, *(start + np.cumsum(steps)).tolist()]
                best = min(best, ring_cost(distances, wound, pace, steadiness))
    return best


def pose(
    bank: Bank,
    locomotion: str,
    time: float,
    action: str,
    start: float,
    method: str,
    posture: str,
    cycles: int = 0,
    hands: str | None = None,
) -> tuple[Floats, Floats]:
    """One character's root position [3] and local rotations [J, 4], from the bank's clips in their editable form."""
    entry_l, entry_u = bank.clip(locomotion), bank.clip(action)
    if entry_u.stretches and method == "splice":
        return hybrid_pose(bank, locomotion, time, action, start, posture, cycles, hands)
    pelvis, upper = bank.roles.pelvis, bank.skeleton.subtree(bank.roles.pelvis)

    def phase_between(clip: str, frame: float) -> float:
        own = bank.phase(clip)
        return float(np.interp(frame, np.arange(len(own)), own))

    frame_l = time * entry_l.rate
    root, rotations = (sampled[0] for sampled in bank.motion(locomotion).sampled([frame_l]))
    if method == "none":
        wear(bank, hands, locomotion, frame_l, rotations)
        return root, rotations
    if method == "naive":
        seconds = start + time
        frame_u = (seconds if seconds <= entry_u.duration else seconds % entry_u.duration) * entry_u.rate
    elif entry_u.stands:
        stride = frames_in_loop(bank, locomotion) / entry_l.loop / entry_l.rate if entry_l.loop else 0.0
        frame_u = own_frame(bank, action, max(start + time + cycles * stride, 0.0))
    else:
        phase = phase_between(locomotion, frame_l)
        phase += math.ceil(phase_between(action, start * entry_u.rate) - entry_l.first_phase - 1e-3) + cycles
        while phase > entry_u.last_phase and entry_u.loop > 0:
            phase -= entry_u.loop
        frame_u = float(np.interp(phase, bank.phase(action, seam=True), np.arange(entry_u.row_count)))
    pelvis_l, own = rotations[pelvis].copy(), rotations.copy()
    rotations[upper] = bank.motion(action, seam=True).sampled([frame_u])[1][0, upper]
    wear(bank, hands, action, frame_u, rotations)
    if method == "naive":
        return root, rotations
    if entry_u.stands and posture == "relative":
        return root, laid_on(
            bank, own, rotation_between(bank.torso(locomotion).frames, frame_l), action, frame_u, rotations
        )
    torso_l, torso_u = bank.torso(locomotion), bank.torso(action, seam=True)
    clouds = vectors_between(torso_l.clouds, frame_l), vectors_between(torso_u.clouds, frame_u)
    turned = quaternion.multiply(pelvis_l, best_rotation(*clouds))
    turn = quaternion.IDENTITY
    if posture == "absolute":
        turn = best_rotation(bank.posture(action), bank.posture(locomotion))
    elif posture == "relative":
        theirs, own = rotation_between(torso_u.offsets, frame_u), rotation_between(torso_l.offsets, frame_l)
        turn = quaternion.multiply(theirs, quaternion.conjugate(own))
    frame = rotation_between(torso_l.frames, frame_l)
    world_turn = quaternion.multiply(quaternion.multiply(frame, turn), quaternion.conjugate(frame))
    rotations[pelvis] = quaternion.multiply(world_turn, turned)
    return root, rotations


def hybrid_pose(
    bank: Bank,
    locomotion: str,
    time: float,
    action: str,
    start: float,
    posture: str,
    cycles: int,
    hands: str | None,
) -> tuple[Floats, Floats]:
    """As `pose`, of a hybrid: plays its stretches one after another, until the one that is shown."""
    entry_l, seam = bank.clip(locomotion), bool(bank.clip(locomotion).loop)
    phase_l, lasting = bank.phase(locomotion, seam=seam), 0.0
    if seam:
        lasting = frames_in_loop(bank, locomotion) / entry_l.rate
    rows = np.arange(len(phase_l))
    cycles = cycles if seam else 0
    played = max(time + cycles * lasting / entry_l.loop, 0.0) if seam else time
    last = (len(phase_l) - 1) / entry_l.rate

    def phase_after(seconds: float) -> float:
        rounds = 0
        while seam and seconds > last:
            seconds, rounds = seconds - lasting, rounds + 1
        return float(np.interp(seconds * entry_l.rate, rows, phase_l)) + rounds * entry_l.loop

    def seconds_until(phase: float) -> float:
        rounds = 0
        while phase > phase_l[-1]:
            if not seam:
                return math.inf
            phase, rounds = phase - entry_l.loop, rounds + 1
        return float(np.interp(phase, phase_l, rows)) / entry_l.rate + rounds * lasting

    stretches = [bank.clip(name) for name in bank.clip(action).stretches]
    while len(stretches) > 1 and start * stretches[0].rate >= stretches[0].leaves - stretches[0].enters:
        start -= (stretches[0].leaves - stretches[0].enters) / stretches[0].rate
        stretches.pop(0)
    begun, shown = 0.0, list[tuple[str, float, int]]()
    for number, one in enumerate(stretches):
        frame, phases = one.enters + (0.0 if number else start * one.rate), bank.phase(one.name, seam=True)
        if one.stands:
            ends = begun + (one.leaves - frame) / one.rate
            shown.append((one.name, frame / one.rate - begun, cycles))
        else:
            begins, leaves = np.interp([frame, one.leaves], np.arange(one.row_count), phases)
            shift = math.ceil(begins - phase_after(begun) - (0.25 if number else 1e-3))
            shift += 1 if number and phase_after(begun) + shift < phases[0] else 0
            ends = seconds_until(leaves - shift)
            shown.append((one.name, 0.0, int(shift) + cycles - math.ceil(phases[0] - entry_l.first_phase - 1e-3)))
        ends = max(ends, begun + 0.4)
        if played < ends:
            break
        begun = ends if one is not stretches[-1] else begun
    poses = [pose(bank, locomotion, time, name, at, "splice", posture, by, hands) for name, at, by in shown[-2:]]
    root, rotations = poses[-1]
    t = min((played - begun) / 0.4, 1.0)
    if len(poses) == 1 or t == 1.0:
        return root, rotations
    share = t * t * (3.0 - 2.0 * t)
    near = np.where(np.sum(rotations * poses[0][1], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return root, quaternion.normalise(share * rotations + (1.0 - share) * near * poses[0][1])


def own_frame(bank: Bank, clip: str, seconds: float) -> float:
    """A clip's frame after so many seconds at its own speed: it goes on by its loop, or holds its last frame."""
    entry = bank.clip(clip)
    frame, last = seconds * entry.rate, entry.row_count - 1.0
    while entry.loop > 0 and frame > last:
        frame -= frames_in_loop(bank, clip)
    return min(frame, last)


def frames_in_loop(bank: Bank, clip: str) -> float:
    """How many frames a clip with a loop goes back at its last row."""
    phase = bank.phase(clip, seam=True)
    return len(phase) - 1.0 - float(np.interp(phase[-1] - bank.clip(clip).loop, phase, np.arange(len(phase))))


def laid_on(bank: Bank, own: Floats, frame_l: Floats, action: str, at: float, posed: Floats) -> Floats:
    """Lays a standing action's rotations `posed` [J, 4], at its frame `at`, on a locomotion's `own` [J, 4].

    frame_l: [4] the locomotion's posture frame.
    """
    standing, pelvis = bank.standing(action, seam=True), bank.roles.pelvis
    assert standing is not None
    usage, parts = vectors_between(standing.usage, at), part_of_joint(bank.skeleton, bank.roles)
    rotations = own.copy()
    for joint in bank.skeleton.subtree(pelvis)[1:]:
        if standing.parts >> parts[joint] & 1:
            departure = quaternion.multiply(quaternion.conjugate(standing.stance[joint]), posed[joint])
            added, share = quaternion.multiply(own[joint], departure), usage[parts[joint]]
            mean = (1.0 - share) * added + share * posed[joint] * (1.0 if added @ posed[joint] >= 0.0 else -1.0)
            rotations[joint] = mean / np.linalg.norm(mean)
    if standing.parts & TRUNK:
        turn = quaternion.multiply(frame_l, rotation_between(standing.turns, at))
        turn = quaternion.multiply(turn, quaternion.conjugate(frame_l))
        rotations[pelvis] = quaternion.multiply(turn, own[pelvis])
    return rotations


def wear(bank: Bank, hands: str | None, body: str, frame: float, rotations: Floats) -> None:
    """Lays hands over the rotations [J, 4] of a body at a real-valued frame."""
    if hands is not None:
        rotations[list(bank.layout.hands.joints)] = rotation_between(bank.hand_motion(hands, body), frame)


def vectors_between(vectors: Floats, frame: float) -> Floats:
    """Vectors [F, ...] at a real-valued frame, held at both ends."""
    before, after, t = quaternion.neighbours(len(vectors), [frame])
    return np.asarray(vectors[before[0]] + t[0] * (vectors[after[0]] - vectors[before[0]]))


def rotation_between(rotations: Floats, frame: float) -> Floats:
    """Rotations [F, ..., 4] at a real-valued frame, held at both ends."""
    before, after, t = quaternion.neighbours(len(rotations), [frame])
    return quaternion.slerp(rotations[before[0]], rotations[after[0]], np.full(rotations.shape[1:-1], t[0]))


def gap(target: Floats, source: Floats) -> float:
    """How clearly one rotation is the best: the difference of Horn's two largest eigenvalues over the largest.

    It is 2 (s2 +- s3) / (s1 + s2 +- s3), with the singular values of the correlation; minus if it mirrors.
    """
    correlation = target.T @ source
    first, second, third = np.linalg.svd(correlation)[1] * [1.0, 1.0, np.sign(np.linalg.det(correlation))]
    return float(2.0 * (second + third) / (first + second + third)) if first > 0.0 else 0.0


def best_rotation(target: Floats, source: Floats) -> Floats:
    """Horn's rotation; the identity where none is clearly the best."""
    return horn_rotation(target, source) if gap(target, source) >= LEAST_GAP else quaternion.IDENTITY


def followed(bank: Bank, splice: Clip, locomotion: str, action: str, time_constant: float) -> Clip:
    """Turns a splice with posture `off` to the action's posture, by a running mean of its own."""
    torso = measure_torso(splice, bank.roles)
    mean, share = bank.posture(locomotion).copy(), 1.0 - math.exp(-1.0 / (splice.rate * time_constant))
    turns = []
    for shoulders in torso.upright[:, -2:]:
        mean += share * (shoulders - mean)
        turns.append(horn_rotation(bank.posture(action), mean))
    return transfer_posture(splice, torso, np.array(turns), bank.roles)
