"""The user's own character, dropped onto the page or chosen, moves as the splice does."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect
from typer.testing import CliRunner

from bench.retarget.kinds import KINDS
from bench.retarget.rigs import on_rig
from motionsplice.cli import app
from motionsplice.motion.formats.character import parse_character
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.runtime.bank import Bank
from tests.characters import character_file, facing_back
from tests.glb_files import edited
from tests.viewer.conftest import View, until

WALK = make("walk", seconds=1.0)
MIXAMO = character_file(on_rig(WALK, KINDS["Mixamo"]).skeleton, scale=100.0, seed=4)
LIMBS = {
    "UpperLeg": "hip",
    "LowerLeg": "knee",
    "Foot": "ankle",
    "Toes": "toe",
    "UpperArm": "shoulder",
    "LowerArm": "elbow",
    "Hand": "wrist",
}
SHOWN = until("!own.status.startsWith('Reading') && (!own.character || viewer.shown[0]?.character === own.character)")
PLACES = """const figure = viewer.show.figures()[0];
figure.object.updateMatrixWorld(true);
const inwards = figure.object.children[0].matrixWorld.clone().invert();
const found = {};
figure.object.traverse((bone) => {
    if (bone.isBone) found[bone.name] = bone.matrixWorld.clone().premultiply(inwards).elements.slice(12, 15);
});
return found"""


def vrm_0() -> bytes:
    roles, names = find_roles(WALK.skeleton), WALK.skeleton.names
    bones = {"hips": names[0], "neck": names[roles.neck], "head": names[roles.head]}
    for side in ("left", "right"):
        bones |= {f"{side}{bone}": names[getattr(roles, f"{side}_{role}")] for bone, role in LIMBS.items()}
    return facing_back(character_file(WALK.skeleton.scaled(0.7), seed=5), bones)


def drop(view: View, name: str, data: bytes) -> None:
    """Drops a file on the picture."""
    transfer = view.page.evaluate_handle(
        """([name, text]) => {
            const transfer = new DataTransfer();
            transfer.items.add(new File([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], name));
            return transfer;
        }""",
        [name, base64.b64encode(data).decode()],
    )
    for event in ("dragenter", "dragover", "drop"):
        view.page.dispatch_event("#stage", event, {"dataTransfer": transfer, "bubbles": True, "cancelable": True})
    wait(view)


def wait(view: View) -> None:
    view.run(f"const {{ own }} = await import('/view/main.js'); {SHOWN}")
    view.settle()


def written(bank: Bank, folder: Path, data: bytes) -> Floats:
    """Returns the places [F, J, 3] of the character's joints as `motionsplice splice --character` writes them."""
    (folder / "hero.glb").write_bytes(data)
    command = ["splice", str(bank.path), "--locomotion", "walk", "--action", "wave"]
    done = CliRunner().invoke(
        app, [*command, "--character", str(folder / "hero.glb"), "--out", str(folder / "out.glb")]
    )
    assert done.exit_code == 0, done.output
    return joint_positions(read_clip(folder / "out.glb", unit="1").clip)


@pytest.mark.parametrize(("name", "data"), [("hero.glb", MIXAMO), ("hero.vrm", vrm_0())], ids=["Mixamo", "VRM 0.x"])
def test_a_dropped_character_moves_as_the_command_line_writes_it(
    view: View, bank: Bank, tmp_path: Path, name: str, data: bytes
) -> None:
    view.show(locomotion="walk", action="wave", show="splice", time=1.0)
    drop(view, name, data)
    expect(view.page.get_by_role("radio", name="Own")).to_be_checked()
    places: Any = view.run(PLACES)
    skeleton = parse_character(data).skeleton
    found = np.array([places[joint.replace(":", "")] for joint in skeleton.names])
    frame = round(bank.clip("walk").rate * 1.0)
    expected = written(bank, tmp_path, data)[frame]
    apart = np.linalg.norm(found[:, None] - found[None], axis=-1)  # a take begins elsewhere than the clip
    np.testing.assert_allclose(apart, np.linalg.norm(expected[:, None] - expected[None], axis=-1), atol=1e-4)
    left_to_right = found - found[0], expected - expected[0]
    assert np.sign(np.linalg.det(left_to_right[0][1:4])) == np.sign(np.linalg.det(left_to_right[1][1:4]))  # no mirror


