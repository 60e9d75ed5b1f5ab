/**
 * What this module uses of three.js.
 *
 * @typedef {{ x: number, y: number, z: number, set(x: number, y: number, z: number): unknown, clone(): Vector,
 *   copy(other: Vector): unknown, applyMatrix4(matrix: Matrix): Vector, distanceTo(other: Vector): number }} Vector
 * @typedef {{ x: number, y: number, z: number, w: number, set(x: number, y: number, z: number, w: number): unknown,
 *   clone(): Quaternion, identity(): Quaternion, copy(other: Quaternion): unknown, invert(): Quaternion, multiply(other: Quaternion): Quaternion,
 *   premultiply(other: Quaternion): Quaternion }} Quaternion
 * @typedef {{ clone(): Matrix, identity(): Matrix, invert(): Matrix, multiply(other: Matrix): Matrix, premultiply(other: Matrix): Matrix,
 *   decompose(position: Vector, quaternion: Quaternion, scale: Vector): unknown }} Matrix
 * @typedef {{ bones: readonly Node[], boneInverses: readonly Matrix[] }} Skeleton
 *
 * @typedef {object} Node an Object3D
 * @property {string} name
 * @property {Vector} position
 * @property {Quaternion} quaternion
 * @property {Vector} scale
 * @property {Matrix} matrix
 * @property {() => void} updateMatrix
 * @property {Node | null} parent
 * @property {readonly Node[]} children
 * @property {boolean} [isBone]
 * @property {Skeleton} [skeleton] of a SkinnedMesh
 */

/** @typedef {Node | Skeleton | readonly Node[]} Target a model, a skeleton, or bones in their bind pose */

/** @typedef {{ node: Node, place: Vector, turn: Quaternion, matrix: Matrix }} Bind a bone's transform in the bind pose */

/** @type {WeakMap<object, Rest>} */
const RESTS = new WeakMap();

/**
 * Returns a target at rest: as it was when it was posed for the first time.
 *
 * @param {Target} target
 */
export function restOf(target) {
  const rest = RESTS.get(target) ?? new Rest(target);
  RESTS.set(target, rest);
  return rest;
}

class Rest {
  /** @param {Target} target */
  constructor(target) {
    this.model = 'name' in target ? target : undefined;
    const nodes = this.model ? descendants(this.model)
      : 'bones' in target ? target.bones : /** @type {readonly Node[]} */ (target);
    const skeletons = 'bones' in target ? [target] : nodes.flatMap((node) => node.skeleton ?? []);
    /** @type {Map<Node, { matrix: Matrix, turn: Quaternion }>} */
    this.locals = new Map();
    for (const node of nodes) {
      for (let one = /** @type {Node | null} */ (node); one && one !== this.model && !this.locals.has(one); one = one.parent) {
        one.updateMatrix();
        this.locals.set(one, { matrix: one.matrix.clone(), turn: one.quaternion.clone() });
      }
    }
    /** @type {Map<Node, Matrix>} */
    this.inverses = new Map(skeletons.flatMap(({ bones, boneInverses }) => bones.map((bone, at) => [bone, boneInverses[at]])));
    /** @type {Map<string, Node>} */
    this.nodes = new Map();
    for (const node of nodes) {
      const name = cleaned(node.name);
      if (!this.nodes.has(name) || (node.isBone && !this.nodes.get(name)?.isBone)) this.nodes.set(name, node);
    }
  }

  /**
   * Returns a bone in the bind pose: that of its skin, or else at rest.
   *
   * @param {string} name
   * @returns {Bind | undefined}
   */
  find(name) {
    const node = this.nodes.get(cleaned(name));
    if (!node) return undefined;
    const matrix = this.inverses.get(node)?.clone().invert() ?? this.world(node);
    const place = node.position.clone(), turn = node.quaternion.clone();
    matrix.decompose(place, turn, node.scale.clone());
    return { node, place, turn, matrix };
  }

  /**
   * Returns the transform of what is above a bone that hangs on no other joint's: armatures of Blender and Mixamo, for
   * example, are scaled and turned. Without a model it is what the bind pose has there.
   *
   * @param {Bind} bone
   */
  above({ node, matrix }) {
    if (this.model && node.parent && node !== this.model) return this.world(node.parent);
    return matrix.clone().multiply(this.local(node).clone().invert());
  }

  /**
   * Returns the turn in the bind pose of what a bone hangs on: its parent joint's bone, or others that move with it.
   *
   * @param {Bind} parent
   * @param {Bind} bone
   */
  between(parent, bone) {
    const turn = bone.turn.clone().identity();
    for (let one = bone.node.parent; one && one !== parent.node; one = one.parent) {
      turn.premultiply(this.locals.get(one)?.turn ?? one.quaternion);
    }
    return turn.premultiply(parent.turn);
  }

  /** @param {Node} node */
  world(node) {
    const matrix = this.local(node).clone();
    for (let one = node.parent; one && this.locals.has(one) && (this.model || one.isBone); one = one.parent) {
      matrix.premultiply(this.local(one));
    }
    return matrix;
  }

  /** @param {Node} node */
  local(node) {
    return this.locals.get(node)?.matrix ?? node.matrix.clone().identity();
  }
}

/**
 * @param {Node} model
 * @returns {Node[]}
 */
function descendants(model) {
  return [model, ...model.children.flatMap(descendants)];
}

/**
 * Returns a name as three.js's loaders change it.
 *
 * @param {string} name
 */
function cleaned(name) {
  return name.replace(/\s/g, '_').replace(/[[\].:/]/g, '');
}
