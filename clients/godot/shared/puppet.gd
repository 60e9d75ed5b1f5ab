# Poses a Skeleton (Godot 3) or Skeleton3D (Godot 4) by the names of its bones. Both versions share this file.
# The service's joints have the world's axes in the bind pose. A bone's rest may have any, and it follows its joint.

const Native = preload("native.gd")

var _skeleton
var _model
var _bank = ""
var _root = -1  # the bone of joint 0
var _order = []  # bones, parents first
var _joints = []  # of each bone; -1: none
var _rests = []  # rotation of each bone at rest, in the model's space
var _from_model  # to the skeleton's space
var _turn  # rotation from the skeleton's space to the model's


# `model` is the node in whose space the service's axes and metres are: the root of the imported scene.
func _init(skeleton, model):
	_skeleton = skeleton
	_model = model


# Poses the skeleton. `rig` is the event `welcome` or `bank`.
func pose(rig, root, rotations):
	if rig.bank != _bank:
		_bind(rig)
	var worlds = []
	for joint in range(rotations.size()):
		var parent = int(rig.parents[joint])
		worlds.append(rotations[joint] if parent < 0 else worlds[parent] * rotations[joint])
	var turned = []
	turned.resize(_order.size())
	for bone in _order:
		var parent = _skeleton.get_bone_parent(bone)
		var above = _turn if parent < 0 else turned[parent]
		var rest = _skeleton.get_bone_rest(bone)
		if _joints[bone] < 0:
			turned[bone] = above * Native.rotation(rest.basis)
			continue
		turned[bone] = worlds[_joints[bone]] * _rests[bone]
		var origin = rest.origin
		if bone == _root:
			origin = _from_model * root
			if parent >= 0:
				origin = _skeleton.get_bone_global_pose(parent).affine_inverse() * origin
		Native.set_pose(_skeleton, bone, above.inverse() * turned[bone], origin)


# Adds a bone for each joint of a rig to an empty skeleton.
static func build(skeleton, rig):
	for joint in range(rig.joints.size()):
		var offset = rig.offsets[joint]
		skeleton.add_bone(bone_name(rig.joints[joint]))
		skeleton.set_bone_parent(joint, int(rig.parents[joint]))
		skeleton.set_bone_rest(joint, Native.moved(Vector3(offset[0], offset[1], offset[2])))


# Returns the name that Godot's importer gives a joint's bone.
static func bone_name(joint):
	return joint.replace(":", "_").replace("/", "_")


func _bind(rig):
	var count = _skeleton.get_bone_count()
	var to_model = _model.global_transform.affine_inverse() * _skeleton.global_transform
	_bank = rig.bank
	_from_model = to_model.affine_inverse()
	_turn = Native.rotation(to_model.basis)
	_joints = []
	for bone in range(count):
		_joints.append(-1)
	for joint in range(rig.joints.size()):
		var bone = _skeleton.find_bone(bone_name(rig.joints[joint]))
		if bone >= 0:
			_joints[bone] = joint
	_root = _joints.find(0)
	if _root < 0:
		var names = [_skeleton.name, bone_name(rig.joints[0])]
		push_error("motionsplice: %s has no bone '%s'. Build the bank for this model: --skeleton MODEL" % names)
	_order = []
	while _order.size() < count:
		for bone in range(count):
			var parent = _skeleton.get_bone_parent(bone)
			if not _order.has(bone) and (parent < 0 or _order.has(parent)):
				_order.append(bone)
	_rests = []
	_rests.resize(count)
	for bone in _order:
		var parent = _skeleton.get_bone_parent(bone)
		var above = _turn if parent < 0 else _rests[parent]
		_rests[bone] = above * Native.rotation(_skeleton.get_bone_rest(bone).basis)
