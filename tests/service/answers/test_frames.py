"""Poses, splices and streams over HTTP are the evaluator's."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from fastapi.testclient import TestClient

from motionsplice.motion.formats.bvh import parse
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions, world_transforms
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Memory, Posture
from motionsplice.runtime.splice import Splice
from motionsplice.service.answers.frames import Frames
from motionsplice.service.answers.stream import STREAM, Clock, messages
from motionsplice.service.serving import Edition
from motionsplice.service.wire.encoding import Encoding
from tests.service.messages import arrays, blob_offsets, framed, unpacked


@pytest.mark.parametrize("method", ["splice", "naive", "none"])
@pytest.mark.parametrize("posture", ["relative", "absolute", "off"])
def test_a_pose_is_that_of_the_evaluator(client: TestClient, bank: Bank, method: Any, posture: Any) -> None:
    query = f"locomotion=run&time=1.25&action=wave&start=0.5&method={method}&posture={posture}&parts=both"
    body = client.get(f"/v1/pose?{query}").json()
    blobs = arrays(msgpack.unpackb(client.get(f"/v1/pose?{query}&format=msgpack").content), bank.skeleton.joint_count)
    evaluator = Evaluator(bank)
    poses = evaluator.pose(Splice("run", "wave", start=0.5, method=method, posture=posture), 1.25)
    world = np.empty((1, bank.skeleton.joint_count, 3), np.float32)
    evaluator.world_positions(poses, world)
    for name, wanted in (
        ("root_positions", poses.root_positions),
        ("rotations", poses.rotations),
        ("world_positions", world),
    ):
        np.testing.assert_allclose(body[name], wanted[0], atol=1e-7)
        np.testing.assert_array_equal(blobs[name], wanted[0])


def test_a_cached_query_is_answered_like_a_new_one(client: TestClient) -> None:
    for time_, wave in ((0.5, "wave"), (1.25, "wave"), (0.5, "carry_box"), (1.25, "wave")):
        ready = client.get(f"/v1/pose?locomotion=walk&time={time_}&action={wave}").json()
        fresh = client.get(f"/v1/pose?action={wave}&locomotion=walk&start=0.0&posture=relative&time=%30{time_}").json()
        assert ready == fresh
    answer = client.get("/v1/pose?locomotion=walk&time=0.5&action=wave&time=0.5")
    assert "time: given twice" in answer.json()["detail"]


@pytest.mark.parametrize("form", ["json", "msgpack"])
@pytest.mark.parametrize("axes", ["gltf", "unity"])
def test_a_batch_has_the_same_poses_as_single_requests(client: TestClient, bank: Bank, form: str, axes: str) -> None:
    joints, times = bank.skeleton.joint_count, [0.0, 0.7, 1.9]
    batch: dict[str, Any] = {"clips": ["run", "wave"], "locomotion": [0, 0, 0], "action": [1, -1, 1], "time": times}
    options = f"axes={axes}&parts=both&format={form}"
    if form == "json":
        body = client.post(f"/v1/poses?{options}", json=batch).json()
    else:
        kinds = {"locomotion": "<i4", "action": "<i4", "time": "<f8"}
        packed = {key: np.array(one, kinds[key]).tobytes() if key in kinds else one for key, one in batch.items()}
        headers = {"content-type": "application/msgpack"}
        answer = client.post(f"/v1/poses?{options}", content=msgpack.packb(packed), headers=headers)
        body = arrays(msgpack.unpackb(answer.content), joints, 3)
    for number, action in enumerate(("&action=wave", "", "&action=wave")):
        alone = client.get(
            f"/v1/pose?locomotion=run&time={times[number]}{action}&{options.replace(form, 'json')}"
        ).json()
        for name in ("root_positions", "rotations", "world_positions"):
            np.testing.assert_allclose(body[name][number], alone[name], atol=1e-7)


def test_a_batch_of_another_type_or_size_is_refused(client: TestClient) -> None:
    assert client.post("/v1/poses", content=b"x", headers={"content-type": "text/plain"}).status_code == 415
    big = client.post("/v1/poses", content=b"x" * 5_000_000, headers={"content-type": "application/msgpack"})
    assert (big.status_code, big.json()["type"]) == (413, "urn:motionsplice:too-large")
    many = {"clips": ["walk"], "locomotion": [0] * 700, "time": [0.0] * 700}
    assert "Ask for format=msgpack" in client.post("/v1/poses", json=many).json()["detail"]
    assert client.post("/v1/poses?format=msgpack", json=many).status_code == 200


def expected(bank: Bank, locomotion: str, action: str, posture: Posture = "relative") -> Any:
    evaluator = Evaluator(bank)
    times, memory = evaluator.frame_times(locomotion), Memory.begin(1, bank.clip(locomotion).rate)
    return evaluator.sequence(Splice(locomotion, action, posture=posture), times, memory=memory)


@pytest.mark.parametrize("posture", ["relative", "running"])
def test_a_splice_has_the_frames_of_the_evaluator_to_the_bit(client: TestClient, bank: Bank, posture: Posture) -> None:
    query = f"/v1/splice?locomotion=run&action=carry_box&posture={posture}"
    poses, joints = expected(bank, "run", "carry_box", posture), bank.skeleton.joint_count
    body = msgpack.unpackb(client.get(f"{query}&format=msgpack").content)
    count = len(poses.rotations)
    assert (body["bank"], body["frame"], body["count"]) == (bank.digest, 0, count)
    assert body["rate"] == bank.clip("run").rate
    found = arrays(body, joints, count)
    np.testing.assert_array_equal(found["rotations"], poses.rotations)
    np.testing.assert_array_equal(found["root_positions"], poses.root_positions)
    some = client.get(f"{query}&first=70&count=80").json()
    assert (some["frame"], some["count"]) == (70, 80)
    np.testing.assert_allclose(some["rotations"], poses.rotations[70:150], atol=1e-7)
    short = msgpack.unpackb(client.get(f"{query}&format=msgpack&encoding=int16&first=70").content)
    np.testing.assert_allclose(
        arrays(short, joints, count - 70, short=True)["rotations"], poses.rotations[70:], atol=2e-5
    )


@pytest.mark.parametrize("count", [1, 100])
def test_a_splice_as_a_file_is_the_same_motion(client: TestClient, bank: Bank, count: int) -> None:
    answer = client.get(f"/v1/splice?locomotion=run&action=carry_box&format=bvh&count={count}")
    assert answer.headers["content-disposition"] == 'attachment; filename="run+carry_box.bvh"'
    nodes, rate, *_ = parse(answer.content)
    assert (len(nodes.rotations), round(rate)) == (count, bank.clip("run").rate)
    poses = expected(bank, "run", "carry_box")
    same = np.abs(np.sum(nodes.rotations * poses.rotations[:count], axis=-1))
    np.testing.assert_allclose(same, 1.0, atol=1e-6)


@pytest.mark.parametrize(
    ("form", "media_type"), [("glb", "model/gltf-binary"), ("gltf", "model/gltf+json"), ("vrma", "model/gltf-binary")]
)
def test_a_splice_as_gltf_is_the_same_motion(
    client: TestClient, bank: Bank, tmp_path: Path, form: str, media_type: str
) -> None:
    query = f"/v1/splice?locomotion=run&action=carry_box&format={form}"
    answer = client.get(query)
    assert answer.headers["content-type"] == media_type
    assert answer.headers["content-disposition"] == f'attachment; filename="run+carry_box.{form}"'
    assert client.get(query, headers={"if-none-match": answer.headers["etag"]}).status_code == 304
    (tmp_path / f"splice.{form}").write_bytes(answer.content)
    clip = read_clip(tmp_path / f"splice.{form}").clip
    poses = expected(bank, "run", "carry_box")
    positions, _ = world_transforms(bank.skeleton, poses.root_positions, poses.rotations)
    joints = [bank.skeleton.index(name) for name in clip.skeleton.names]
    assert len(joints) == bank.skeleton.joint_count
    np.testing.assert_allclose(joint_positions(clip), positions[:, joints], atol=1e-5)


@pytest.mark.parametrize("parts", ["local", "world", "both"])
@pytest.mark.parametrize("encoding", ["float32", "int16"])
def test_arrays_of_every_answer_begin_at_multiples_of_four_bytes(client: TestClient, parts: str, encoding: str) -> None:
    how = f"&parts={parts}&encoding={encoding}"
    batch = {"clips": ["walk"], "locomotion": [0] * 5, "time": [0.5] * 5}
    _, *streamed = framed(client.get(f"/v1/stream?locomotion=walk&rate=200&ahead=70{how}").content)
    messages = [
        client.get(f"/v1/pose?locomotion=walk&time=1&format=msgpack{how}").content,
        client.post(f"/v1/poses?format=msgpack{how}", json=batch).content,
        client.get(f"/v1/splice?locomotion=walk&count=1&format=msgpack{how}").content,
        client.get(f"/v1/splice?locomotion=walk&rate=200&format=msgpack{how}").content,  # more than 64 KiB an array
        *streamed,
    ]
    assert len(messages) > 10
    for message in messages:
        offsets = blob_offsets(message)
        assert len(offsets) == (3 if parts == "both" else 2)
        assert not any(offset % 4 for offset in offsets.values())


@pytest.mark.parametrize(("ahead", "count"), [(1, 150), (7, 22), (100, 2)])
def test_a_stream_is_the_splice_in_messages(client: TestClient, bank: Bank, ahead: int, count: int) -> None:
    query = f"locomotion=run&action=carry_box&first=10&count=150&ahead={ahead}"
    answer = client.get(f"/v1/stream?{query}&parts=both&axes=unity&encoding=int16")
    assert answer.headers["content-type"] == "application/vnd.motionsplice.stream"
    header, *frames = unpacked(answer.content)
    assert (header["stream"], header["bank"], header["first"], header["frames"]) == (3, bank.digest, 10, 150)
    assert (header["axes"], header["encoding"], header["parts"]) == ("unity", "int16", "both")
    assert header["joints"] == list(bank.skeleton.names)
    assert header["parents"] == bank.skeleton.parents.tolist()
    assert len(frames) == count
    whole = msgpack.unpackb(
        client.get(
            f"/v1/splice?{query.replace(f'&ahead={ahead}', '')}&parts=both&axes=unity&encoding=int16&format=msgpack"
        ).content
    )
    assert [frame["frame"] for frame in frames] == list(range(10, 160, ahead))
    assert sum(frame["count"] for frame in frames) == 150
    for name in ("root_positions", "rotations", "world_positions"):
        assert b"".join(frame[name] for frame in frames) == whole[name]


def test_a_paced_stream_does_not_drift_from_the_clips_time(bank: Bank) -> None:
    edition = Edition.warm(bank)
    frames = Frames.from_query(edition, STREAM.read(b"locomotion=walk&action=wave"), 10**6)
    now, sent = 100.0, []

    async def sleep(seconds: float) -> None:
        nonlocal now
        now += seconds + 0.003  # each wait is a little late, and lateness must not add up

    async def collect() -> None:
        async for _ in messages(frames, Encoding(), 1, "realtime", Clock(lambda: now, sleep)):
            sent.append(now - 100.0)

    asyncio.run(collect())
    late = np.array(sent[1:]) - np.arange(frames.count) / frames.rate
    assert late.min() >= 0.0
    assert late.max() < 0.0031


def test_a_fast_stream_yields_to_others_between_blocks(bank: Bank) -> None:
    frames = Frames.from_query(Edition.warm(bank), STREAM.read(b"locomotion=walk&rate=1000"), 10**6)
    yields = 0

    async def sleep(seconds: float) -> None:
        nonlocal yields
        assert seconds == 0.0
        yields += 1

    async def collect() -> list[bytes]:
        clock = Clock(lambda: 0.0, sleep)
        return [chunk async for _, chunk in messages(frames, Encoding(), 1, "fast", clock)]

    chunks = asyncio.run(collect())
    assert yields == len(chunks) - 1 > 50
    assert max(map(len, chunks)) < 200_000
