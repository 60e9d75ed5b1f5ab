import { FormatError } from './errors.js';

const MOST_NESTED = 8; // lists and maps within each other; the protocol has three
const TEXT = new TextDecoder('utf-8', { fatal: true, ignoreBOM: true });

/**
 * Decodes a MessagePack value. Blobs become views into `bytes`. Extension types, which the protocol does not use, are
 * refused.
 *
 * @param {Uint8Array} bytes
 * @returns {unknown}
 * @throws {FormatError} if the bytes are not one whole value
 */
export function decode(bytes) {
  const reader = new Reader(bytes);
  const value = reader.value(0);
  if (reader.at < bytes.length) throw new FormatError(`${bytes.length - reader.at} bytes follow the message`);
  return value;
}

class Reader {
  at = 0;

  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  /**
   * @param {number} depth how many lists and maps are around the value
   * @returns {unknown}
   */
  value(depth) {
    const head = this.view.getUint8(this.skip(1));
    if (head < 0x80) return head;
    if (head < 0x90) return this.map(head & 0x0f, depth);
    if (head < 0xa0) return this.list(head & 0x0f, depth);
    if (head < 0xc0) return this.text(head & 0x1f);
    if (head >= 0xe0) return head - 0x100;
    switch (head) {
      case 0xc0: return null;
      case 0xc2: return false;
      case 0xc3: return true;
      case 0xc4: return this.blob(this.uint(1));
      case 0xc5: return this.blob(this.uint(2));
      case 0xc6: return this.blob(this.uint(4));
      case 0xca: return this.view.getFloat32(this.skip(4));
      case 0xcb: return this.view.getFloat64(this.skip(8));
      case 0xcc: return this.uint(1);
      case 0xcd: return this.uint(2);
      case 0xce: return this.uint(4);
      case 0xcf: return Number(this.view.getBigUint64(this.skip(8)));
      case 0xd0: return this.view.getInt8(this.skip(1));
      case 0xd1: return this.view.getInt16(this.skip(2));
      case 0xd2: return this.view.getInt32(this.skip(4));
      case 0xd3: return Number(this.view.getBigInt64(this.skip(8)));
      case 0xd9: return this.text(this.uint(1));
      case 0xda: return this.text(this.uint(2));
      case 0xdb: return this.text(this.uint(4));
      case 0xdc: return this.list(this.uint(2), depth);
      case 0xdd: return this.list(this.uint(4), depth);
      case 0xde: return this.map(this.uint(2), depth);
      case 0xdf: return this.map(this.uint(4), depth);
      default: throw new FormatError(`byte ${this.at - 1}: 0x${head.toString(16)} begins no value of the protocol`);
    }
  }

  /**
   * Moves on, and returns the place before.
   *
   * @param {number} count
   */
  skip(count) {
    const from = this.at;
    if (from + count > this.bytes.length) {
      throw new FormatError(`byte ${from}: ${count} bytes expected, but the message has ${this.bytes.length - from} more`);
    }
    this.at += count;
    return from;
  }

  /** @param {1 | 2 | 4} size */
  uint(size) {
    const at = this.skip(size);
    return size === 1 ? this.view.getUint8(at) : size === 2 ? this.view.getUint16(at) : this.view.getUint32(at);
  }

  /** @param {number} size */
  blob(size) {
    const from = this.skip(size);
    return this.bytes.subarray(from, from + size);
  }

  /** @param {number} size */
  text(size) {
    const from = this.at;
    try {
      return TEXT.decode(this.blob(size));
    } catch (error) {
      throw error instanceof FormatError ? error : new FormatError(`byte ${from}: the text is not UTF-8`);
    }
  }

  /**
   * @param {number} count
   * @param {number} depth
   */
  list(count, depth) {
    this.check(count, depth);
    return Array.from({ length: count }, () => this.value(depth + 1));
  }

  /**
   * @param {number} count
   * @param {number} depth
   */
  map(count, depth) {
    this.check(2 * count, depth);
    const entries = Array.from({ length: count }, () => {
      const at = this.at;
      const key = this.value(depth + 1);
      if (typeof key !== 'string') throw new FormatError(`byte ${at}: a map's key is not text`);
      return /** @type {[string, unknown]} */ ([key, this.value(depth + 1)]);
    });
    return Object.fromEntries(entries); // which takes a key `__proto__` for a key
  }

  /**
   * Checks before anything is allocated: each value has at least one byte.
   *
   * @param {number} count
   * @param {number} depth
   */
  check(count, depth) {
    if (depth >= MOST_NESTED) throw new FormatError(`byte ${this.at}: more than ${MOST_NESTED} lists and maps in each other`);
    if (count > this.bytes.length - this.at) throw new FormatError(`byte ${this.at}: the message ends within a list or map`);
  }
}
