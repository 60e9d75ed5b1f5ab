# Holds frames, and says what to show between them (docs/protocol.md, "Between frames"). Godot 3 and 4 share this file.
# A frame is {number, due, bank, roots: {id: Vector3}, rotations: {id: [quaternion of each joint]}}.

const Message = preload("message.gd")
const Native = preload("native.gd")

const WINDOW = 10.0  # seconds of samples of the clocks' offset
const PUNCTUAL = 0.99  # part of the messages for which the delay is long enough
const FOLLOW = 0.05  # by how much the delay changes per second
const GAP = 0.25  # seconds: across longer gaps nothing is interpolated

var delay = 0.1
var frames = []
var _interval = 0.0
var _offset = 0.0
var _lateness = 0.0
var _arrivals = []
var _samples = []
var _jumps = {}


# Takes a message that has arrived `now`. `short` is whether its rotations are int16.
func take(bytes, now, short):
	var message = Message.read(bytes)
	_interval = 1.0 / message.rate
	if frames.size() == 0 or message.frame > frames[-1].number:
		_sample(now, now - message.time)
	while frames.size() > 0 and frames[-1].number >= message.frame:
		frames.pop_back()  # a command has changed it
	var ids = Message.ids(message.ids)
	var roots = Native.floats(message.root_positions)
	var numbers = Message.shorts(message.rotations) if short else Native.floats(message.rotations)
	var joints = int(numbers.size() / (4 * message.count * ids.size()))
	var row = 0
	for i in range(message.count):
		var due = message.time + i * _interval
		var frame = {number = message.frame + i, due = due, bank = message.bank, roots = {}, rotations = {}}
		for id in ids:
			frame.roots[id] = Vector3(roots[3 * row], roots[3 * row + 1], roots[3 * row + 2])
			frame.rotations[id] = Native.quaternions(numbers, 4 * row * joints, joints)
			row += 1
		frames.append(frame)


# Notes that characters jump at a frame, into which they are not interpolated.
func jump(number, ids):
	_jumps[number] = ids


# Returns what to show `now`, `passed` seconds after the last picture: frames a and b, and the weight w of b.
# Returns null before the first frame.
func at(now, passed):
	if frames.size() == 0:
		return null
	delay += clamp(_interval + _lateness - delay, -FOLLOW * passed, FOLLOW * passed)
	var moment = now - _offset - delay
	while frames.size() > 1 and frames[1].due <= moment:
		frames.pop_front()
	var a = frames[0]
	for number in _jumps.keys():
		if number <= a.number:
			_jumps.erase(number)
	if frames.size() == 1:
		return {a = a, b = a, w = 0.0}
	var b = frames[1]
	if a.bank != b.bank or b.due - a.due > GAP:
		return {a = a, b = a, w = 0.0}
	return {a = a, b = b, w = clamp((moment - a.due) / (b.due - a.due), 0.0, 1.0)}


# Returns the root's position and the joints' rotations of a character in what `at` returned; null if it is not there.
func pose(picture, id):
	var a = picture.a
	var b = picture.b
	if not a.roots.has(id):
		return null
	if picture.w == 0.0 or not b.roots.has(id) or _jumps_between(a.number, b.number, id):
		return [a.roots[id], a.rotations[id]]
	var root = a.roots[id] + (b.roots[id] - a.roots[id]) * picture.w
	var rotations = []
	for joint in range(a.rotations[id].size()):
		var from = a.rotations[id][joint]
		var to = b.rotations[id][joint]
		if from.dot(to) < 0.0:
			to = -to
		rotations.append((from + (to - from) * picture.w).normalized())
	return [root, rotations]


func _sample(now, sample):
	_arrivals.append(now)
	_samples.append(sample)
	while now - _arrivals[0] > WINDOW:
		_arrivals.pop_front()
		_samples.pop_front()
	var sorted = _samples.duplicate()
	sorted.sort()
	_offset = sorted[0]
	_lateness = sorted[int(PUNCTUAL * (sorted.size() - 1))] - _offset


func _jumps_between(first, last, id):
	for number in _jumps:
		if first < number and number <= last and _jumps[number].has(id):
			return true
	return false
