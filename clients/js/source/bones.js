import { RigError } from './errors.js';

/** @import { Rig } from './rig.js' */

/**
 * What this module uses of three.js's Object3D and Bone.
 *
 * @typedef {object} Node
 * @property {string} name
 * @property {{ x: number, y: number, z: number, set(x: number, y: number, z: number): unknown }} position
 * @property {{ x: number, y: number, z: number, w: number, set(x: number, y: number, z: number, w: number): unknown }} quaternion
 * @property {{ x: number, y: number, z: number }} scale
 * @property {Node | null} parent
 * @property {readonly Node[]} children
 * @property {boolean} [isBone]
 */

/** @typedef {Node | { bones: readonly Node[] } | readonly Node[]} Target */

/** @type {WeakMap<object, Bones>} */
const BOUND = new WeakMap();

/**
 * Returns the bones of a target that a rig moves.
 *
 * @param {Rig} rig
 * @param {Target} target
 * @throws {RigError}
 */
export function bind(rig, target) {
  let bones = BOUND.get(target);
  if (bones?.rig !== rig) {
    bones = new Bones(rig, target);
    BOUND.set(target, bones);
  }
  return bones;
}

class Bones {
  /**
   * @param {Rig} rig
   * @param {Target} target
   */
  constructor(rig, target) {
    if (rig.axes !== 'gltf' && rig.axes !== 'godot') throw new RigError(`three.js has the axes gltf, not ${rig.axes}`);
    this.rig = rig;
    const model = 'name' in target ? target : undefined;
    const byName = named(model ? descendants(model) : 'bones' in target ? target.bones : /** @type {readonly Node[]} */ (target));
    const joints = rig.joints.map((name) => byName.get(cleaned(name)));
    const [root] = joints;
    const isMissing = joints.map((bone) => bone === undefined);
    const needed = new Set(); // joints above a bone: without them it would be turned too little
    for (let joint = joints.length - 1; joint > 0; joint--) {
      if (joints[joint] || needed.has(joint)) needed.add(rig.parents[joint]);
    }
    const missing = rig.joints.filter((_, joint) => isMissing[joint] && (joint === 0 || needed.has(joint)));
    if (root === undefined || missing.length) {
      const listed = missing.slice(0, 5).join(', ') + (missing.length > 5 ? ' ...' : '');
      throw new RigError(`no bones are named ${listed}. Build the bank on this character's skeleton`);
    }
    /** The bone of each joint; joints that end a chain may have none. */
    this.joints = joints;
    this.root = root;
    this.above = above(root, model);
  }

  /**
   * @param {ArrayLike<number>} root
   * @param {ArrayLike<number>} rotations
   */
  set(root, rotations) {
    for (let joint = 0, at = 0; joint < this.joints.length; joint++, at += 4) {
      this.joints[joint]?.quaternion.set(rotations[at], rotations[at + 1], rotations[at + 2], rotations[at + 3]);
    }
    const { position, quaternion, scale } = this.above;
    const inverse = [-quaternion[0], -quaternion[1], -quaternion[2], quaternion[3]];
    const [x, y, z] = turned(inverse, [root[0] - position[0], root[1] - position[1], root[2] - position[2]]);
    this.root.position.set(x / scale, y / scale, z / scale);
    const [a, b, c, d] = product(inverse, [rotations[0], rotations[1], rotations[2], rotations[3]]);
    this.root.quaternion.set(a, b, c, d);
  }
}

/**
 * Returns the transform of the nodes between a bone and its model, as Blender's and Mixamo's armatures have, which are
 * scaled and turned. Without a model only bones are taken: what is above them is the game's own.
 *
 * @param {Node} bone
 * @param {Node | undefined} model
 */
function above(bone, model) {
  let position = [0, 0, 0], quaternion = [0, 0, 0, 1], scale = 1;
  for (let node = bone.parent; node && node !== model && (model || node.isBone); node = node.parent) {
    const { x, y, z, w } = node.quaternion;
    const [a, b, c] = turned([x, y, z, w], position);
    const size = node.scale.x;
    position = [node.position.x + size * a, node.position.y + size * b, node.position.z + size * c];
    quaternion = product([x, y, z, w], quaternion);
    scale *= size;
  }
  return { position, quaternion, scale };
}

/**
 * @param {Node} model
 * @returns {Node[]}
 */
function descendants(model) {
  return [model, ...model.children.flatMap(descendants)];
}

/**
 * Returns nodes by name. A bone precedes a mesh of the same name.
 *
 * @param {readonly Node[]} nodes
 */
function named(nodes) {
  /** @type {Map<string, Node>} */
  const found = new Map();
  for (const node of nodes) {
    const name = cleaned(node.name);
    if (!found.has(name) || (node.isBone && !found.get(name)?.isBone)) found.set(name, node);
  }
  return found;
}

/**
 * Returns a name as three.js's loaders change it.
 *
 * @param {string} name
 */
function cleaned(name) {
  return name.replace(/\s/g, '_').replace(/[[\].:/]/g, '');
}

/**
 * @param {number[]} quaternion
 * @param {number[]} vector
 */
function turned([x, y, z, w], [a, b, c]) {
  const u = 2 * (y * c - z * b), v = 2 * (z * a - x * c), t = 2 * (x * b - y * a);
  return [a + w * u + y * t - z * v, b + w * v + z * u - x * t, c + w * t + x * v - y * u];
}

/**
 * @param {number[]} first
 * @param {number[]} second
 */
function product([x, y, z, w], [a, b, c, d]) {
  return [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c];
}
