"""The errors for requests that an evaluator refuses."""

from __future__ import annotations

from typing import Any

from motionsplice.motion.errors import SettingsError, TimeRangeError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import NONE
from motionsplice.runtime.requests import METHODS, POSTURES, Memory, Poses, Requests, time_fault


def check_room(requests: Requests, out: Poses, memory: Memory | None, joints: int) -> None:
    """Raises SettingsError if poses or memory have another size than the requests, or poses other joints."""
    count = len(requests.records)
    if out.flat.shape != (count, 4 * joints):
        found = f"{len(out.flat)} poses of {out.rotations.shape[1]} joints"
        raise SettingsError(
            f"{count} requests need {count} poses of {joints} joints, found room for {found}",
            mend="Create the poses with Evaluator.poses(len(requests))",
        )
    if memory is not None and len(memory.state) not in (1, count):
        raise SettingsError(
            f"{count} requests need a memory of {count} characters or of 1, found {len(memory.state)}",
            mend="Create it with Memory.begin(len(requests), rate); 1 if all requests are about one character",
        )


def fault_of(bank: Bank, arrays: BankArrays, requests: Requests, character: int) -> SettingsError | TimeRangeError:
    """Returns the error for a request that `first_at_fault` found invalid."""
    request, clips = requests.records[character], bank.numbered
    place = f"character {character}" if len(requests.records) > 1 else ""
    for label, number, top in (
        ("locomotion", request["locomotion"], len(clips)),
        ("action", request["action"], len(clips)),
        ("method", request["method"], len(METHODS)),
        ("posture", request["posture"], len(POSTURES)),
    ):
        if not 0 <= number < top:
            return SettingsError(f"{label} number {number} lies outside 0 to {top - 1}", place=place)
    if (hands_fault := _fault_of_hands(bank, arrays, request, place)) is not None:
        return hands_fault
    for label, clip in (("time", clips[request["locomotion"]]), ("start", clips[request["action"]])):
        if (fault := time_fault(label, float(request[label]), clip, place)) is not None:
            return fault
    if request["posture"] != POSTURES["running"]:
        return SettingsError(f"posture number {request['posture']} is refused by `first_at_fault`", place=place)
    return SettingsError(
        "posture 'running' is a mean over earlier frames and needs a memory of them",
        place=place,
        mend="Evaluate frame by frame with a Memory, or ask for a whole clip",
    )


def _fault_of_hands(bank: Bank, arrays: BankArrays, request: Any, place: str) -> SettingsError | None:
    """Returns the error if the hands of a request are unknown or not aligned to its upper body, else None."""
    hands, count = int(request["hands"]) - 1, len(bank.hand_clips)
    if hands >= count:
        return SettingsError(f"hands number {hands + 1} lies outside 0 to {count}", place=place)
    upper = bank.numbered[request["locomotion" if request["method"] == NONE else "action"]].name
    if hands >= 0 and arrays.hand_rows[hands, bank.number(upper)] < 0:
        fault = bank.hands_not_aligned(bank.hand_clips[hands], upper)
        return SettingsError(fault.problem, place=place, mend=fault.mend)
    return None
