# What differs between Godot 3 and Godot 4: this file is Godot 4's.


static func now():
	return Time.get_ticks_usec() / 1e6


static func json(value):
	return JSON.stringify(value)


static func parsed(text):
	return JSON.parse_string(text)


static func floats(bytes):
	return bytes.to_float32_array()


# Returns `count` quaternions, the first of which begins at number `begin`.
static func quaternions(numbers, begin, count):
	var found = []
	for i in range(begin, begin + 4 * count, 4):
		found.append(Quaternion(numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]).normalized())
	return found


static func rotation(basis):
	return basis.get_rotation_quaternion()


static func moved(origin):
	return Transform3D(Basis(), origin)


# Sets a bone's transform in its parent's space.
static func set_pose(skeleton, bone, turn, origin):
	skeleton.set_bone_pose_rotation(bone, turn)
	skeleton.set_bone_pose_position(bone, origin)


class Socket:
	const BUFFER = 4194304  # bytes of messages that have not been read yet
	var _peer = WebSocketPeer.new()

	func _init(url, token):
		if token:
			_peer.handshake_headers = PackedStringArray(["Authorization: Bearer " + token])
		_peer.inbound_buffer_size = BUFFER
		_peer.connect_to_url(url)

	# Returns what has arrived: text of events, bytes of frames.
	func messages():
		var found = []
		_peer.poll()
		while _peer.get_available_packet_count() > 0:
			var bytes = _peer.get_packet()
			found.append(bytes.get_string_from_utf8() if _peer.was_string_packet() else bytes)
		return found

	func is_closed():
		return _peer.get_ready_state() == WebSocketPeer.STATE_CLOSED

	func send(text):
		_peer.send_text(text)
