"""Calls every operation by the client that openapi-python-client has made, in the generator's own environment.

Arguments: the service's URL, its token, and a folder with the generated package, `batch.msgpack`, `hero.glb` and
`wave.bvh`. Writes binary answers there, and prints the names of the operations called.
"""

from __future__ import annotations

import base64
import importlib
import io
import json
import sys
from pathlib import Path
from typing import Any

URL, TOKEN, FOLDER = sys.argv[1], sys.argv[2], Path(sys.argv[3])
sys.path.insert(0, str(FOLDER))
generated: Any = importlib.import_module("motionsplice_client")
models: Any = importlib.import_module("motionsplice_client.models")
types: Any = importlib.import_module("motionsplice_client.types")
client = generated.AuthenticatedClient(base_url=URL, token=TOKEN, raise_on_unexpected_status=True)
called: set[str] = set()


def operation(tag: str, name: str) -> Any:
    called.add(name)
    return importlib.import_module(f"motionsplice_client.api.{tag}.{name}")


def call(tag: str, name: str, /, *path: str, **arguments: Any) -> Any:
    """Returns a successful answer, parsed."""
    answer = operation(tag, name).sync_detailed(*path, client=client, **arguments)
    assert answer.status_code < 300, answer.content
    return answer.parsed


def save(name: str, answer: Any) -> bytes:
    """Writes a binary answer to a file."""
    assert isinstance(answer, types.File)
    content: bytes = answer.payload.read()
    (FOLDER / name).write_bytes(content)
    return content


def upload(name: str) -> Any:
    return types.File(payload=io.BytesIO((FOLDER / name).read_bytes()))


server = call("bank", "get_server")
assert {axes.name for axes in server.axes} == set(models.Axes)
bank = call("bank", "get_bank")
assert bank.digest == server.bank
skeleton = call("bank", "get_skeleton", axes=models.Axes.UNITY)
assert len(skeleton.offsets) == len(skeleton.joints) == bank.joints
assert isinstance(skeleton.roles["pelvis"], str)
clips = call("bank", "get_clips")
walk = call("bank", "get_clip", "walk")
assert walk in clips
assert walk.contacts.left[0][0] < walk.contacts.left[0][1]
report = call("bank", "get_report")
assert report.bank == bank.digest
assert report.pairs[0].over_time["splice"]
assert report.pairs[0].worst.time >= 0.0
save("manifest.msgpack", call("bank", "get_manifest"))
save("lower.npy", call("bank", "get_table", "lower"))

splice = {"locomotion": "walk", "action": "wave", "method": models.Method.SPLICE, "posture": models.Posture.ABSOLUTE}
encoded = {"axes": models.Axes.UNREAL, "parts": models.Parts.BOTH, "encoding": models.Encoding.FLOAT32}
Format, SpliceFormat = models.Format, models.SpliceFormat
save("pose.msgpack", call("motion", "get_pose", **splice, **encoded, time=0.5, format_=Format.MSGPACK))
pose = save("pose.json", call("motion", "get_pose", **splice, **encoded, time=0.5))
assert len(models.Pose.from_dict(json.loads(pose)).rotations) == bank.joints
hoped = save("expectation.json", call("motion", "get_expectation", locomotion="walk", action="wave"))
expected = models.ExpectationAnswer.from_dict(json.loads(hoped)).expected
assert 0.0 < expected.error < expected.replaced
batch = models.Batch(clips=["walk", "wave"], locomotion=[0, 0], time=[0.5, 0.5], action=[1, -1])
batch.posture = models.BatchPosture.ABSOLUTE
save("poses.msgpack", call("motion", "post_poses", body=upload("batch.msgpack"), **encoded, format_=Format.MSGPACK))
poses = save("poses.json", call("motion", "post_poses", body=batch, **encoded))
assert len(models.Poses.from_dict(json.loads(poses)).rotations[1]) == bank.joints
for form in SpliceFormat:
    how = encoded if form in (SpliceFormat.JSON, SpliceFormat.MSGPACK) else {}
    save(f"splice.{form}", call("motion", "get_splice", **splice, **how, rate=30.0, first=15, count=4, format_=form))
frames = models.Frames.from_dict(json.loads((FOLDER / "splice.json").read_bytes()))
assert (frames.frame, frames.count, frames.rate, len(frames.world_positions)) == (15, 4, 30.0, 4)
fast = {"pace": models.Pace.FAST, "ahead": 2}
save("frames.stream", call("motion", "get_stream", **splice, **encoded, **fast, rate=30.0, first=15, count=4))
commands = [{"do": "create", "locomotion": "walk"}, {"at": 1, "do": "act", "action": "wave", "when": "foot"}]
order = models.TakeOrder.from_dict({"frames": 60, "commands": commands})
for form in SpliceFormat:
    how = encoded if form in (SpliceFormat.JSON, SpliceFormat.MSGPACK) else {}
    save(f"take.{form}", call("motion", "post_take", body=order, **how, format_=form))
taken = models.Take.from_dict(json.loads((FOLDER / "take.json").read_bytes()))
assert (taken.count, len(taken.phases), taken.action_times[0]) == (60, 60, None)
assert [one.action for one in taken.events if one.event == "action_began"] == ["wave"]
order.rig = base64.b64encode((FOLDER / "hero.glb").read_bytes()).decode()
on_rig = models.Take.from_dict(json.loads(save("take.json", call("motion", "post_take", body=order))))
assert (len(on_rig.node_rotations), len(on_rig.node_rotations[0])) == (60, len(on_rig.rig.turned))

unknown = operation("bank", "get_clip").sync("wlak", client=client)
assert isinstance(unknown, models.Problem)
assert "Did you mean 'walk'" in unknown.detail
refused = operation("bank", "get_bank").sync(client=generated.AuthenticatedClient(base_url=URL, token="wrong"))
assert (refused.status, refused.type_) == (401, "urn:motionsplice:token")

job = call("clips", "post_clip", body=upload("wave.bvh"), name="wave.bvh", kind=models.Kind.ACTION)
assert job.bank == bank.digest
assert call("clips", "get_job").state in set(models.JobInfoState)
events = operation("clips", "get_job_events")
with client.get_httpx_client().stream(**events._get_kwargs()) as answer:  # events do not end
    assert models.JobInfo.from_dict(json.loads(next(answer.iter_lines()).removeprefix("data: "))).bank == bank.digest

for check in ("get_health", "get_readiness"):
    assert operation("service", check).sync_detailed(client=client).status_code == 204
assert "motionsplice_" in call("service", "get_metrics")
print(json.dumps(sorted(called)))