def test_it_stands_and_goes_where_the_mannequin_does(view: View) -> None:
    view.show(locomotion="walk", action="wave", show="splice", time=1.0)
    drop(view, "hero.vrm", vrm_0())
    hips = ("LeftUpLeg", "RightUpLeg")
    found: Any = view.run(
        f"""const {{ rig }} = viewer.shown[0].motion;
        const body = viewer.show.positions()[0];
        const figure = viewer.show.figures()[0];
        figure.object.updateMatrixWorld(true);
        return {json.dumps(hips)}.map((name) => {{
            const joint = rig.joints.indexOf(name);
            const bone = figure.object.getObjectByName(name);
            return [[...body.slice(3 * joint, 3 * joint + 3)], bone.matrixWorld.elements.slice(12, 15)];
        }})"""
    )
    body, figure = np.array(found).transpose(1, 0, 2)
    np.testing.assert_allclose(figure[:, [0, 2]], body[:, [0, 2]], atol=1e-3)  # of the same skeleton, scaled
    assert abs(figure[:, 1] - body[:, 1]).max() < 0.03  # raised for its soles


def test_only_its_rig_is_sent(view: View) -> None:
    bodies: list[str] = []
    view.page.on("request", lambda request: bodies.append(request.post_data or ""))
    view.show(locomotion="walk", action="wave", show="splice")
    drop(view, "hero.glb", MIXAMO)
    rigs = [json.loads(body)["rig"] for body in bodies if '"rig"' in body]
    assert rigs
    for rig in rigs:
        document, binary = read_document(base64.b64decode(rig))
        assert document.keys() == {"asset", "nodes", "skins", "extensions", "buffers", "bufferViews", "accessors"}
        assert len(binary) == 64 * len(document["skins"][0]["joints"])


def test_a_click_moves_it_soon(view: View) -> None:
    view.show(locomotion="walk", show="splice,naive")
    drop(view, "hero.glb", MIXAMO)
    view.page.locator("#lists").get_by_role("option").filter(has_text="wave").click()
    view.settle()
    assert view.run("return viewer.shown.map(({ nodes }) => nodes !== undefined)") == [True, True]
    assert view.run("return viewer.show.figures().length") == 2
    view.page.get_by_role("radio", name="Stick").click(force=True)
    view.settle()
    assert view.run("return viewer.show.figures().length") == 0
    view.page.locator("#stage").focus()
    for _ in range(2):
        view.page.keyboard.press("m")  # mannequin, then own again, as it goes round
        view.settle()
    view.run("state.set({ body: 'own', layout: 'over' })")
    view.settle()
    assert view.run("return viewer.show.figures().length") == 2


def test_it_can_be_removed_and_frees_the_graphics_card(view: View) -> None:
    view.open(locomotion="walk", action="wave", show="splice")
    before: Any = view.run("return { ...viewer.stage.memory }")
    for _ in range(2):
        drop(view, "hero.glb", MIXAMO)
    view.page.get_by_role("button", name="Remove").click()
    view.settle()
    assert view.run("return state.values.body") == "mannequin"
    view.run(until(f"JSON.stringify(viewer.stage.memory) === JSON.stringify({json.dumps(before)})"))


def unnamed(document: dict[str, Any]) -> None:
    for number, node in enumerate(document["nodes"]):
        node["name"] = f"bone {number}"


REFUSED = {
    "walk.bvh": (b"HIERARCHY", "This is not a GLB or VRM file."),
    "text.glb": (b"no model at all, but a text of some length", "This is not a GLB or VRM file."),
    "cut.glb": (MIXAMO[:2000], "cut short"),
    "no-skin.glb": (edited(MIXAMO, lambda document: document.pop("skins")), "It has no skin"),
    "nobody.glb": (edited(MIXAMO, unnamed), "No joint found for left_hip"),
    "draco.glb": (edited(MIXAMO, lambda one: one.update(extensionsRequired=["KHR_draco_mesh_compression"])), "Draco"),
    "no-mesh.glb": (edited(MIXAMO, lambda document: document["nodes"][-1].pop("mesh")), "no mesh"),
    "damaged.glb": (edited(MIXAMO, lambda document: document["accessors"][0].update(count=10**8)), "damaged"),
}


