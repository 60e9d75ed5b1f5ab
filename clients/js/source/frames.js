import { FormatError } from './errors.js';

/** @import { Rig } from './rig.js' */

/** @typedef {'float32' | 'int16'} Encoding */
/** @typedef {'local' | 'world' | 'both'} Parts */

const NORMALISED = 32767; // int16 for 1

/** A message of frames. Its arrays are views into the message. F is the number of frames, n of characters, J of joints. */
export class Frames {
  /**
   * @param {any} message the decoded map
   * @param {Rig} rig of the bank that made the frames
   * @param {Encoding} encoding
   * @throws {FormatError} if the message does not fit the rig and the encoding
   */
  constructor(message, rig, encoding) {
    const { bank, frame, count, rate, time, ids } = message ?? {};
    if (bank !== rig.bank) throw new FormatError(`bank: expected ${rig.bank}, found ${bank}`);
    if (!Number.isSafeInteger(frame) || frame < 0) throw new FormatError(`frame: expected a whole number, found ${frame}`);
    if (!Number.isSafeInteger(count) || count < 1) throw new FormatError(`count: expected at least 1, found ${count}`);
    if (!(Number.isFinite(rate) && rate > 0)) throw new FormatError(`rate: expected frames per second, found ${rate}`);
    if (ids !== undefined && !Number.isFinite(time)) throw new FormatError(`time: expected seconds, found ${time}`);
    if (ids === undefined && time !== undefined) throw new FormatError('ids: missing');
    this.rig = rig;
    /** Number of the first frame. */
    this.frame = /** @type {number} */ (frame);
    /** F */
    this.count = /** @type {number} */ (count);
    /** Frames per second. */
    this.rate = /** @type {number} */ (rate);
    /** When the first frame is due, in seconds since 1970 by the service's clock; of characters only. */
    this.time = /** @type {number | undefined} */ (time);
    /** The characters [n]; undefined for a splice or a stream, which have one. */
    this.ids = ids === undefined ? undefined : view(Uint32Array, 'ids', ids);
    /** n */
    this.characters = this.ids?.length ?? 1;
    const joints = rig.joints.length;
    const rows = this.count * this.characters;
    /**
     * @param {string} name
     * @param {number} numbers
     */
    const of = (name, numbers) => floats(name, message[name], rows * numbers);
    /** [F][n][3] */
    this.rootPositions = of('root_positions', 3);
    /** [F][n][J][4], if the parts include local rotations; in int16 they are to be divided by 32767 and normalised */
    this.rotations = message.rotations === undefined ? undefined
      : encoding === 'float32' ? of('rotations', 4 * joints)
        : sized('rotations', view(Int16Array, 'rotations', message.rotations), rows * 4 * joints);
    /** [F][n][J][3], if the parts include world positions */
    this.worldPositions = message.world_positions === undefined ? undefined : of('world_positions', 3 * joints);
    /** [F][n][3], with `deltas`: what root motion has added since the frame before, in the character's own heading */
    this.rootSteps = message.root_steps === undefined ? undefined : of('root_steps', 3);
    /** [F][n], with `deltas`: radians that root motion has turned since the frame before */
    this.rootTurns = message.root_turns === undefined ? undefined : of('root_turns', 1);
    if (!this.rotations && !this.worldPositions) throw new FormatError('rotations and world_positions: missing');
    /** @type {Map<number, number> | undefined} */
    this.rowsById = undefined;
  }

  /**
   * Returns the row of a character, or undefined. Characters mostly keep their rows, so that one is tried first.
   *
   * @param {number} id
   * @param {number} [before]
   */
  rowOf(id, before = 0) {
    if (this.ids === undefined || this.ids[before] === id) return this.ids === undefined ? 0 : before;
    this.rowsById ??= new Map(Array.from(this.ids, (one, row) => [one, row]));
    return this.rowsById.get(id);
  }

  /**
   * Copies the root's position and the rotations of one character at one frame.
   *
   * @param {number} number of the frame in this message, from 0
   * @param {number} row
   * @param {Float32Array} root receives [3]
   * @param {Float32Array | undefined} rotations receives [J][4], of length 1
   * @param {Float32Array | undefined} positions receives the world positions [J][3]
   */
  copy(number, row, root, rotations, positions) {
    const at = number * this.characters + row;
    const joints = this.rig.joints.length;
    root.set(this.rootPositions.subarray(3 * at, 3 * at + 3));
    const places = this.worldPositions?.subarray(3 * joints * at, 3 * joints * (at + 1));
    if (places) positions?.set(places);
    const turns = this.rotations?.subarray(4 * joints * at, 4 * joints * (at + 1));
    if (!turns || !rotations) return;
    if (turns instanceof Float32Array) rotations.set(turns);
    else decode(turns, rotations);
  }
}

/**
 * @param {Int16Array} from
 * @param {Float32Array} to
 */
function decode(from, to) {
  for (let at = 0; at < from.length; at += 4) {
    const x = Math.max(from[at] / NORMALISED, -1), y = Math.max(from[at + 1] / NORMALISED, -1);
    const z = Math.max(from[at + 2] / NORMALISED, -1), w = Math.max(from[at + 3] / NORMALISED, -1);
    const length = Math.sqrt(x * x + y * y + z * z + w * w) || 1;
    to[at] = x / length;
    to[at + 1] = y / length;
    to[at + 2] = z / length;
    to[at + 3] = w / length;
  }
}

/**
 * Returns a blob as an array. It is a view, for the service aligns blobs; a proxy that does not is served by a copy.
 *
 * @template {Uint32Array | Int16Array | Float32Array} T
 * @param {{ new (buffer: ArrayBufferLike, offset: number, length: number): T, BYTES_PER_ELEMENT: number }} type
 * @param {string} name
 * @param {unknown} blob
 * @returns {T}
 */
function view(type, name, blob) {
  const size = type.BYTES_PER_ELEMENT;
  if (!(blob instanceof Uint8Array)) throw new FormatError(`${name}: ${blob === undefined ? 'missing' : 'not a blob'}`);
  if (blob.length % size) throw new FormatError(`${name}: ${blob.length} bytes are not whole numbers of ${size} bytes`);
  const aligned = blob.byteOffset % size ? blob.slice() : blob;
  return new type(aligned.buffer, aligned.byteOffset, aligned.length / size);
}

/**
 * Returns a blob of so many numbers.
 *
 * @param {string} name
 * @param {unknown} blob
 * @param {number} length
 * @throws {FormatError}
 */
export function floats(name, blob, length) {
  return sized(name, view(Float32Array, name, blob), length);
}

/**
 * @template {Int16Array | Float32Array} T
 * @param {string} name
 * @param {T} array
 * @param {number} length
 */
function sized(name, array, length) {
  if (array.length !== length) throw new FormatError(`${name}: expected ${length} numbers, found ${array.length}`);
  return array;
}
