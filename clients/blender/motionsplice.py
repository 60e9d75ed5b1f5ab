"""An add-on for Blender 4.2 and newer: imports splices of a motionsplice service, and plays its characters live.

A splice is imported as GLB by Blender's own importer. The preview receives frames as JSON over a WebSocket
(docs/protocol.md), for which Python's library has no client: `Link` is one.
"""

import base64
import contextlib
import http.client
import json
import os
import queue
import socket
import tempfile
import textwrap
import threading
from urllib.parse import urlencode, urlsplit

import bpy
from mathutils import Quaternion, Vector

bl_info = {
    "name": "motionsplice",
    "description": "Import splices of a motionsplice service, and preview its characters live",
    "author": "The motionsplice authors",
    "version": (0, 2, 0),
    "blender": (4, 2, 0),
    "location": "3D View > Sidebar > motionsplice",
    "category": "Animation",
}
PROTOCOL = 3
PATIENCE = 10.0  # seconds
CONNECTING = 3.0  # seconds; Blender is blocked meanwhile
TICK = 1 / 120  # seconds between two looks for new frames; Blender calls up to 5 ms late
CHARACTER = 1  # the id of the previewed character
NO_TOKEN = "the token is missing or wrong. Enter the token of the service"
TEXT, CLOSE, PING, PONG = 0x1, 0x8, 0x9, 0xA  # opcodes of RFC 6455


class ServiceError(Exception):
    """A request that the service refused, or did not answer."""


def request(address, path, token, expected=200, **headers):
    """Sends a request. Returns the connection and the answer. Raises ServiceError."""
    address = address if "://" in address else f"http://{address}"
    if token:
        headers["Authorization"] = f"Bearer {token}"
    try:
        url = urlsplit(address)
        kind = http.client.HTTPSConnection if url.scheme == "https" else http.client.HTTPConnection
        connection = kind(url.netloc, timeout=CONNECTING)
        connection.connect()
        connection.sock.settimeout(PATIENCE)
        connection.request("GET", url.path.rstrip("/") + path, headers=headers)
        answer = connection.getresponse()
        if answer.status == expected:
            return connection, answer
        with contextlib.closing(connection):
            body = answer.read()
    except (OSError, http.client.HTTPException, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        mend = "Start the service (motionsplice serve BANK), or correct the address"
        raise ServiceError(f"no answer from {address}: {reason}. {mend}") from error
    if answer.status == 401:
        raise ServiceError(NO_TOKEN)
    try:
        detail = str(json.loads(body)["detail"])
    except (ValueError, KeyError, TypeError):
        detail = f"{address} is not a motionsplice service: it answered {answer.status}. Correct the address"
    raise ServiceError(detail)


class Link:
    """A WebSocket that sends and receives JSON. Iterate over it to receive."""

    def __init__(self, address, path, token=""):
        fields = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
        fields["Sec-WebSocket-Key"] = base64.b64encode(os.urandom(16)).decode()
        connection, answer = request(address, path, token, 101, **fields)
        self.socket = connection.sock
        self.answer = answer  # kept, because it would close its file, from which messages are read
        self.lock = threading.Lock()
        self.messages = self._received()
        self.first = next(self.messages, None)  # the welcome, or why there is none
        if self.first is None or self.first["event"] == "refused":
            self.messages.close()
            self.close()
            if self.first is None:
                raise ServiceError(f"{address} closed the connection")
            raise ServiceError(NO_TOKEN if self.first["type"].endswith(":token") else self.first["detail"])

    def send(self, value):
        self._write(TEXT, json.dumps(value).encode())

    def close(self):
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)  # which ends a read of another thread
        self.socket.close()

    def __iter__(self):
        """Yields what arrives until the connection ends."""
        yield self.first
        yield from self.messages

    def _received(self):
        text = b""
        with contextlib.closing(self.answer), contextlib.suppress(OSError):
            while True:
                first, size = self._read(2)
                if size >= 126:
                    size = int.from_bytes(self._read(2 if size == 126 else 8), "big")
                payload, opcode = self._read(size), first & 0xF
                if opcode == CLOSE:
                    return
                if opcode == PING:
                    self._write(PONG, payload)
                elif opcode != PONG:
                    text += payload
                    if first & 0x80:  # the last fragment
                        yield json.loads(text)
                        text = b""

    def _read(self, size):
        data = self.answer.fp.read(size)
        if len(data) < size:
            raise ConnectionError
        return data

    def _write(self, opcode, payload):
        size, mask = len(payload), os.urandom(4)
        head = bytes((size,)) if size < 126 else b"\x7e" + size.to_bytes(2, "big")  # commands have at most 64 KiB
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))
        with self.lock:
            self.socket.sendall(bytes((0x80 | opcode, head[0] | 0x80)) + head[1:] + mask + masked)


