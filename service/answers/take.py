"""POST /v1/take: what a character does when it is given commands at certain frames, computed at once."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from starlette.types import Receive, Scope

from motionsplice.motion.axes import Axes
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import did_you_mean
from motionsplice.runtime.characters.moments import action_times, phases
from motionsplice.runtime.characters.state import EVENT_NAMES
from motionsplice.service.answers.answer import Answer, joined
from motionsplice.service.answers.body import json_map, media_type, too_large, whole_body
from motionsplice.service.answers.files import FILES, check_encoding, file_answer, written
from motionsplice.service.answers.rig import OnRig, decoded, room_for_rig, without_rig
from motionsplice.service.characters.commands import NEEDED, Command, checked
from motionsplice.service.characters.scene import Scene
from motionsplice.service.problems import LimitError, RequestError
from motionsplice.service.serving import Edition
from motionsplice.service.shared import Shared
from motionsplice.service.wire.encoding import Arrays, Encoding
from motionsplice.service.wire.messages import FORMS, JSON, frame_fields
from motionsplice.service.wire.parameters import HOW, encoding, format_parameter
from motionsplice.service.wire.query import Query

TAKE = Query(*HOW, format_parameter("json", "msgpack", *FILES))
KEYS = ("rate", "frames", "commands", "rig")
COMMANDS = tuple(name for name in NEEDED if name not in ("remove", "set", "send"))
ID = 0  # of the character
BLOCK = 32  # frames after which other requests are served


async def take(shared: Shared, scope: Scope, receive: Receive) -> Answer:
    """Returns the frames as one map, or as a file of the motion. Raises MotionError."""
    values, settings = TAKE.read(scope["query_string"]), shared.settings
    media_type(scope, JSON)
    how, form = encoding(values), values["format"]
    if form in FILES:
        check_encoding(form, how)
    most = settings.max_message + room_for_rig(settings.max_rig)
    body, text = without_rig(await whole_body(scope, receive, most, settings.request_seconds, shared.arrivals))
    if len(body) > settings.max_message:
        raise too_large(settings.max_message)
    asked = Take.parse(body, how.axes, settings.max_frames)
    rig = None if text is None else decoded(text, settings.max_rig)
    if rig is not None and form in FILES and form != "glb":
        raise RequestError(f"format: a rig cannot be written as {form}", mend="Ask for json, msgpack or glb")
    with shared.admitted():
        played = Played(shared.serving.edition, asked)
        for first in range(0, asked.frames, BLOCK):
            played.play(first, min(first + BLOCK, asked.frames))
            await asyncio.sleep(0)
        fields: dict[str, Any] = {}
        arrays: Arrays = {}
        if rig is not None:
            async with shared.retargeting:
                on_rig = await asyncio.to_thread(OnRig.of, rig, played.clip, played.edition.bank.roles)
                if form in FILES:
                    return file_answer(await asyncio.to_thread(on_rig.file), form, *asked.clips)
                fields, arrays = await asyncio.to_thread(on_rig.message)
        elif form in FILES:
            file = await joined(written(played.clip, played.edition.bank.roles, form))
            return file_answer(file, form, *asked.clips)
    return played.answer(how, form, fields, arrays)


@dataclass(frozen=True)
class Take:
    """A request for a take: a number of frames of one character, and its commands by frame."""

    rate: float
    frames: int
    commands: Mapping[int, list[Command]]

    @classmethod
    def parse(cls, body: bytes, axes: Axes, most: int) -> Self:
        """Parses a map. Raises RequestError, or LimitError for more than `most` frames."""
        values = json_map(body)
        for key in values:
            if key not in KEYS:
                raise RequestError(f"unknown key {key[:40]!r}", mend=did_you_mean(key[:40], KEYS))
        if values.get("rig", "") != "":  # a text of base64 was taken out before
            raise RequestError("rig: expected the bytes of a GLB file as text in base64")
        rate, frames, listed = values.get("rate", 60.0), values.get("frames"), values.get("commands")
        if type(rate) not in (int, float) or not 1.0 <= rate <= 1000.0:
            raise RequestError(f"rate: expected frames per second from 1 to 1000, found {rate!r:.40}")
        if type(frames) is not int or frames < 1:
            raise RequestError(f"frames: expected a whole number from 1, found {frames!r:.40}")
        if frames > most:
            raise LimitError(f"frames: {frames} are more than {most}", mend="Ask for fewer, or for a lower rate")
        return cls(float(rate), frames, _commands(listed, frames, axes))

    @property
    def clips(self) -> list[str]:
        """The names of what is played, in order."""
        names = []
        for command in (one for at in sorted(self.commands) for one in self.commands[at]):
            for key in ("locomotion", "action", "hands"):
                value = command.values.get(key) or ()
                names += [value] if isinstance(value, str) else list(value)
        return list(dict.fromkeys(names))


def _commands(listed: Any, frames: int, axes: Axes) -> dict[int, list[Command]]:
    if not isinstance(listed, list) or not all(isinstance(one, dict) for one in listed):
        raise RequestError("commands: expected a list of maps")
    fields = []
    for number, one in enumerate(listed):
        place, at, do = f"command {number}", one.get("at", 0), one.get("do")
        if type(at) is not int or not 0 <= at < frames:
            raise RequestError(f"at: expected a frame from 0 to {frames - 1}, found {at!r:.40}", place=place)
        if do not in COMMANDS:
            mend = did_you_mean(str(do)[:40], COMMANDS)
            raise RequestError(f"do: a take has no command {do!r:.40}", place=place, mend=mend)
        if "id" in one:
            raise RequestError("id: a take has one character", place=place, mend="Leave it out")
        if (do == "create") != (number == 0) or (number == 0 and at > 0):
            raise RequestError("do: the first command, and no other, must be create, at frame 0", place=place)
        fields.append({key: value for key, value in one.items() if key != "at"} | {"id": ID})
    if not fields:
        raise RequestError("commands: the list is empty", mend="Begin with create")
    commands: dict[int, list[Command]] = {}
    for one, command in zip(listed, checked(fields, axes), strict=True):
        commands.setdefault(one.get("at", 0), []).append(command)
    return commands


class Played:
    """A take as far as it was played.

    Attributes:
        edition: The edition that is played.
        poses: F poses.
        phases: [F] float32, phase of the locomotion in strides.
        times: [F] float32, seconds into the action; NaN without one.
        events: What happened: the frame that first shows it, the event, and the clip of an action.
    """

    def __init__(self, edition: Edition, take: Take) -> None:
        self.edition = edition
        self.poses = edition.evaluator.poses(take.frames)
        self.phases = np.empty(take.frames, np.float32)
        self.times = np.empty(take.frames, np.float32)
        self.events: list[dict[str, Any]] = []
        self._rates = np.array([clip.rate for clip in edition.bank.numbered])
        self._begins = np.array(
            [edition.bank.begin_of(clip.name) - clip.enters / clip.rate for clip in edition.bank.numbered]
        )
        self._take = take
        self._scene = Scene(edition, take.rate, 1)
        self._scene.subscribe(tuple(EVENT_NAMES.values()))

    def play(self, first: int, end: int) -> None:
        """Plays the next frames. Raises MotionError about a command."""
        states = []
        for frame in range(first, end):
            if frame:
                for event in self._scene.advance():
                    del event["ids"]
                    self.events.append({"frame": frame, **event})
            for command in self._take.commands.get(frame, ()):
                self._scene.do(command)
            self._scene.evaluate(self.poses.rows(frame, frame + 1))
            states.append(self._scene.characters.state[0].copy())
        rows = np.array(states)
        self.phases[first:end] = phases(rows)
        self.times[first:end] = action_times(rows, self._rates, self._begins)

    @property
    def clip(self) -> Clip:
        """The frames as a clip, named after the clips that it plays."""
        return self.poses.clip("+".join(self._take.clips), self.edition.bank.skeleton, self._take.rate)

    def answer(self, how: Encoding, form: str, rig: dict[str, Any], of_rig: Arrays) -> Answer:
        """Returns the answer as a map, with the fields and arrays of a rig if there is one."""
        moments = {"phases": self.phases, "action_times": self.times}
        # in an order that `layout` can align
        arrays = {**moments, **how.arrays(self.edition.evaluator, self.poses), **of_rig}
        media_type, write = FORMS[form]
        fields = {**frame_fields(0, self._take.frames, self._take.rate), "events": self.events}
        return Answer(write(self.edition.bank.digest, fields | ({"rig": rig} if rig else {}), arrays), media_type)
