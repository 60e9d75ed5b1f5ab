from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_message_builder import OscMessageBuilder

from motionsplice.sending.osc import bundled, message

FLOATS = st.floats(width=32, allow_nan=False)
INTEGERS = st.integers(-(2**31), 2**31 - 1)
ARGUMENTS = st.lists(st.one_of(st.text(st.characters(exclude_characters="\0", codec="utf-8")), INTEGERS, FLOATS))


@given(ARGUMENTS)
def test_a_message_has_the_bytes_that_python_osc_writes(arguments: list[str | int | float]) -> None:
    builder = OscMessageBuilder("/VMC/Ext/T")
    for argument in arguments:
        builder.add_arg(argument, "s" if isinstance(argument, str) else "i" if isinstance(argument, int) else "f")
    assert message("/VMC/Ext/T", *arguments) == builder.build().dgram


@given(st.lists(ARGUMENTS, min_size=1, max_size=30), st.integers(64, 400))
def test_bundles_hold_all_messages_in_order_and_are_no_larger_than_asked(lists: list[list[str]], most: int) -> None:
    messages = [message(f"/{number}", *arguments) for number, arguments in enumerate(lists)]
    messages = [content for content in messages if 16 + 4 + len(content) <= most] or [message("/")]
    bundles, ends = bundled(messages, most)
    assert max(map(len, bundles)) <= most
    assert [content.dgram for bundle in bundles for content in OscBundle(bundle)] == messages
    everything = b"".join(bundles)
    assert [everything[end - len(content) : end] for end, content in zip(ends, messages, strict=True)] == messages


def test_a_bundle_is_full_before_the_next_begins() -> None:
    messages = [message("/abcdefg", 1.0)] * 10  # 20 bytes, and 4 for the length
    bundles, _ = bundled(messages, 16 + 3 * 24)
    assert [len(bundle) for bundle in bundles] == [88, 88, 88, 40]