def apply(armature, rig, root, rotations):
    """Poses an armature by the names of its bones.

    The service's joints have the world's axes in the bind pose; a bone's rest may have any, and it follows its joint.
    """
    worlds = []
    for (x, y, z, w), parent in zip(rotations, rig["parents"], strict=True):
        own = Quaternion((w, x, y, z))
        worlds.append(own if parent < 0 else worlds[parent] @ own)
    joints = {name: joint for joint, name in enumerate(rig["joints"])}
    rests, turned = {None: Quaternion()}, {None: Quaternion()}  # in the armature's space
    for bone in sorted(armature.data.bones, key=lambda bone: len(bone.parent_recursive)):
        above = bone.parent.name if bone.parent else None
        rest = rests[bone.name] = bone.matrix_local.to_quaternion()
        unposed = turned[above] @ rests[above].inverted() @ rest
        joint = joints.get(bone.name)
        if joint is None:
            turned[bone.name] = unposed
            continue
        turned[bone.name] = worlds[joint] @ rest
        pose = armature.pose.bones[bone.name]
        pose.rotation_mode = "QUATERNION"
        pose.rotation_quaternion = unposed.inverted() @ turned[bone.name]
        if joint == 0:
            pose.location = rest.inverted() @ (Vector(root) - bone.head_local)


class Preview:
    """A character of the service, shown on an armature."""

    running = None
    status = ""

    def __init__(self, armature, address, token):
        self.armature = armature.session_uid  # survives undo and a new name, and is not found in another file
        self.rig = None
        self.created = False
        self.events = queue.SimpleQueue()
        self.frame = None  # the newest one that has not been shown
        self.link = Link(address, "/v1/characters?rate=60&axes=blender&format=json", token)
        threading.Thread(target=self._receive, daemon=True).start()
        Preview.running = self
        self.show("connected")

    def play(self, locomotion, action):
        """Shows a splice: creates the character, or changes what it plays. Raises ServiceError."""
        do = "play" if self.created else "create"
        act = {"do": "act", "id": CHARACTER, "action": action} if action else {"do": "stop", "id": CHARACTER}
        try:
            self.link.send([{"do": do, "id": CHARACTER, "locomotion": locomotion}, act])
        except OSError as error:
            raise ServiceError("the connection was lost. Press Preview again") from error

    def stop(self, status):
        self.link.close()
        Preview.running = None
        self.show(status)

    @staticmethod
    def show(status):
        """Shows a status in the panels, which Blender draws anew only on request."""
        Preview.status = status
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    area.tag_redraw()

    def tick(self):
        """Shows the newest frame. Returns the seconds until the next call; None ends the timer."""
        if Preview.running is not self:
            return None
        armature = next((found for found in bpy.data.objects if found.session_uid == self.armature), None)
        if armature is None:
            self.stop("the armature was deleted, or another file was opened")
        while Preview.running is self and not self.events.empty():
            self._take(self.events.get(), armature.data.bones)
        if Preview.running is not self:
            return None
        if self.rig and self.frame and self.frame["bank"] == self.rig["bank"]:
            frame, self.frame = self.frame, None
            root = frame["root_positions"][-1][0]
            bone = armature.data.bones.get(self.rig["joints"][0])
            if bone is not None and bpy.context.scene.motionsplice.in_place:
                root = (*bone.head_local.xy, root[2])
            apply(armature, self.rig, root, frame["rotations"][-1][0])
        return TICK

    def _take(self, event, bones):
        if event is None:
            self.stop("the connection was lost. Press Preview to connect again")
        elif event["event"] in ("welcome", "bank"):
            self.rig = event
            if event.get("protocol", PROTOCOL) != PROTOCOL:
                self.stop(f"the service has protocol {event['protocol']}, this add-on {PROTOCOL}")
            elif not any(joint in bones for joint in event["joints"]):
                self.stop(f"the armature has none of the bank's joints, such as {event['joints'][0]!r}")
        elif event["event"] == "done":
            self.created = True
            self.show("playing")
        elif event["event"] == "refused":
            self.show(event["detail"])

    def _receive(self):
        for event in self.link:
            if event["event"] == "frames":
                self.frame = event
            else:
                self.events.put(event)
        self.events.put(None)


