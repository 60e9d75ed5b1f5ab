from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from pydantic import SecretStr

from bench.retarget.kinds import KINDS
from bench.retarget.rigs import on_rig
from motionsplice.motion.clip_settings import ClipSettings, read_clip_settings
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.procedural.library import make
from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.exchange.pending import Folder
from motionsplice.service.exchange.uploads import checked_name
from motionsplice.service.problems import RequestError
from motionsplice.service.settings import Settings
from tests.glb_files import with_animation
from tests.service.running import Running, eventually, received, running

TOKEN = "open sesame"


@pytest.fixture
def folder(clip_folder: Path, bank: Bank, tmp_path: Path) -> Path:
    """A folder of clips beside the bank built from it. Tests change both."""
    shutil.copytree(clip_folder, tmp_path / "clips")
    shutil.copytree(bank.path, tmp_path / "bank")
    return tmp_path / "clips"


@pytest.fixture
def full(folder: Path) -> Iterator[Running]:
    """A service whose folder may have one clip and 100,000 bytes more, and that waits for a body for half a second."""
    held = sum(one.stat().st_size for one in folder.iterdir())
    settings = Settings(
        token=SecretStr(TOKEN),
        clips=folder,
        max_clips=len(list(folder.glob("*.bvh"))) + 1,
        max_stored=held + 100_000,
        request_seconds=0.5,
    )
    with running(folder.parent / "bank", settings) as service:
        yield service


@pytest.fixture
def service(folder: Path) -> Iterator[Running]:
    settings = Settings(token=SecretStr(TOKEN), clips=folder, max_upload=3_000_000)
    with running(folder.parent / "bank", settings) as service:
        yield service


