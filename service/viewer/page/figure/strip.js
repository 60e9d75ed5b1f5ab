import { CharacterError, FLOAT, writeGlb } from './glb.js';

/** @import { Document } from './glb.js' */

const MATRIX = 64; // bytes of an inverse bind matrix
const BODY = 13; // joints: a root, and three in each limb

/**
 * Returns the rig of a character: its nodes, its skins and who it says its bones are. Meshes, materials, pictures, animations
 * and everything else is left out.
 *
 * @param {Document} document
 * @param {Uint8Array} binary
 * @returns {{ rig: Uint8Array, nodes: number[] }} a GLB file, and the number in `document` of each of its nodes
 * @throws {CharacterError}
 */
export function strip(document, binary) {
  try {
    return stripped(document, binary);
  } catch (error) {
    throw error instanceof CharacterError ? error : new CharacterError('The file is damaged: its skeleton cannot be read.');
  }
}

/**
 * @param {Document} document
 * @param {Uint8Array} binary
 */
function stripped(document, binary) {
  const { nodes = [], skins = [] } = document;
  if (!skins.length) throw new CharacterError('It has no skin: no bones move its mesh. Export the mesh with its armature.');
  const parents = parentsOf(nodes);
  const joints = new Set([...skins.flatMap((/** @type {any} */ skin) => skin.joints), ...humanNodes(document)]);
  for (const joint of joints) if (!(joint in nodes)) throw new Error('not a node');
  checkOneBody(parents, joints);
  const kept = needed(nodes, parents, joints);
  const places = new Map(kept.map((node, place) => [node, place]));
  const matrices = new Matrices(document, binary);
  const rig = {
    asset: { version: '2.0' },
    nodes: kept.map((node) => rigNode(nodes[node], places)),
    skins: unique(skins.map((/** @type {any} */ { joints, inverseBindMatrices }) => ({
      joints: joints.map((/** @type {number} */ joint) => places.get(joint)),
      ...(inverseBindMatrices !== undefined && { inverseBindMatrices: matrices.of(inverseBindMatrices) }),
    }))),
    extensions: humanoid(document, places),
    ...matrices.parts,
  };
  return { rig: writeGlb(rig, matrices.bytes), nodes: kept };
}

/** @param {any[]} nodes */
function parentsOf(nodes) {
  const parents = new Int32Array(nodes.length).fill(-1);
  nodes.forEach(({ children = [] }, node) => {
    for (const child of children) {
      if (!(child >= 0 && child < nodes.length) || parents[child] >= 0 || child === node) throw new Error('not a tree');
      parents[child] = node;
    }
  });
  return parents;
}

/**
 * Returns the nodes that matter: joints, what is above them, and below them what is not a mesh, as the tips of bones.
 *
 * @param {any[]} nodes
 * @param {Int32Array} parents
 * @param {Set<number>} joints
 */
function needed(nodes, parents, joints) {
  const above = new Set(joints);
  for (const joint of joints) {
    for (let node = parents[joint]; node >= 0 && !above.has(node); node = parents[node]) above.add(node);
  }
  const isTip = (/** @type {number} */ node) => above.has(parents[node]) && !nodes[node].children?.length && nodes[node].mesh === undefined;
  return nodes.map((_, node) => node).filter((node) => above.has(node) || isTip(node));
}

/**
 * @param {Int32Array} parents
 * @param {Set<number>} joints
 */
function checkOneBody(parents, joints) {
  /** @type {Map<number, number>} */
  const sizes = new Map();
  for (const joint of joints) {
    let top = joint;
    for (let node = joint, steps = 0; node >= 0; node = parents[node]) {
      if (++steps > parents.length) throw new Error('a cycle');
      if (joints.has(node)) top = node;
    }
    sizes.set(top, (sizes.get(top) ?? 0) + 1);
  }
  const bodies = [...sizes.values()].filter((size) => size >= BODY).length;
  if (bodies > 1) throw new CharacterError(`It has ${bodies} skeletons. Export one character by itself.`);
}

/**
 * @param {any} node
 * @param {Map<number, number>} places
 */
function rigNode({ name, translation, rotation, scale, matrix, children = [] }, places) {
  const inside = children.map((/** @type {number} */ child) => places.get(child)).filter((/** @type {number | undefined} */ child) => child !== undefined);
  return { name, translation, rotation, scale, matrix, ...(inside.length && { children: inside }) };
}

/** @param {any[]} skins */
function unique(skins) {
  return [...new Map(skins.map((skin) => [JSON.stringify(skin), skin])).values()];
}

/** @param {Document} document @returns {number[]} */
function humanNodes({ extensions = {} }) {
  const old = extensions.VRM?.humanoid?.humanBones ?? [];
  const now = Object.values(extensions.VRMC_vrm?.humanoid?.humanBones ?? {});
  return [...old, ...now].map(({ node }) => node).filter((node) => node >= 0);
}

/**
 * @param {Document} document
 * @param {Map<number, number>} places
 */
function humanoid({ extensions = {} }, places) {
  const old = extensions.VRM?.humanoid?.humanBones;
  const now = extensions.VRMC_vrm?.humanoid?.humanBones;
  const has = (/** @type {any} */ bone) => places.has(bone?.node);
  return {
    ...(old && { VRM: { humanoid: { humanBones: old.filter(has).map((/** @type {any} */ { bone, node }) => ({ bone, node: places.get(node) })) } } }),
    ...(now && {
      VRMC_vrm: {
        specVersion: '1.0',
        humanoid: { humanBones: Object.fromEntries(Object.entries(now).filter(([, bone]) => has(bone)).map(([bone, { node }]) => [bone, { node: places.get(node) }])) },
      },
    }),
  };
}

/** Copies of the inverse bind matrices that are used. */
class Matrices {
  /** @type {Map<number, number>} */
  #known = new Map();
  /** @type {Uint8Array[]} */
  #copies = [];

  /**
   * @param {Document} document
   * @param {Uint8Array} binary
   */
  constructor(document, binary) {
    this.document = document;
    this.binary = binary;
  }

  /**
   * Returns the new number of an accessor.
   *
   * @param {number} accessor
   */
  of(accessor) {
    const known = this.#known.get(accessor);
    if (known !== undefined) return known;
    const { bufferView, byteOffset = 0, componentType, type, count, sparse } = this.document.accessors[accessor];
    const view = this.document.bufferViews[bufferView];
    if (componentType !== FLOAT || type !== 'MAT4' || sparse || view.buffer !== 0) throw new Error('not matrices');
    const from = (view.byteOffset ?? 0) + byteOffset;
    if (!(count > 0) || from + MATRIX * count > this.binary.length) throw new Error('cut short');
    this.#known.set(accessor, this.#copies.length);
    return this.#copies.push(this.binary.subarray(from, from + MATRIX * count)) - 1;
  }

  get #length() {
    return Math.max(4, this.#copies.reduce((sum, { length }) => sum + length, 0));
  }

  get bytes() {
    const bytes = new Uint8Array(this.#length);
    let at = 0;
    for (const copy of this.#copies) {
      bytes.set(copy, at);
      at += copy.length;
    }
    return bytes;
  }

  get parts() {
    let at = 0;
    const views = this.#copies.map(({ length }) => ({ buffer: 0, byteOffset: (at += length) - length, byteLength: length }));
    return {
      buffers: [{ byteLength: this.#length }],
      bufferViews: views,
      accessors: views.map(({ byteLength }, view) => ({ bufferView: view, componentType: FLOAT, type: 'MAT4', count: byteLength / MATRIX })),
    };
  }
}
