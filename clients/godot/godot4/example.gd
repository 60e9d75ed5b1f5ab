# Shows a character that walks on the spot and carries a box, as small cubes at its joints. No model is needed.
# Set it as the script of a scene's root, a Node3D.
extends Node3D

var _client = preload("motionsplice.gd").new()
var _skeleton = null


func _ready():
	var camera = Camera3D.new()
	add_child(camera)
	camera.look_at_from_position(Vector3(1.5, 1.5, 3), Vector3(0, 1, 0), Vector3.UP)
	add_child(DirectionalLight3D.new())
	_client.event.connect(_on_event)
	_client.rig_changed.connect(_on_rig_changed)
	add_child(_client)


func _on_event(fields):
	if fields.event == "welcome":
		_client.send({"do": "create", "id": 1, "locomotion": "walk", "in_place": true})
		_client.send({"do": "act", "id": 1, "action": "carry_box"})


func _on_rig_changed(rig):
	if _skeleton != null:
		_skeleton.queue_free()
	_skeleton = Skeleton3D.new()
	add_child(_skeleton)
	preload("puppet.gd").build(_skeleton, rig)
	for bone in range(_skeleton.get_bone_count()):
		var joint = BoneAttachment3D.new()
		joint.bone_name = _skeleton.get_bone_name(bone)
		_skeleton.add_child(joint)
		var cube = MeshInstance3D.new()
		cube.mesh = BoxMesh.new()
		cube.scale = Vector3.ONE * 0.06
		joint.add_child(cube)
	_client.attach(1, _skeleton)
