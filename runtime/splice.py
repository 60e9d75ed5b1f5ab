"""The record of a splice."""

from __future__ import annotations

from dataclasses import dataclass

from motionsplice.runtime.requests import Method, Posture


@dataclass(frozen=True, init=False)
class Splice:
    """The upper body of one clip on the lower body of another.

    The fields have the names of an HTTP request's parameters, of which those that are None are left out.

    Attributes:
        locomotion: Name of the clip that gives the root and the lower body.
        action: Name of the clip that gives the upper body; None plays the locomotion alone.
        start: Seconds into the action: its earliest frame. The action begins at the first frame from there on that is
            in step with the locomotion's first frame; an action captured standing begins at this very frame.
        method: `splice`, `naive` (plain replacement of the upper body) or `none` (the locomotion alone).
        posture: How the action's posture is kept: `relative`, `absolute`, `running` (needs a Memory) or `off`
            (docs/method.md).
        hands: Name of the hands clip to lay on the clip that gives the upper body; None keeps this clip's own hands.
    """

    locomotion: str
    action: str | None
    start: float
    method: Method
    posture: Posture
    hands: str | None

    def __init__(
        self,
        locomotion: str,
        action: str | None = None,
        *,
        start: float = 0.0,
        method: Method = "splice",
        posture: Posture = "relative",
        hands: str | None = None,
    ) -> None:
        fields = vars(self)  # the `__init__` of a frozen dataclass calls a function for each field: three times as long
        fields["locomotion"], fields["action"], fields["start"] = locomotion, action, start
        fields["method"], fields["posture"], fields["hands"] = method, posture, hands

    @property
    def name(self) -> str:
        """Name of the result: `walk+wave`, or `walk` without an action."""
        return self.locomotion if self.action is None else f"{self.locomotion}+{self.action}"
