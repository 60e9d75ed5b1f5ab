# Reads the MessagePack of frames (docs/protocol.md, "Frames"). Godot 3 and 4 share this file.


# Returns the map of a message. Its arrays are bytes.
static func read(bytes):
	var buffer = StreamPeerBuffer.new()
	buffer.big_endian = true
	buffer.data_array = bytes
	return _value(buffer)


# Returns int16 numbers as numbers from -1 to 1.
static func shorts(bytes):
	var buffer = StreamPeerBuffer.new()
	buffer.data_array = bytes
	var numbers = []
	for _i in range(bytes.size() >> 1):
		numbers.append(max(buffer.get_16() / 32767.0, -1.0))
	return numbers


# Returns uint32 numbers.
static func ids(bytes):
	var buffer = StreamPeerBuffer.new()
	buffer.data_array = bytes
	var numbers = []
	for _i in range(bytes.size() >> 2):
		numbers.append(buffer.get_u32())
	return numbers


static func _value(buffer):
	var head = buffer.get_u8()
	if head < 0x80:
		return head
	if head < 0x90:
		return _map(buffer, head & 0x0f)
	if head >= 0xa0 and head < 0xc0:
		return buffer.get_utf8_string(head & 0x1f)
	match head:
		0xc6:
			return buffer.get_data(buffer.get_u32())[1]
		0xcb:
			return buffer.get_double()
		0xcc:
			return buffer.get_u8()
		0xcd:
			return buffer.get_u16()
		0xce:
			return buffer.get_u32()
		0xcf:
			return buffer.get_u64()
		0xd9:
			return buffer.get_utf8_string(buffer.get_u8())
		0xda:
			return buffer.get_utf8_string(buffer.get_u16())
		0xde:
			return _map(buffer, buffer.get_u16())
	push_error("motionsplice: unexpected byte %d in a message. Is the service newer than this add-on?" % head)
	return null


static func _map(buffer, count):
	var map = {}
	for _i in range(count):
		var key = _value(buffer)
		map[key] = _value(buffer)
	return map
