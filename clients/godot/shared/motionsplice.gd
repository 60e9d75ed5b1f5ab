# A connection to the characters of a service (docs/protocol.md). Godot 3 and 4 share this file.
extends Node
class_name MotionSplice

signal event(fields)  # any event of the service; `welcome` again after each new connection, which has no characters yet
signal rig_changed(rig)  # before the first picture, and before the first one of another bank

const Native = preload("native.gd")
const Playback = preload("playback.gd")
const Puppet = preload("puppet.gd")
const PROTOCOL = 3
const FIRST_WAIT = 0.5  # seconds until a lost connection is opened again; each time twice as many
const LONGEST_WAIT = 8.0
const SILENCE = 8.0  # seconds without frames after which a connection that shows characters is lost

# To be set before the node enters the tree.
var url = "ws://127.0.0.1:8000"
var token = ""
var rate = 60
var ahead = 1
var encoding = "float32"

var rig = null  # the rig of what is shown: the event `welcome` or `bank`
var _playback = Playback.new()
var _puppets = {}
var _rigs = {}
var _places = {}  # ids that a command places, by its ref
var _socket = null
var _short = false
var _welcomed = false
var _ref = 0
var _wait = FIRST_WAIT
var _waited = 0.0  # seconds since the connection was lost, or since the last frames


func _ready():
	_open()


# Sends a command, or a list of commands. Returns the ref that the reply, an event, repeats.
# Returns null without a connection.
func send(command):
	if not _welcomed:
		return null
	var commands = command if typeof(command) == TYPE_ARRAY else [command]
	var places = []
	for one in commands:
		if one.do == "place":
			places += one.id if typeof(one.id) == TYPE_ARRAY else [one.id]
	_ref += 1
	commands[0].ref = _ref
	_places[_ref] = places
	_socket.send(Native.json(commands))
	return _ref


# Shows a character on a Skeleton or Skeleton3D, from now on. `model` is the root of the imported scene: the node in
# whose space the character moves. Without it, that is the skeleton.
func attach(id, skeleton, model = null):
	_puppets[id] = Puppet.new(skeleton, skeleton if model == null else model)


func detach(id):
	_puppets.erase(id)


func _process(passed):
	_waited += passed
	if _socket == null:
		if _waited >= _wait:
			_wait = min(2.0 * _wait, LONGEST_WAIT)
			_open()
	else:
		_receive()
	_show(passed)


func _open():
	_waited = 0.0
	_socket = Native.Socket.new(_address(), token)


func _receive():
	for message in _socket.messages():
		if typeof(message) == TYPE_STRING:
			_take_event(Native.parsed(message))
		else:
			_take_frames(message)
	var is_silent = _waited > SILENCE and _puppets.size() > 0 and _playback.frames.size() > 0
	if _socket.is_closed() or is_silent:
		push_warning("motionsplice: no connection to %s. Trying again in %s s" % [url, _wait])
		_socket = null
		_welcomed = false
		_waited = 0.0


func _take_event(fields):
	match fields.event:
		"welcome":
			if fields.protocol != PROTOCOL:
				push_error("motionsplice: the service has protocol %s, this add-on %s" % [fields.protocol, PROTOCOL])
			_playback = Playback.new()
			_places = {}
			_short = fields.encoding == "int16"
			_wait = FIRST_WAIT
			_rigs = {fields.bank: fields}
			_welcomed = true
		"bank":
			_rigs[fields.bank] = fields
		"done":
			var ids = _places.get(int(fields.ref), [])
			if ids.size() > 0:
				_playback.jump(int(fields.frame), ids)
			_places.erase(int(fields.ref))
		"refused":
			push_warning("motionsplice: %s" % fields.detail)
			if fields.ref != null:
				_places.erase(int(fields.ref))
	emit_signal("event", fields)


func _take_frames(bytes):
	_waited = 0.0
	_playback.take(bytes, Native.now(), _short)


func _show(passed):
	var picture = _playback.at(Native.now(), passed)
	if picture == null:
		return
	if rig == null or rig.bank != picture.a.bank:
		rig = _rigs[picture.a.bank]
		emit_signal("rig_changed", rig)
	for id in _puppets:
		var found = _playback.pose(picture, id)
		if found != null:
			_puppets[id].pose(rig, found[0], found[1])


func _address():
	return "%s/v1/characters?axes=godot&rate=%s&ahead=%s&encoding=%s" % [url, rate, ahead, encoding]
