# What differs between Godot 3 and Godot 4: this file is Godot 3's.


static func now():
	return OS.get_ticks_usec() / 1e6


static func json(value):
	return JSON.print(value)


static func parsed(text):
	return JSON.parse(text).result


static func floats(bytes):
	var buffer = StreamPeerBuffer.new()
	buffer.data_array = bytes
	var numbers = PoolRealArray()
	numbers.resize(bytes.size() >> 2)
	for i in range(numbers.size()):
		numbers[i] = buffer.get_float()
	return numbers


# Returns `count` quaternions, the first of which begins at number `begin`.
static func quaternions(numbers, begin, count):
	var found = []
	for i in range(begin, begin + 4 * count, 4):
		found.append(Quat(numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]).normalized())
	return found


static func rotation(basis):
	return basis.get_rotation_quat()


static func moved(origin):
	return Transform(Basis(), origin)


# Sets a bone's transform in its parent's space. Poses of Godot 3 are relative to the rest.
static func set_pose(skeleton, bone, turn, origin):
	var pose = skeleton.get_bone_rest(bone).affine_inverse() * Transform(Basis(turn), origin)
	skeleton.set_bone_pose(bone, pose)


class Socket:
	const BUFFER = 4096  # kB of messages that have not been read yet
	const PACKETS = 2048
	var _client = WebSocketClient.new()

	func _init(url, token):
		var headers = PoolStringArray(["Authorization: Bearer " + token] if token else [])
		_client.set_buffers(BUFFER, PACKETS, 256, PACKETS)
		_client.connect_to_url(url, PoolStringArray(), false, headers)

	# Returns what has arrived: text of events, bytes of frames.
	func messages():
		var found = []
		_client.poll()
		if is_closed():
			return found
		var peer = _client.get_peer(1)
		while peer.get_available_packet_count() > 0:
			var bytes = peer.get_packet()
			found.append(bytes.get_string_from_utf8() if peer.was_string_packet() else bytes)
		return found

	func is_closed():
		return _client.get_connection_status() == WebSocketClient.CONNECTION_DISCONNECTED

	func send(text):
		_client.get_peer(1).set_write_mode(WebSocketPeer.WRITE_MODE_TEXT)
		_client.get_peer(1).put_packet(text.to_utf8())
