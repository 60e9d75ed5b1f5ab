"""Large inputs of the most wasteful shapes: `python -m tests.hardening.fuzz.bulk [DOOR ...] [--size 4]`.

Small inputs show what any input may take, 64 MiB; these show what each byte may. Each is as large as `--size` says, and
must pass its door, or be refused by a typed error, within 64 MiB and 64 times its size of memory. Prints what each came
to, and exits with 1 if one took more.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any

import msgpack
import typer

from bench.hostile.good_files import good_files
from motionsplice.cli import run
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.gltf.document import glb
from motionsplice.runtime.format.manifest import MANIFEST
from tests.hardening.fuzz.banks import manifest_of, small_body
from tests.hardening.fuzz.door import Files, door_of
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.harness import Visitor

MIB = 2**20
JOINT = "JOINT j{}\n{{\nOFFSET 0 0 0\nCHANNELS 0\n"
BONE = "begin\nid {0}\nname b{0}\ndirection 0 1 0\nlength 1\naxis 0 0 0 XYZ\nend\n"


def _times(text: str, size: int) -> str:
    return text * (size // len(text))


def _numbered(text: str, size: int) -> str:
    return "".join(text.format(number) for number in range(size // (len(text) + 4)))


def _bvh(size: int) -> Iterator[tuple[str, Files]]:
    sound = door_of("bvh").make(Draw(b""))["clip.bvh"].decode()
    head, _, motion = sound.partition("MOTION\n")
    body, end = head.rstrip()[:-1], "MOTION\nFrames: 1\nFrame Time: 0.03\n0\n"
    width = len(motion.splitlines()[2].split())
    yield "joints side by side", {"clip.bvh": (body + _numbered(JOINT + "}}\n", size) + "}\n" + end).encode()}
    count = size // len(JOINT)
    chain = "".join(JOINT.format(number) for number in range(count)) + "}\n" * count
    yield "a chain of joints", {"clip.bvh": (body + chain + "}\n" + end).encode()}
    rows = _times("0 " * (width - 1) + "0\n", size)
    count = rows.count("\n")
    yield "frames of zeros", {"clip.bvh": f"{head}MOTION\nFrames: {count}\nFrame Time: 0.03\n{rows}".encode()}
    rows = _times("0\n", size)
    yield "a number in each line", {"clip.bvh": f"{head}MOTION\nFrames: 9\nFrame Time: 0.03\n{rows}".encode()}
    ends = "End Site\n{\nOFFSET 0 0 0\n}\n"
    for name, piece in (("braces", "{"), ("empty lines", "\n"), ("words", "a "), ("end sites", ends)):
        yield name, {"clip.bvh": (body + _times(piece, size)).encode()}


def _acclaim(size: int) -> Iterator[tuple[str, Files]]:
    sound = dict(door_of("acclaim").make(Draw(b"")))
    skeleton = sound["clip.asf"].decode()
    frames = _numbered("{}\nroot 0 0 0 0 0 0\n", size)
    yield "frames of few values", sound | {"clip.amc": b":DEGREES\n" + frames.encode()}
    yield "words", sound | {"clip.amc": b":DEGREES\n1\n" + _times("a ", size).encode()}
    yield "lines of a word", sound | {"clip.amc": b":DEGREES\n1\n" + _times("a\n", size).encode()}
    yield "bones", sound | {"clip.asf": skeleton.replace(":hierarchy", _numbered(BONE, size) + ":hierarchy").encode()}
    yield "sections", sound | {"clip.asf": (skeleton + _numbered(":s{}\n", size)).encode()}


def _gltf(size: int) -> Iterator[tuple[str, Files]]:
    (data,) = good_files("gltf", None)[0].files.values()
    document, binary = read_document(data)
    for name, one in (("empty lists", []), ("empty maps", {}), ("small numbers", 1), ("texts", "a"), ("lists", [[]])):
        few = json.dumps(one)
        yield name, {"clip.glb": glb(document | {"extras": [one] * (size // (len(few) + 1))}, binary)}
    for key, item in (("nodes", {}), ("accessors", {"count": 1}), ("animations", {"channels": [], "samplers": []})):
        many: list[Any] = [*document[key], *[item] * (size // (len(json.dumps(item)) + 1))]
        yield f"more {key}", {"clip.glb": glb(document | {key: many}, binary)}
    (animation,) = document["animations"]
    channels = animation["channels"] * (size // len(json.dumps(animation["channels"])))
    yield "more channels", {"clip.glb": glb(document | {"animations": [animation | {"channels": channels}]}, binary)}
    yield "a large chunk", {"clip.glb": glb(document, binary + bytes(size))}


def _toml_files(size: int) -> Iterator[tuple[str, Files]]:
    sound = dict(door_of("toml_files").make(Draw(b"")))
    for name, text in (
        ("empty lists", f"a = [{_times('[],', size)}]"),
        ("numbers", f"a = [{_times('1,', size)}]"),
        ("tables in tables", _numbered("[{}.a.b.c.d.e.f.g]\n", size)),
        ("few tables in tables", _numbered("[{}.a.b.c.d.e.f.g]" + " " * 100 + "\n", size)),
        ("keys", _numbered("a{} = 1\n", size)),
        ("tables", _numbered("[a{}]\n", size)),
        ("a dotted key", f"{_times('a.', 4000)}a = 1"),
        ("a text", f"a = '{'x' * size}'"),
    ):
        yield name, sound | {"clips.toml": text.encode()}


def _manifest(size: int) -> Iterator[tuple[str, Files]]:
    body = small_body()
    for name, one in (("empty lists", []), ("empty maps", {}), ("nothing", None), ("numbers", 1), ("texts", "")):
        for key in ("extra", "clips"):
            many: list[Any] = [one] * (size // len(msgpack.packb(one)))
            yield f"{name} in {key}", {MANIFEST: manifest_of(msgpack.packb(body | {key: many}))}
    clips = body["clips"] * (size // len(msgpack.packb(body["clips"])))
    yield "more clips", {MANIFEST: manifest_of(msgpack.packb(body | {"clips": clips}))}
    names = [f"{number}" for number in range(size // 6)]
    joints = {"names": names, "parents": [-1, *range(len(names) - 1)], "offsets": []}
    yield "more joints", {MANIFEST: manifest_of(msgpack.packb(body | {"skeleton": body["skeleton"] | joints}))}


def _batches(size: int) -> Iterator[tuple[str, Files]]:
    for name, one in (("numbers", "1,"), ("empty lists", "[],"), ("empty maps", "{},"), ("texts", '"",')):
        text = f'{{"clips": ["clip 0"], "time": [{_times(one, size)[:-1]}], "locomotion": []}}'
        yield f"{name} in JSON", {"json": text.encode()}
    for name, packed in (("numbers", b"\1"), ("empty lists", b"\x90"), ("texts", b"\xa0"), ("blobs", b"\xc4\0")):
        count = size // len(packed)
        body = b"\x81" + msgpack.packb("clips") + b"\xdd" + count.to_bytes(4, "big") + packed * count
        yield f"{name} in MessagePack", {"msgpack": body}
    columns = {"clips": ["clip 0"], "locomotion": bytes(size // 3), "time": bytes(2 * size // 3)}
    yield "columns in MessagePack", {"msgpack": msgpack.packb(columns)}


SHAPES: Mapping[str, Callable[[int], Iterator[tuple[str, Files]]]] = {
    "bvh": _bvh,
    "acclaim": _acclaim,
    "gltf": _gltf,
    "toml_files": _toml_files,
    "manifest": _manifest,
    "batches": _batches,
}


def _maker(files: Files) -> Callable[[Draw], Files]:
    return lambda draw: files


def main(
    doors: Annotated[list[str] | None, typer.Argument(help=f"{', '.join(SHAPES)}; all without it")] = None,
    size: Annotated[int, typer.Option(min=1, help="MiB of an input")] = 4,
) -> None:
    """Sends large inputs through doors."""
    bad = 0
    for name in doors or SHAPES:
        for shape, files in SHAPES[name](size * MIB):
            visitor = Visitor(door_of(name))
            visitor.door = replace(visitor.door, make=_maker(files))
            began = time.process_time()
            visitor.visit(b"")
            visitor.close()
            ((outcome, _),) = visitor.tally.outcomes.items()
            is_bad = any(not one.startswith("slow") for one in visitor.tally.bad) or "MemoryError" in outcome
            bad += is_bad
            print(f"{'FOUND ' * is_bad}{name}, {shape}: {time.process_time() - began:.1f} s, {outcome}", flush=True)
    sys.exit(bool(bad))


if __name__ == "__main__":
    run(lambda: typer.run(main))