class Settings(bpy.types.PropertyGroup):
    address: bpy.props.StringProperty(name="Address", default="http://127.0.0.1:8000")
    token: bpy.props.StringProperty(name="Token", subtype="PASSWORD")
    locomotion: bpy.props.StringProperty(name="Locomotion", default="walk")
    action: bpy.props.StringProperty(name="Action", default="carry_box")
    in_place: bpy.props.BoolProperty(
        name="In place", description="Keep the previewed character where its armature stands", default=True
    )


class ImportSplice(bpy.types.Operator):
    """Import a splice as an armature with an action"""

    bl_idname = "motionsplice.import_splice"
    bl_label = "Import splice"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context):
        settings = context.scene.motionsplice
        action = {"action": settings.action} if settings.action else {}
        query = urlencode({"locomotion": settings.locomotion, **action, "format": "glb"})
        try:
            connection, answer = request(settings.address, f"/v1/splice?{query}", settings.token)
            with contextlib.closing(connection):
                splice = answer.read()
        except (ServiceError, OSError, http.client.HTTPException) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "splice.glb")
            with open(path, "wb") as file:
                file.write(splice)
            try:
                return bpy.ops.import_scene.gltf(filepath=path, bone_heuristic="FORTUNE")
            except (AttributeError, RuntimeError):  # it is disabled, or has printed its error
                self.report({"ERROR"}, "Blender's importer failed. Enable the add-on glTF 2.0, or see the console")
                return {"CANCELLED"}


class StartPreview(bpy.types.Operator):
    """Play the splice live on the selected armature"""

    bl_idname = "motionsplice.preview"
    bl_label = "Preview"

    @classmethod
    def poll(cls, context):
        cls.poll_message_set("Select an armature")
        return Preview.running is not None or (context.object is not None and context.object.type == "ARMATURE")

    def execute(self, context):
        settings = context.scene.motionsplice
        try:
            if Preview.running is None:
                preview = Preview(context.object, settings.address, settings.token)
                bpy.app.timers.register(preview.tick, persistent=True)
            Preview.running.play(settings.locomotion, settings.action)
        except ServiceError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class StopPreview(bpy.types.Operator):
    """End the live preview"""

    bl_idname = "motionsplice.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, _context):
        return Preview.running is not None

    def execute(self, _context):
        Preview.running.stop("")
        return {"FINISHED"}


class Panel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_motionsplice"
    bl_label = "motionsplice"
    bl_category = "motionsplice"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context):
        layout, settings = self.layout, context.scene.motionsplice
        layout.use_property_split, layout.use_property_decorate = True, False
        for name in ("address", "token", "locomotion", "action"):
            layout.prop(settings, name)
        layout.operator(ImportSplice.bl_idname)
        layout.prop(settings, "in_place")
        layout.operator(StartPreview.bl_idname, text="Change clips" if Preview.running else "Preview")
        layout.operator(StopPreview.bl_idname)
        lines = layout.column(align=True)
        width = context.region.width / context.preferences.system.ui_scale
        for line in textwrap.wrap(Preview.status, max(int(width / 8), 10)):  # about 8 pixels a character
            lines.label(text=line)


CLASSES = (Settings, ImportSplice, StartPreview, StopPreview, Panel)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.motionsplice = bpy.props.PointerProperty(type=Settings)


def unregister():
    if Preview.running is not None:
        Preview.running.stop("")
    del bpy.types.Scene.motionsplice
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
