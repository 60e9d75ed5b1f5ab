import { RigError } from './errors.js';
import { restOf } from './rest.js';

/** @import { Rig } from './rig.js' */
/** @import { Bind, Node, Quaternion, Target } from './rest.js' */

/** @type {WeakMap<Rig, WeakMap<object, Bones>>} */
const BOUND = new WeakMap();

/**
 * Returns the bones of a target that a rig moves.
 *
 * @param {Rig} rig
 * @param {Target} target
 * @throws {RigError}
 */
export function bind(rig, target) {
  const targets = BOUND.get(rig) ?? new WeakMap();
  BOUND.set(rig, targets);
  const bones = targets.get(target) ?? new Bones(rig, target);
  targets.set(target, bones);
  return bones;
}

/**
 * One bone: its local rotation is `before` times the joint's times `after`. A joint's axes are those of the world in
 * the bind pose; a bone has its own.
 *
 * @typedef {{ node: Node, before: Quaternion, after: Quaternion }} Bone
 */

class Bones {
  /**
   * @param {Rig} rig
   * @param {Target} target
   */
  constructor(rig, target) {
    if (rig.axes !== 'gltf' && rig.axes !== 'godot') throw new RigError(`three.js has the axes gltf, not ${rig.axes}`);
    const rest = restOf(target);
    const binds = rig.joints.map((name) => rest.find(name));
    const root = binds[0];
    const missing = needed(rig, binds);
    if (root === undefined || missing.length) {
      const listed = missing.slice(0, 5).join(', ') + (missing.length > 5 ? ' ...' : '');
      throw new RigError(`no bones are named ${listed}. Build the bank on this character's skeleton`);
    }
    const above = rest.above(root);
    const place = root.node.position.clone(), turn = root.node.quaternion.clone();
    above.decompose(place, turn, root.node.scale.clone());
    this.root = root.node;
    /** From the world to the parent of the root's bone. */
    this.inwards = above.clone().invert();
    this.unit = unitOf(rig, binds);
    this.place = place;
    /** @type {(Bone | undefined)[]} */
    this.bones = binds.map((one, joint) => one && {
      node: one.node,
      before: joint ? rest.between(/** @type {Bind} */ (binds[rig.parents[joint]]), one).invert() : turn.invert(),
      after: one.turn,
    });
    this.turn = turn.clone();
  }

  /**
   * @param {ArrayLike<number>} root position, metres
   * @param {ArrayLike<number>} rotations
   */
  set(root, rotations) {
    for (let joint = 0, at = 0; joint < this.bones.length; joint++, at += 4) {
      const bone = this.bones[joint];
      if (!bone) continue;
      const { turn } = this;
      turn.set(rotations[at], rotations[at + 1], rotations[at + 2], rotations[at + 3]);
      bone.node.quaternion.copy(turn.premultiply(bone.before).multiply(bone.after));
    }
    this.place.set(this.unit * root[0], this.unit * root[1], this.unit * root[2]);
    this.root.position.copy(this.place.applyMatrix4(this.inwards));
  }
}

/**
 * Returns the names of joints without a bone that need one: the root, and joints above a bone, which would be turned
 * too little. Joints that end a chain need none.
 *
 * @param {Rig} rig
 * @param {(Bind | undefined)[]} binds
 */
function needed(rig, binds) {
  const above = new Set([0]);
  for (let joint = binds.length - 1; joint > 0; joint--) {
    if (binds[joint] || above.has(joint)) above.add(rig.parents[joint]);
  }
  return rig.joints.filter((_, joint) => !binds[joint] && above.has(joint));
}

/**
 * Returns the model's units in a metre, to a power of ten: FBX has centimetres.
 *
 * @param {Rig} rig
 * @param {(Bind | undefined)[]} binds
 */
function unitOf(rig, binds) {
  let theirs = 0, ours = 0;
  for (let joint = 1; joint < binds.length; joint++) {
    const bone = binds[joint], parent = binds[rig.parents[joint]];
    if (!bone || !parent) continue;
    theirs += bone.place.distanceTo(parent.place);
    ours += Math.hypot(...rig.offsets.subarray(3 * joint, 3 * joint + 3));
  }
  return theirs > 0 && ours > 0 ? 10 ** Math.round(Math.log10(theirs / ours)) : 1;
}