def ask(service: Running, path: str, body: bytes | None = None, token: str = TOKEN) -> tuple[int, dict[str, Any]]:
    headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/octet-stream"}
    request = urllib.request.Request(f"{service.url}/v1/{path}", data=body, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return answer.status, json.load(answer)
    except urllib.error.HTTPError as error:
        return error.code, json.load(error)


def state(service: Running) -> dict[str, Any]:
    return ask(service, "job")[1]


def unfinished(folder: Path) -> list[str]:
    """Returns unfinished uploads in the folder."""
    return [one.name for one in folder.iterdir() if one.name.startswith(".upload")]


def visible(folder: Path) -> list[Path]:
    return sorted(one for one in folder.iterdir() if not one.name.startswith("."))


def test_an_uploaded_clip_is_added_to_the_bank_and_served(service: Running, folder: Path) -> None:
    old = service.config.front.shared.serving.bank.digest
    eventually(lambda: state(service)["state"] == "idle")
    jog = dump_bvh(make("run", seed=20, seconds=3.0))
    status, answer = ask(service, "clips?name=jog.bvh&tags=fast,%20new", jog)
    assert (status, answer["clips"]) == (202, ["jog"])
    assert answer["state"] in ("waiting", "running")
    eventually(lambda: service.config.front.shared.serving.bank.digest != old)
    assert ask(service, "clips/jog")[1]["tags"] == ["fast", "new"]
    assert ask(service, "pose?locomotion=jog&time=1")[0] == 200
    eventually(lambda: state(service)["state"] == "idle")
    assert state(service)["clips"] == []
    assert (folder / "jog.bvh").read_bytes() == jog
    assert "carry_box" in (folder / "clips.toml").read_text()
    assert not unfinished(folder)


def test_a_clip_of_another_rig_and_format_is_retargeted_to_the_bank(service: Running, folder: Path) -> None:
    old = service.config.front.shared.serving.bank
    jog = dump_glb(on_rig(make("run", seed=20, seconds=3.0), KINDS["Unreal"]))
    assert ask(service, "clips?name=jog.glb", jog)[0] == 202
    eventually(lambda: service.config.front.shared.serving.bank.digest != old.digest)
    new = service.config.front.shared.serving.bank
    assert new.skeleton.names == old.skeleton.names
    assert "retargeted by roles" in " ".join(new.clip("jog").notes)


def test_a_file_that_is_not_a_motion_is_refused_and_leaves_nothing(service: Running, folder: Path) -> None:
    before = visible(folder)
    jog = make("run", seed=20, seconds=1.0)
    two_animations = with_animation(dump_glb(jog), replace(jog, name="again"))
    for name, body, status, kind, words in (
        ("jump.bvh", b"HIERARCHY\nROOT Hips", 422, "clip", "jump.bvh"),
        ("jump.bvh", b"\x00\xff" * 50, 422, "clip", "jump.bvh"),
        ("jump.bvh", b"x" * 3_000_001, 413, "too-large", "more than 3000000 bytes"),
        ("walk.amc", b"x", 422, "request", "the folder already has a clip walk.bvh"),
        ("..%2Fjump.bvh", b"x", 422, "request", "not a valid file name of a clip"),
        ("jump.glb", two_animations, 422, "clip", "it has 2 animations. Upload a file for each"),
        ("jump.txt", b"x", 422, "request", "not a valid file name of a clip"),
    ):
        found, answer = ask(service, f"clips?name={name}", body)
        assert (found, answer["type"]) == (status, f"urn:motionsplice:{kind}"), answer
        assert words in answer["detail"]
        assert str(folder) not in answer["detail"]
    assert visible(folder) == before
    assert not unfinished(folder)


def test_a_full_folder_takes_no_clips(full: Running, folder: Path) -> None:
    before, small = visible(folder), dump_bvh(make("run", seed=20, seconds=1.0, rate=30.0))
    found, answer = ask(full, "clips?name=jump.bvh", b"x" * 3_000_000)
    assert (found, answer["type"]) == (413, "urn:motionsplice:too-large")
    assert "--max-stored" in answer["detail"]
    assert visible(folder) == before
    assert not unfinished(folder)
    assert ask(full, "clips?name=jog.bvh", small)[0] == 202
    found, answer = ask(full, "clips?name=jump.bvh", small)
    assert (found, answer["type"]) == (413, "urn:motionsplice:too-large")
    assert "--max-clips" in answer["detail"]
    assert ask(full, "clips?name=jog.bvh", small)[0] == 202  # in place of the old one


@pytest.mark.parametrize("sent", [b"", b"HIERARCHY"])
def test_an_upload_that_stops_coming_is_deleted_and_its_connection_closed(
    full: Running, folder: Path, sent: bytes
) -> None:
    head = f"POST /v1/clips?name=jump.bvh HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {TOKEN}\r\n"
    peer = full.connect(head.encode() + b"Content-Type: application/octet-stream\r\nContent-Length: 900\r\n\r\n" + sent)
    answer = received(peer)
    assert answer.startswith(b"HTTP/1.1 408")
    assert b"connection: close" in answer
    assert b"timeout" in answer
    assert not unfinished(folder)


@pytest.mark.parametrize(
    "name", ["", ".bvh", ".x.bvh", "a/b.bvh", "a\\b.bvh", "..", "a.bvh\n", "ä.bvh", "a.bvh.exe", "a" * 101 + ".bvh"]
)
def test_a_name_cannot_be_a_path(name: str) -> None:
    with pytest.raises(RequestError, match="is not a valid file name of a clip"):
        checked_name(name)
    assert checked_name("Jump_2+x-y.bvh")


def test_a_body_cut_short_leaves_nothing(service: Running, folder: Path) -> None:
    head = f"POST /v1/clips?name=jump.bvh HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {TOKEN}\r\n"
    peer = service.connect(head.encode() + b"Content-Length: 999\r\n\r\n", b"HIERARCHY")
    eventually(lambda: bool(unfinished(folder)))
    peer.close()
    eventually(lambda: not unfinished(folder))
    assert not (folder / "jump.bvh").exists()


def test_uploads_at_the_same_time_do_not_overwrite_each_other(service: Running, folder: Path) -> None:
    names = ["one", "two", "three"]
    clip = dump_bvh(make("walk", "wave", seed=30, seconds=2.5))
    threads = [
        threading.Thread(target=ask, args=(service, f"clips?name={name}.bvh&kind=action&tags={name}", clip))
        for name in names
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    written = (folder / "clips.toml").read_text()
    assert all(f"[{name}]" in written and (folder / f"{name}.bvh").exists() for name in names)
    eventually(lambda: state(service)["state"] == "idle")
    # the bank is exchanged a little after the job is done
    eventually(lambda: {clip["name"] for clip in ask(service, "clips")[1]} >= set(names))  # type: ignore[index]


def test_a_clip_that_fails_is_reported_and_not_tried_for_ever(service: Running, folder: Path) -> None:
    eventually(lambda: state(service)["state"] == "idle")
    (folder / "broken.bvh").write_text("HIERARCHY\n")
    eventually(lambda: state(service)["state"] == "failed")
    info = state(service)
    assert list(info["failed"]) == info["clips"] == ["broken"]
    assert info["failed"]["broken"]
    (folder / "broken.bvh").unlink()
    eventually(lambda: state(service)["state"] == "idle")


def test_a_killed_job_is_finished_by_the_next_service(folder: Path) -> None:
    (folder / "jog.bvh").write_bytes(dump_bvh(make("run", seed=20, seconds=3.0)))
    settings = Settings(token=SecretStr(TOKEN), clips=folder)
    path = folder.parent / "bank"
    with running(path, settings) as service:
        eventually(lambda: state(service)["state"] == "running")
        found = subprocess.run(["pgrep", "-f", f"precompute {folder}"], capture_output=True, text=True, check=True)
        for process in found.stdout.split():
            os.kill(int(process), signal.SIGKILL)
        assert state(service)["clips"] == ["jog"]
    with running(path, settings) as service:
        assert Folder(folder, path).pending() or ask(service, "clips/jog")[0] == 200
        eventually(lambda: state(service)["state"] == "idle")
        eventually(lambda: ask(service, "clips/jog")[0] == 200)


def test_progress_comes_as_events(service: Running, folder: Path) -> None:
    eventually(lambda: state(service)["state"] == "idle")
    request = urllib.request.Request(f"{service.url}/v1/job/events", headers={"Authorization": f"Bearer {TOKEN}"})
    with urllib.request.urlopen(request, timeout=60) as events:
        assert events.headers["content-type"].startswith("text/event-stream")
        states: list[dict[str, Any]] = []
        (folder / "jog.bvh").write_bytes(dump_bvh(make("run", seed=20, seconds=3.0)))
        while not (states and states[-1]["state"] == "idle" and any(one["state"] == "running" for one in states)):
            line = events.readline()
            if line.startswith(b"data: "):
                states.append(json.loads(line[6:]))
    assert states[0]["state"] == "idle"
    eventually(lambda: service.held[2] <= 1)


def test_without_a_token_or_a_folder_uploads_are_refused(bank: Bank, folder: Path) -> None:
    for settings, missing in ((Settings(clips=folder), "--token"), (Settings(token=SecretStr(TOKEN)), "--clips")):
        client = TestClient(create_app(bank, settings), headers={"Authorization": f"Bearer {TOKEN}"})
        for answer in (client.post("/v1/clips?name=a.bvh", content=b"x"), client.get("/v1/job")):
            assert (answer.status_code, answer.json()["type"]) == (403, "urn:motionsplice:uploads")
            assert missing in answer.json()["detail"]


def test_a_refused_upload_changes_nothing(service: Running, folder: Path) -> None:
    clip = dump_bvh(make("run", seed=20, seconds=3.0))
    (folder / "Run.BVH").write_bytes(clip)
    no_arm = clip.replace(b"JOINT LeftHand\n", b"JOINT Hook\n")
    before = {file: file.read_bytes() for file in visible(folder)}
    for query, body, words in (
        ("name=jog.bvh&neutral=wlak", clip, "the folder has no clip 'wlak'"),
        ("name=16.asf&kind=action", b"x", "a skeleton has no kind, neutral or tags"),
        ("name=16.asf", b"no skeleton", "16.asf"),
        ("name=Run.bvh", clip, "the folder already has a clip Run.BVH"),
        ("name=jog.bvh", dump_bvh(make("run", seed=20, seconds=0.2)), "it lasts 0.2"),
        ("name=jog.bvh", no_arm, "no joint found for left_wrist"),
    ):
        status, answer = ask(service, f"clips?{query}", body)
        assert status == 422, answer
        assert words in answer["detail"]
    (folder / "clips.toml").write_text("[carry_box\n")
    status, answer = ask(service, "clips?name=walk.bvh&tags=new", clip)
    assert (status, answer["type"]) == (422, "urn:motionsplice:request")
    before[folder / "clips.toml"] = b"[carry_box\n"
    assert str(folder) not in answer["detail"]
    assert {file: file.read_bytes() for file in visible(folder)} == before
    assert not unfinished(folder)


def test_an_upload_keeps_what_a_person_wrote_into_the_settings(service: Running, folder: Path) -> None:
    (folder / "clips.toml").write_text("# ours\n[carry_box] # both hands\nkind = 'action'\nskip_frames = 1\n")
    (folder / ".upload-old").mkdir()
    os.utime(folder / ".upload-old", (0, 0))
    assert ask(service, "clips?name=carry_box.bvh&tags=box,", (folder / "carry_box.bvh").read_bytes())[0] == 202
    written = (folder / "clips.toml").read_text()
    assert written.startswith("# ours\n[carry_box] # both hands\nkind = 'action'\nskip_frames = 1\n")
    assert read_clip_settings(folder / "clips.toml") == {"carry_box": ClipSettings("action", None, ("box",), 1)}
    assert not unfinished(folder)
