# Shows a character that walks on the spot and carries a box, as small cubes at its joints. No model is needed.
# Set it as the script of a scene's root, a Spatial.
extends Spatial

var _client = preload("motionsplice.gd").new()
var _skeleton = null


func _ready():
	var camera = Camera.new()
	add_child(camera)
	camera.look_at_from_position(Vector3(1.5, 1.5, 3), Vector3(0, 1, 0), Vector3.UP)
	add_child(DirectionalLight.new())
	_client.connect("event", self, "_on_event")
	_client.connect("rig_changed", self, "_on_rig_changed")
	add_child(_client)


func _on_event(fields):
	if fields.event == "welcome":
		_client.send({"do": "create", "id": 1, "locomotion": "walk", "in_place": true})
		_client.send({"do": "act", "id": 1, "action": "carry_box"})


func _on_rig_changed(rig):
	if _skeleton != null:
		_skeleton.queue_free()
	_skeleton = Skeleton.new()
	add_child(_skeleton)
	preload("puppet.gd").build(_skeleton, rig)
	for bone in range(_skeleton.get_bone_count()):
		var joint = BoneAttachment.new()
		joint.bone_name = _skeleton.get_bone_name(bone)
		_skeleton.add_child(joint)
		var cube = MeshInstance.new()
		cube.mesh = CubeMesh.new()
		cube.scale = Vector3.ONE * 0.03
		joint.add_child(cube)
	_client.attach(1, _skeleton)
