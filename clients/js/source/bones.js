import { RigError } from './errors.js';
import { restOf } from './rest.js';

/** @import { Rig } from './rig.js' */
/** @import { Bind, Matrix, Node, Quaternion, Target } from './rest.js' */

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
 * A bone that hangs on its parent joint's: its local rotation is `before` times the joint's times `after`. A joint's
 * axes are those of the world in the bind pose; a bone has its own.
 *
 * @typedef {{ node: Node, before: Quaternion, after: Quaternion }} Bone
 */

/**
 * A bone that hangs on none that moves, as the root's does, and feet that are IK targets: it is placed in the world.
 *
 * @typedef {Bone & { joint: number, inwards: Matrix, isCarried: boolean }} Free
 */

/**
 * A bone of the skin above the root's, on the ground: it goes where the root goes, unturned, and carries free bones.
 *
 * @typedef {Bind & { below: Bind, inwards: Matrix }} Base
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
    this.rig = rig;
    this.unit = unitOf(rig, binds);
    this.turn = root.turn.clone();
    this.place = root.place.clone();
    this.places = new Float32Array(3 * binds.length);
    /** @type {(Bone | undefined)[]} by joint */
    this.bones = [];
    /** @type {Free[]} */
    this.free = [];
    this.base = baseOf(rest, root);
    const moved = new Set(binds.flatMap((one) => one?.node ?? []));
    binds.forEach((bone, joint) => {
      if (!bone) return;
      const parent = binds[rig.parents[joint]];
      const held = holder(bone.node, moved);
      if (held === undefined) {
        const inwards = rest.above(bone).invert();
        const before = bone.turn.clone();
        inwards.decompose(bone.place.clone(), before, bone.node.scale.clone());
        const isCarried = this.base !== undefined && holder(bone.node, new Set([this.base.node])) !== undefined;
        this.free.push({ joint, node: bone.node, inwards, before, after: bone.turn, isCarried });
      } else if (held === parent?.node) {
        this.bones[joint] = { node: bone.node, before: rest.between(parent, bone).invert(), after: bone.turn };
      } else {
        throw new RigError(`the bone ${bone.node.name} hangs on ${held.name}, but its joint on ${parent?.node.name}`);
      }
    });
  }

  /**
   * @param {ArrayLike<number>} root position, metres
   * @param {ArrayLike<number>} rotations
   */
  set(root, rotations) {
    const { rig, turn, place, places, unit, base } = this;
    this.bones.forEach((bone, joint) => {
      if (!bone) return;
      const at = 4 * joint;
      turn.set(rotations[at], rotations[at + 1], rotations[at + 2], rotations[at + 3]);
      bone.node.quaternion.copy(turn.premultiply(bone.before).multiply(bone.after));
    });
    const x = base ? unit * root[0] - base.below.place.x : 0, z = base ? unit * root[2] - base.below.place.z : 0;
    if (base) {
      place.set(base.place.x + x, base.place.y, base.place.z + z);
      base.node.position.copy(place.applyMatrix4(base.inwards));
    }
    const turns = rig.worldPositions(root, rotations, places);
    for (const { joint, node, inwards, before, after, isCarried } of this.free) {
      turn.set(turns[4 * joint], turns[4 * joint + 1], turns[4 * joint + 2], turns[4 * joint + 3]);
      node.quaternion.copy(turn.premultiply(before).multiply(after));
      place.set(unit * places[3 * joint], unit * places[3 * joint + 1], unit * places[3 * joint + 2]);
      if (isCarried) place.set(place.x - x, place.y, place.z - z);
      node.position.copy(place.applyMatrix4(inwards));
    }
  }
}

/**
 * Returns the highest bone of the skin above the root's, or undefined.
 *
 * @param {ReturnType<typeof restOf>} rest
 * @param {Bind} root
 * @returns {Base | undefined}
 */
function baseOf(rest, root) {
  let bind;
  for (let one = root.node.parent; one; one = one.parent) if (rest.inverses.has(one)) bind = rest.find(one.name);
  return bind && { ...bind, below: root, inwards: rest.above(bind).invert() };
}

/**
 * Returns the next node above a bone that moves, or undefined.
 *
 * @param {Node} bone
 * @param {Set<Node>} moved
 */
function holder(bone, moved) {
  let above = bone.parent;
  while (above && !moved.has(above)) above = above.parent;
  return above ?? undefined;
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
