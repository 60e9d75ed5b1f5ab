# A client that compares each frame with the service's world positions, and what it shows with what it should show.
extends "addons/motionsplice/motionsplice.gd"

const JUMP = 4.0
const Message = preload("addons/motionsplice/message.gd")

var counts = [0]  # frames of each part: a part ends with a bank or a connection
var worst = 0.0  # distance of a frame's bones from the service's world positions, in metres
var farthest = 0.0  # the largest distance of such a position from the origin
var shown = 0  # pictures
var jumps = 0  # pictures at which character 2 was at its new place, JUMP metres away
var parts_of_jumps = 0  # pictures that show it on the way
var banks = []
var events = {}
var log_of_playback = []  # messages and pictures, as a twin can replay them
var _own_rig
var _skeleton
var _puppet
var _twin = Playback.new()
var _before = null


func on_event(fields):
	events[fields.event] = events.get(fields.event, 0) + 1
	if fields.event == "welcome" or fields.event == "bank":
		_own_rig = fields
		banks.append(fields.bank)
		if counts[-1] > 0:
			counts.append(0)
		var skeleton = Skeleton.new()
		add_child(skeleton)
		Puppet.build(skeleton, fields)
		_puppet = Puppet.new(skeleton, skeleton)
		_skeleton = skeleton
	if fields.event == "welcome":
		_before = null
		send([
			{"do": "create", "id": 1, "locomotion": "walk"},
			{"do": "create", "id": [2, 4294967295], "locomotion": {"walk": 1, "run": 2}, "position": [3, 0, 1]},
			{"do": "speed", "id": 2, "speed": 0.25},
			{"do": "in_place", "id": 4294967295, "in_place": true},
			{"do": "act", "id": 2, "action": "wave", "when": "phase"},
		])
		send({"do": "create", "id": 9, "locomotion": "wlak"})


func on_rig_changed(rig):
	var skeleton = Skeleton.new()
	add_child(skeleton)
	Puppet.build(skeleton, rig)
	attach(1, skeleton)


func result():
	return {
		"encoding": encoding, "ahead": ahead, "counts": counts, "worst": worst, "banks": banks, "events": events,
		"shown": shown, "farthest": farthest, "jumps": jumps, "parts_of_jumps": parts_of_jumps, "log": log_of_playback, "delay": _playback.delay,
	}


func _address():
	return ._address() + "&parts=both"


func _take_frames(bytes):
	._take_frames(bytes)
	var message = Message.read(bytes)
	var ids = Message.ids(message.ids)
	var worlds = Native.floats(message.world_positions)
	var frames = _playback.frames
	var joints = _own_rig.joints.size()
	for i in range(message.count):
		var frame = frames[frames.size() - message.count + i]
		for row in range(ids.size()):
			_puppet.pose(_own_rig, frame.roots[ids[row]], frame.rotations[ids[row]])
			for joint in range(joints):
				var k = 3 * ((i * ids.size() + row) * joints + joint)
				var place = Vector3(worlds[k], worlds[k + 1], worlds[k + 2])
				farthest = max(farthest, place.length())
				worst = max(worst, _skeleton.get_bone_global_pose(joint).origin.distance_to(place))
	if counts[-1] < 100 and counts[-1] + message.count >= 100:
		var root = frames[-1].roots[2]
		var side = -1 if root.x > 0 else 1
		send({"do": "place", "id": 2, "position": [root.x + side * JUMP, 0, root.z]})
	counts[-1] += message.count
	if log_of_playback.size() < 400 and counts.size() == 1:
		var now = Native.now()
		_twin.take(bytes, now, _short)
		log_of_playback.append({"now": now, "message": Marshalls.raw_to_base64(bytes)})


func _show(passed):
	._show(passed)
	var picture = _playback.at(Native.now(), 0.0)
	if picture == null:
		return
	shown += 1
	var placed = _playback.pose(picture, 2)
	if placed != null:
		if _before != null:
			var moved = placed[0].distance_to(_before)
			jumps += int(moved > JUMP - 1)
			parts_of_jumps += int(moved > 1 and moved < JUMP - 1)
		_before = placed[0]
	if log_of_playback.size() < 400 and counts.size() == 1:
		var now = Native.now()
		var twins = _twin.at(now, passed)
		var found = null if twins == null else _twin.pose(twins, 1)
		if found != null:
			var turn = found[1][5]
			log_of_playback.append({
				"now": now, "passed": passed, "root": [found[0].x, found[0].y, found[0].z],
				"turn": [turn.x, turn.y, turn.z, turn.w], "delay": _twin.delay,
			})
