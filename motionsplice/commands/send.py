"""`motionsplice send`: plays a character in real time to programs that receive VMC or JSON Live Link.

The evaluator is imported when it is needed, so that a misspelt clip name or address is reported at once.
"""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from motionsplice.commands.outputs import print_sentences
from motionsplice.motion.errors import SettingsError
from motionsplice.sending.receiver import PORTS, Receiver
from motionsplice.sending.schedule import Schedule

if TYPE_CHECKING:
    from motionsplice.sending.packing import Packer
    from motionsplice.sending.receiver import Kind

console = Console(emoji=False)


def register(app: typer.Typer) -> None:
    app.command(
        "send",
        epilog="Example: [bold]motionsplice send bank --locomotion walk --action wave --vmc 127.0.0.1 --loop[/bold]",
    )(send_command)


def send_command(
    bank: Annotated[Path, typer.Argument(help="A bank, as `precompute` wrote it.")],
    locomotion: Annotated[str, typer.Option(help="The clip that gives the root and the lower body.")],
    action: Annotated[
        str | None, typer.Option(help="The clip that gives the upper body; without it, the locomotion alone.")
    ] = None,
    vmc: Annotated[
        str | None, typer.Option(metavar="HOST[:PORT]", help="A receiver of VMC; its port is 39539 if not given.")
    ] = None,
    livelink: Annotated[
        str | None,
        typer.Option(metavar="HOST[:PORT]", help="A receiver of JSON Live Link; its port is 54321 if not given."),
    ] = None,
    rate: Annotated[float, typer.Option(help="Frames per second, 1 to 240.")] = 60.0,
    loop: Annotated[bool, typer.Option("--loop", help="Go on at the end of the locomotion, until Ctrl-C.")] = False,
) -> None:
    """Play a character in real time to programs that receive VMC or JSON Live Link."""
    if vmc is None and livelink is None:
        raise SettingsError("no receiver is given", mend="Add --vmc HOST:PORT or --livelink HOST:PORT, or both")
    from motionsplice.runtime.bank import Bank

    opened = Bank.open(bank)
    entry = opened.clip(locomotion)
    if action is not None:
        opened.clip(action)
    schedule = Schedule(rate, None if loop else entry.duration)
    from motionsplice.sending.packing import packer
    from motionsplice.sending.performance import perform

    with ExitStack() as stack:
        outputs: list[tuple[Packer, Receiver]] = []
        addresses: dict[Kind, str | None] = {"vmc": vmc, "livelink": livelink}
        for kind, address in addresses.items():
            if address is not None:
                receiver = stack.enter_context(closing(Receiver(address, PORTS[kind], f"--{kind}")))
                outputs.append((packer(kind, opened), receiver))
        what = f"{locomotion!r} with {action!r}" if action else repr(locomotion)
        names = " and ".join(receiver.name for _, receiver in outputs)
        text = f"Sending {what} to {names}, {rate:g} frames per second (stop with Ctrl-C)"
        console.print(text, highlight=False, soft_wrap=True, markup=False)
        refused: set[Receiver] = set()
        try:
            for frame in perform(opened, locomotion, action, schedule):
                for protocol, receiver in outputs:
                    if receiver.send(protocol.datagrams(*frame)) and receiver not in refused:
                        refused.add(receiver)
                        note = f"{receiver.name}: {receiver.reason}. Does the receiver run? Sending goes on."
                        print_sentences(console, "yellow", [note])
        except KeyboardInterrupt:
            console.print()  # behind the ^C
        _report(schedule, [receiver for _, receiver in outputs])


def _report(schedule: Schedule, receivers: list[Receiver]) -> None:
    """Prints what was sent, and how steadily."""
    mean = 1000.0 * schedule.late / max(schedule.made, 1)
    lateness = f"late by {mean:.2f} ms on average, {1000.0 * schedule.latest:.2f} ms at most"
    console.print(f"{schedule.made} frames, {schedule.left_out} left out, {lateness}", highlight=False)
    for receiver in receivers:
        unsent = f", {receiver.unsent} not sent: {receiver.reason}" if receiver.unsent else ""
        console.print(f"{receiver.name}: {receiver.sent} datagrams{unsent}", highlight=False, markup=False)
