import { FLOAT, padded, writeGlb } from './glb.js';
import { Matrix4, Quaternion, Vector3 } from '../vendor/three.js';

/** @import { Nodes } from '../vendor/motionsplice.js' */
/** @import { Document } from './glb.js' */

const TYPES = { 1: 'SCALAR', 3: 'VEC3', 4: 'VEC4' };

/**
 * Returns a copy of a character's file with one more animation. Everything else in it stays as it is.
 *
 * @param {Document} document
 * @param {Uint8Array} binary
 * @param {number[]} places number in `document` of each node of the rig
 * @param {Nodes} motion
 * @param {string} name of the animation
 */
export function animated(document, binary, places, { count, rate, moved, turned, still, translations, rotations }, name) {
  const copy = structuredClone(document);
  const added = new Added(copy, binary);
  const [times, once] = [added.put(Float32Array.from({ length: count }, (_, frame) => frame / rate), 1), added.put(new Float32Array(1), 1)];
  /** @type {any} */
  const animation = { name: unused(name, copy.animations ?? []), samplers: [], channels: [] };
  const key = (/** @type {number} */ node, /** @type {string} */ path, /** @type {number} */ input, /** @type {Float32Array} */ values) => {
    withoutMatrix(copy.nodes[places[node]]);
    const sampler = animation.samplers.push({ input, output: added.put(values, path === 'rotation' ? 4 : 3) }) - 1;
    animation.channels.push({ sampler, target: { node: places[node], path } });
  };
  moved.forEach((node, column) => key(node, 'translation', times, columnOf(translations, count, moved.length, column, 3)));
  turned.forEach((node, column) => key(node, 'rotation', times, columnOf(rotations, count, turned.length, column, 4)));
  for (const { node, translation, rotation } of still) {
    if (translation) key(node, 'translation', once, Float32Array.from(translation));
    if (rotation) key(node, 'rotation', once, Float32Array.from(rotation));
  }
  copy.animations = [...copy.animations ?? [], animation];
  return writeGlb(copy, added.binary);
}

/**
 * @param {Float32Array} values [F][N][width]
 * @param {number} count F
 * @param {number} columns N
 * @param {number} column
 * @param {number} width
 */
function columnOf(values, count, columns, column, width) {
  const out = new Float32Array(count * width);
  for (let frame = 0; frame < count; frame++) {
    const from = width * (frame * columns + column);
    out.set(values.subarray(from, from + width), frame * width);
  }
  return out;
}

/**
 * @param {string} name
 * @param {{ name?: string }[]} others
 */
function unused(name, others) {
  let found = name;
  for (let number = 2; others.some((one) => one.name === found); number++) found = `${name} ${number}`;
  return found;
}

/**
 * Gives a node parts in place of its matrix, which no animation may move.
 *
 * @param {any} node
 */
function withoutMatrix(node) {
  if (!node.matrix) return;
  const [translation, rotation, scale] = [new Vector3(), new Quaternion(), new Vector3()];
  new Matrix4().fromArray(node.matrix).decompose(translation, rotation, scale);
  delete node.matrix;
  Object.assign(node, { translation: translation.toArray(), rotation: rotation.toArray(), scale: scale.toArray() });
}

/** What is added to a document and its binary chunk. */
class Added {
  /** @type {Float32Array[]} */
  #arrays = [];
  #length;

  /**
   * @param {Document} document
   * @param {Uint8Array} binary
   */
  constructor(document, binary) {
    this.document = document;
    this.before = binary;
    this.#length = padded(binary.length);
    document.buffers = document.buffers?.length ? document.buffers : [{ byteLength: 0 }];
    document.bufferViews ??= [];
    document.accessors ??= [];
  }

  /**
   * Adds numbers. Returns their accessor.
   *
   * @param {Float32Array} values
   * @param {1 | 3 | 4} width
   */
  put(values, width) {
    const { bufferViews, accessors, buffers } = this.document;
    bufferViews.push({ buffer: 0, byteOffset: this.#length, byteLength: values.byteLength });
    this.#arrays.push(values);
    this.#length += values.byteLength;
    buffers[0].byteLength = this.#length;
    const bounds = width === 1 && { min: [values[0]], max: [values[values.length - 1]] };
    return accessors.push({ bufferView: bufferViews.length - 1, componentType: FLOAT, count: values.length / width, type: TYPES[width], ...bounds }) - 1;
  }

  get binary() {
    const bytes = new Uint8Array(this.#length);
    bytes.set(this.before);
    let at = padded(this.before.length);
    for (const array of this.#arrays) {
      bytes.set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength), at);
      at += array.byteLength;
    }
    return bytes;
  }
}