def test_files_that_cannot_be_shown_are_refused_in_a_sentence(view: View) -> None:
    view.open(locomotion="walk", action="wave", show="splice")
    for name, (data, problem) in REFUSED.items():
        drop(view, name, data)
        status = view.page.locator(".character [role=status]")
        expect(status).to_contain_text(f"{name}: ")
        expect(status).to_contain_text(problem)
        expect(view.page.locator("#readout .fault")).to_contain_text(problem)
        assert view.run("return state.values.body") == "mannequin"
        view.faults[:] = [fault for fault in view.faults if "422" not in fault]  # the browser logs the answer
        assert not view.faults


def test_its_pictures_are_loaded_from_the_file_and_nowhere_else(view: View) -> None:
    png = base64.b64decode(
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAsTj2FAAAAABJRU5ErkJggg=="
    )
    _, binary = read_document(MIXAMO)

    def pictured(document: dict[str, Any]) -> None:
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(png)})
        document["buffers"][0]["byteLength"] = len(binary) + len(png)
        document["images"] = [
            {"bufferView": len(document["bufferViews"]) - 1, "mimeType": "image/png"},
            {"uri": f"data:image/png;base64,{base64.b64encode(png).decode()}"},
            {"uri": "https://example.org/beside.png"},
        ]
        document["textures"] = [{"source": source} for source in range(3)]
        (material,) = document["materials"]
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
        material["normalTexture"] = {"index": 1}
        material["emissiveTexture"] = {"index": 2}

    view.show(locomotion="walk", action="wave", show="splice")
    drop(view, "hero.glb", edited(MIXAMO, pictured, binary + png + bytes(-len(png) % 4)))
    found = view.run(
        """const found = [];
        viewer.show.figures()[0].object.traverse(({ material }) => {
            if (material) for (const key of ['map', 'normalMap', 'emissiveMap']) found.push(material[key].image.width);
        });
        return found"""
    )
    assert found == [1, 1, 1]


def test_a_link_to_a_character_shows_the_mannequin_until_it_is_there(view: View) -> None:
    view.open(locomotion="walk", action="wave", show="splice", body="own")
    assert view.run("return viewer.show.figures().length") == 0
    expect(view.page.locator(".character")).to_contain_text("only its skeleton is sent")
    with view.page.expect_file_chooser() as chooser:
        view.page.get_by_role("button", name="Choose a file").click()
    chooser.value.set_files({"name": "hero.glb", "mimeType": "model/gltf-binary", "buffer": MIXAMO})
    wait(view)
    assert view.run("return viewer.show.figures().length") == 1


def test_its_own_file_is_saved_with_the_motion(view: View, bank: Bank, tmp_path: Path) -> None:
    """Also where nodes have matrices, which an animation may not move."""
    hero = character_file(WALK.skeleton.scaled(0.9), seed=2, matrices=True)
    view.show(locomotion="walk", action="wave", show="splice")
    drop(view, "hero.glb", hero)
    view.page.get_by_role("button", name="Export").click()
    with view.page.expect_download() as download:
        view.page.get_by_role("button", name="GLB of your character").click()
    assert download.value.suggested_filename == "walk+wave.glb"
    download.value.save_as(tmp_path / "saved.glb")
    saved = read_clip(tmp_path / "saved.glb", unit="1")
    expected = written(bank, tmp_path, hero)
    found = joint_positions(saved.clip)
    assert found.shape == expected.shape
    apart = [np.linalg.norm(one[:, :, None] - one[:, None], axis=-1) for one in (found, expected)]
    np.testing.assert_allclose(apart[0], apart[1], atol=1e-4)
    before, after = (read_document(data)[0] for data in (hero, (tmp_path / "saved.glb").read_bytes()))
    assert after["meshes"] == before["meshes"]
    assert [one["name"] for one in after["animations"]] == ["walk+wave"]
