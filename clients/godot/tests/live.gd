# Four clients on the service at URL, which compare every frame with the service's world positions through an exchange
# of its bank and a reconnection. Prints a line of JSON when all clients have enough frames of each part, then the
# results. For Godot 3: `godot3-server --path PROJECT -s live.gd`.
extends SceneTree

const Native = preload("addons/motionsplice/native.gd")
const Client = preload("client.gd")
const ENOUGH = 340  # frames of each part: before the exchange, after it, after the reconnection
const PATIENCE = 120.0  # seconds

var clients = []
var stage = 1
var passed = 0.0


func _init():
	Engine.target_fps = 100
	for encoding in ["float32", "int16"]:
		for ahead in [1, 8]:
			var client = Client.new()
			client.url = OS.get_environment("URL")
			client.encoding = encoding
			client.ahead = ahead
			client.connect("event", client, "on_event")
			client.connect("rig_changed", client, "on_rig_changed")
			get_root().add_child(client)
			clients.append(client)


func _idle(delta):
	passed += delta
	if passed > PATIENCE:
		quit(1)
	if stage > 3:
		return false
	for client in clients:
		if client.counts[-1] < ENOUGH or client.counts.size() < stage:
			return false
	stage += 1
	if stage <= 3:
		print(Native.json({"stage": stage}))
		return false
	var results = []
	for client in clients:
		results.append(client.result())
	print(Native.json(results))
	quit()
	return false
