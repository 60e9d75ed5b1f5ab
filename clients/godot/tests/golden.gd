# Poses skeletons by the golden files in the folder GOLDEN, and prints how far their bones are from the files' world
# positions, in metres. For Godot 3: `godot3-server --path PROJECT -s golden.gd`.
extends SceneTree

const Message = preload("addons/motionsplice/message.gd")
const Native = preload("addons/motionsplice/native.gd")
const Playback = preload("addons/motionsplice/playback.gd")
const Puppet = preload("addons/motionsplice/puppet.gd")


func _init():
	var folder = OS.get_environment("GOLDEN")
	var rig = Native.parsed(read(folder + "/rig.godot.json").get_string_from_utf8())
	for encoding in ["float32", "int16"]:
		var bytes = read("%s/characters.godot.%s.msgpack" % [folder, encoding])
		var message = Message.read(bytes)
		var ids = Message.ids(message.ids)
		var worlds = Native.floats(message.world_positions)
		var playback = Playback.new()
		playback.take(bytes, 0.0, encoding == "int16")
		for kind in ["plain", "turned"]:
			var model = Spatial.new()
			get_root().add_child(model)
			var skeleton = plain(rig, model) if kind == "plain" else turned(rig, model)
			var puppet = Puppet.new(skeleton, model)
			var worst = 0.0
			var row = 0
			for frame in playback.frames:
				for id in ids:
					puppet.pose(rig, frame.roots[id], frame.rotations[id])
					for joint in range(rig.joints.size()):
						var bone = skeleton.find_bone(Puppet.bone_name(rig.joints[joint]))
						var found = skeleton.global_transform * skeleton.get_bone_global_pose(bone).origin
						var k = 3 * (row * rig.joints.size() + joint)
						worst = max(worst, found.distance_to(Vector3(worlds[k], worlds[k + 1], worlds[k + 2])))
					row += 1
			var fields = {"encoding": encoding, "kind": kind, "worst": worst, "ids": ids, "poses": row}
			print(Native.json(fields))
	quit()


static func read(path):
	var file = File.new()
	assert(file.open(path, File.READ) == OK)
	return file.get_buffer(file.get_len())


static func plain(rig, model):
	var skeleton = Skeleton.new()
	model.add_child(skeleton)
	Puppet.build(skeleton, rig)
	return skeleton


# A skeleton as exporters write it: below a turned node, in centimetres, with axes of its own in each bone, a bone above
# the root, and one between the root and each of its children.
static func turned(rig, model):
	var skeleton = Skeleton.new()
	skeleton.transform = Transform(Basis(Vector3(-PI / 2, 0, 0)).scaled(Vector3.ONE * 0.01), Vector3(0.5, 0, 0))
	model.add_child(skeleton)
	var inverse = skeleton.transform.affine_inverse()
	var binds = [Transform(inverse.basis, inverse * Vector3(0.1, 0.2, 0.3)).orthonormalized()]
	skeleton.add_bone("top")
	skeleton.set_bone_rest(0, binds[0])
	var places = []
	for joint in range(rig.joints.size()):
		var parent = int(rig.parents[joint])
		var offset = rig.offsets[joint]
		var place = Vector3(offset[0], offset[1], offset[2])
		if parent >= 0:
			place += places[parent]
		places.append(place)
		var above = 0 if parent < 0 else skeleton.find_bone(Puppet.bone_name(rig.joints[parent]))
		if parent == 0:
			above = add(skeleton, "between_%d" % joint, above, binds, inverse * places[0])
		add(skeleton, Puppet.bone_name(rig.joints[joint]), above, binds, inverse * place)
	return skeleton


static func add(skeleton, name, parent, binds, place):
	var bone = skeleton.get_bone_count()
	var axes = Basis(Vector3(bone, 0.3 * bone, -0.7 * bone))
	binds.append(Transform(axes, place))
	skeleton.add_bone(name)
	skeleton.set_bone_parent(bone, parent)
	skeleton.set_bone_rest(bone, binds[parent].affine_inverse() * binds[bone])
	return bone
