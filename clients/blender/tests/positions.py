"""Compares bones in Blender with the service's world positions: `python positions.py GOLDEN_FOLDER URL`, with `bpy`.

Prints a line of JSON: the largest distances in metres, of golden files, of an imported splice, and of a live preview.
"""

import json
import os
import sys
import time
import urllib.request
from itertools import chain
from pathlib import Path

import bpy
from mathutils import Euler, Matrix, Vector

sys.path.insert(0, str(Path(__file__).parents[1]))
import motionsplice

LIVE = 1000  # frames
PATIENCE = 60.0  # seconds


def main(golden, url):
    motionsplice.register()
    settings = bpy.context.scene.motionsplice
    settings.address, settings.locomotion, settings.action = url, "walk", "wave"
    settings.in_place = False
    bpy.context.scene.render.fps = 60
    found = {"golden": of_golden_files(Path(golden)), "splice": of_splice(url)}
    found["frames"], found["live"], found["exchanged"] = live()
    settings.locomotion = "wlak"
    found["refused"] = refusals()
    print(json.dumps(found), flush=True)


def of_golden_files(folder):
    rig = json.loads((folder / "rig.blender.json").read_text())
    found = {}
    for encoding in ("float32", "int16"):
        message = json.loads((folder / f"characters.blender.{encoding}.json").read_text())
        scale = 32767 if encoding == "int16" else 1
        for name, armature in (("plain", built(rig, 0.0)), ("turned", built(rig, 0.7))):
            worst = 0.0
            poses = (chain(*message[key]) for key in ("root_positions", "rotations", "world_positions"))
            for root, rotations, world in zip(*poses, strict=True):
                motionsplice.apply(armature, rig, root, [[x / scale for x in turn] for turn in rotations])
                worst = max(worst, distance(armature, rig["joints"], world))
            found[f"{encoding} {name}"] = worst
    return found


def built(rig, turn):
    """Returns an armature whose bones have axes of their own, with a bone above the root, and one in each branch."""
    data = bpy.data.armatures.new("rig")
    armature = bpy.data.objects.new("rig", data)
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    above = data.edit_bones.new("above")
    above.tail = (0.1, 0.2, 0.3)
    places = []
    for joint, parent in enumerate(rig["parents"]):
        place = Vector(rig["offsets"][joint]) + (places[parent] if parent >= 0 else Vector())
        places.append(place)
        owner = data.edit_bones[rig["joints"][parent]] if parent >= 0 else above
        if parent == 0:
            between = data.edit_bones.new(f"between {joint}")
            between.head, between.tail, between.parent = places[0], places[0] + Vector((0, 0.1, 0)), owner
            owner = between
        bone = data.edit_bones.new(rig["joints"][joint])
        bone.tail = (0, 0.1, 0)
        bone.matrix = Matrix.Translation(place) @ Euler((turn * joint, joint * turn / 3, -turn)).to_matrix().to_4x4()
        bone.parent = owner
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def distance(armature, joints, world):
    """Returns how far bones are at most from where joints should be."""
    bpy.context.view_layer.update()
    heads = (armature.matrix_world @ armature.pose.bones[name].head for name in joints)
    return max((head - Vector(place)).length for head, place in zip(heads, world, strict=True))


def of_splice(url):
    assert bpy.ops.motionsplice.import_splice() == {"FINISHED"}
    query = "?locomotion=walk&action=wave&axes=blender&parts=world"
    splice, skeleton = (
        json.load(urllib.request.urlopen(url + path)) for path in ("/v1/splice" + query, "/v1/skeleton")
    )
    worst = 0.0
    for frame, world in enumerate(splice["world_positions"]):
        bpy.context.scene.frame_set(frame)
        worst = max(worst, distance(bpy.context.object, skeleton["joints"], world))
    assert frame > 100
    return worst


def live():
    """Previews on the imported armature, whose action must not interfere. Changes the action, then the locomotion."""
    armature, settings = bpy.context.object, bpy.context.scene.motionsplice
    armature.animation_data_clear()
    link = motionsplice.Link
    motionsplice.Link = lambda address, path, token: link(address, path + "&parts=both", token)
    apply, applied = motionsplice.apply, []
    motionsplice.apply = lambda *shown: (apply(*shown), applied.append(shown[-1]))
    assert bpy.ops.motionsplice.preview() == {"FINISHED"}
    preview, frames, worst, banks, deadline = motionsplice.Preview.running, 0, 0.0, set(), time.monotonic() + PATIENCE
    while frames < LIVE or len(banks) < 2:
        assert time.monotonic() < deadline, motionsplice.Preview.status
        frame = preview.frame
        assert preview.tick() == motionsplice.TICK, motionsplice.Preview.status
        if frame is None or not applied or applied.pop() is not frame["rotations"][-1][0]:
            time.sleep(0.001)  # nothing was shown, or a newer frame that has just arrived
        else:
            frames, banks = frames + 1, banks | {frame["bank"]}
            worst = max(worst, distance(armature, preview.rig["joints"], frame["world_positions"][-1][0]))
            if frames == LIVE // 4:
                print("exchange", flush=True)
            if frames % 250 == 0:  # far from the origin, float32 has fewer digits
                preview.link.send({"do": "place", "id": motionsplice.CHARACTER, "position": [0, 0, 0]})
            if frames == LIVE // 2:
                settings.action = ""
                bpy.ops.motionsplice.preview()
            if frames == 3 * LIVE // 4:
                settings.locomotion, settings.action = "run", "carry_box"
                bpy.ops.motionsplice.preview()
    assert motionsplice.Preview.status == "playing"
    bpy.ops.motionsplice.stop()
    assert preview.tick() is None
    return frames, worst, len(banks)


def refusals():
    """Returns the errors of an unknown clip: of an import, and of a preview."""
    found = []
    try:
        bpy.ops.motionsplice.import_splice()
    except RuntimeError as error:
        found.append(str(error))
    bpy.ops.motionsplice.preview()
    deadline = time.monotonic() + PATIENCE
    while motionsplice.Preview.status == "connected":
        assert time.monotonic() < deadline
        motionsplice.Preview.running.tick()
        time.sleep(0.01)
    return [*found, motionsplice.Preview.status]


main(*sys.argv[1:])
os._exit(0)  # bpy crashes at exit while a timer is registered
