import { address } from './address.js';
import { ConnectionLostError, FormatError, RefusedError } from './errors.js';
import { Frames, floats } from './frames.js';
import { Motion } from './motion.js';
import { decode } from './msgpack.js';
import { Nodes } from './nodes.js';
import { Rig } from './rig.js';

/** @import { How } from './address.js' */
/** @import { Command, Posture } from './commands.js' */

/**
 * A splice, as the protocol's "Parameters" describe it.
 *
 * @typedef {object} Splice
 * @property {string} locomotion clip that gives the root and the lower body
 * @property {string} [action] clip that gives the upper body
 * @property {number} [start] seconds into the action
 * @property {'splice' | 'naive' | 'none'} [method]
 * @property {string} [hands]
 * @property {Posture} [posture]
 * @property {number} [rate] frames per second
 * @property {number} [first] number of the first frame
 * @property {number} [count] number of frames
 */

const LONGEST = 2 ** 28; // bytes of a stream's message

/**
 * Fetches a whole splice.
 *
 * @param {string} url of the service
 * @param {Splice} what
 * @param {How} [how]
 * @throws {RefusedError | ConnectionLostError | FormatError}
 */
export async function splice(url, what, { token, axes = 'gltf', parts, encoding = 'float32' } = {}) {
  const message = await map(address(url, '/v1/splice', { ...what, axes, parts, encoding, format: 'msgpack' }), token);
  return motionOf(message, url, token, axes, encoding);
}

/**
 * @param {URL} url
 * @param {string | undefined} token
 * @param {object} [body]
 * @returns {Promise<any>}
 */
async function map(url, token, body) {
  return decode(new Uint8Array(await (await get(url, token, body)).arrayBuffer())) ?? {};
}

/**
 * Rigs that were fetched, by their address, so that motions of one bank share one.
 *
 * @type {Map<string, Promise<Rig>>}
 */
const RIGS = new Map();
const MOST_RIGS = 8;

/**
 * @param {any} message
 * @param {string} url
 * @param {string | undefined} token
 * @param {import('./rig.js').Axes} axes
 * @param {import('./frames.js').Encoding} encoding
 */
async function motionOf(message, url, token, axes, encoding) {
  const skeleton = address(url, `/v1/banks/${message.bank}/skeleton`, { axes }); // of the bank that made the frames
  const rig = RIGS.get(skeleton.href) ?? get(skeleton, token).then(async (answer) => new Rig({ ...await answer.json(), bank: message.bank }, axes));
  RIGS.delete(skeleton.href);
  RIGS.set(skeleton.href, rig); // the newest last
  if (RIGS.size > MOST_RIGS) RIGS.delete(/** @type {string} */ (RIGS.keys().next().value));
  rig.catch(() => RIGS.delete(skeleton.href));
  return new Motion(await rig, message.rate).add(new Frames(message, await rig, encoding));
}

/**
 * What a character is to do: a number of frames, and commands at frames, 0 if not given. The first is `create`.
 *
 * @typedef {object} TakeOrder
 * @property {number} [rate] frames per second, 60 if not given
 * @property {number} frames
 * @property {({ at?: number } & Command)[]} commands in the protocol's words, without `id`
 * @property {string} [rig] a GLB file with the nodes and skins of a character, in base64
 */

/**
 * What a character did.
 *
 * @typedef {object} Take
 * @property {Motion} motion
 * @property {Float32Array} phases of the locomotion at each frame, in strides
 * @property {Float32Array} actionTimes seconds into the action at each frame; NaN without one
 * @property {{ frame: number, event: string, action?: string }[]} events
 * @property {Nodes} [nodes] the motion of the rig that was sent
 */

/**
 * Fetches what a character does that is given commands at certain frames.
 *
 * @param {string} url of the service
 * @param {TakeOrder} order
 * @param {How} [how]
 * @returns {Promise<Take>}
 * @throws {RefusedError | ConnectionLostError | FormatError}
 */
export async function take(url, order, { token, axes = 'gltf', parts, encoding = 'float32' } = {}) {
  const message = await map(address(url, '/v1/take', { axes, parts, encoding, format: 'msgpack' }), token, order);
  const motion = await motionOf(message, url, token, axes, encoding);
  const { count, phases, action_times, events } = message;
  const nodes = message.rig && new Nodes(message);
  return { motion, phases: floats('phases', phases, count), actionTimes: floats('action_times', action_times, count), events, nodes };
}

/**
 * Begins a stream of a splice.
 *
 * @param {string} url of the service
 * @param {Splice & { pace?: 'fast' | 'realtime', ahead?: number }} what
 * @param {How} [how]
 * @returns {Promise<{ motion: Motion, frames: AsyncGenerator<Frames, void, void> }>} `frames` are the messages as they
 *   arrive; each is added to `motion` before
 * @throws {RefusedError | ConnectionLostError | FormatError}
 */
export async function stream(url, what, { token, axes = 'gltf', parts, encoding = 'float32' } = {}) {
  const response = await get(address(url, '/v1/stream', { ...what, axes, parts, encoding }), token);
  const messages = read(/** @type {ReadableStream<Uint8Array>} */ (response.body));
  const header = /** @type {any} */ ((await messages.next()).value);
  const motion = new Motion(new Rig(header ?? {}, axes), header?.rate);
  return { motion, frames: added(messages, motion, encoding, header.first + header.frames) };
}

/**
 * @param {AsyncGenerator<unknown, void, void>} messages
 * @param {Motion} motion
 * @param {import('./frames.js').Encoding} encoding
 * @param {number} end number of the frame after the last
 * @returns {AsyncGenerator<Frames, void, void>}
 */
async function* added(messages, motion, encoding, end) {
  let next;
  for await (const message of messages) {
    const frames = new Frames(message, motion.rig, encoding);
    motion.add(frames);
    next = frames.frame + frames.count;
    yield frames;
  }
  if (next !== end) throw new ConnectionLostError(`the stream ended before frame ${next}, not before ${end}`);
}

/**
 * Yields the messages of a stream: each is its length in 4 bytes, big-endian, and a MessagePack map.
 *
 * @param {ReadableStream<Uint8Array>} body
 * @returns {AsyncGenerator<unknown, void, void>}
 */
async function* read(body) {
  const reader = body.getReader();
  /** @type {Uint8Array} */
  let chunk = new Uint8Array(0);
  /** @param {Uint8Array} room */
  const fill = async (room) => {
    for (let filled = 0; filled < room.length;) {
      if (!chunk.length) {
        const { done, value } = await reader.read();
        if (done) return filled;
        chunk = value;
      }
      const part = chunk.subarray(0, room.length - filled);
      room.set(part, filled);
      filled += part.length;
      chunk = chunk.subarray(part.length);
    }
    return room.length;
  };
  try {
    for (;;) {
      const head = new Uint8Array(4);
      if (await fill(head) < 4) return;
      const length = new DataView(head.buffer).getUint32(0);
      if (length > LONGEST) throw new FormatError(`a message of ${length} bytes is longer than ${LONGEST}`);
      const message = new Uint8Array(length); // of its own, so that its arrays are aligned
      if (await fill(message) < length) throw new ConnectionLostError('the stream ended within a message');
      yield decode(message);
    }
  } catch (error) {
    throw error instanceof TypeError ? new ConnectionLostError(`the stream was cut: ${error.message}`) : error;
  } finally {
    reader.cancel().catch(() => {});
  }
}

/**
 * @param {URL} url
 * @param {string | undefined} token
 * @param {object} [body] to be sent as JSON
 */
async function get(url, token, body) {
  const headers = { ...(token && { Authorization: `Bearer ${token}` }), ...(body && { 'Content-Type': 'application/json' }) };
  const response = await fetch(url, { headers, ...(body && { method: 'POST', body: JSON.stringify(body) }) }).catch((error) => {
    throw new ConnectionLostError(`no answer from ${url.origin}: ${error.cause?.message ?? error.message}`);
  });
  if (response.ok) return response;
  const { type = 'http', detail = response.statusText } = await response.json().catch(() => ({}));
  throw new RefusedError(type, detail);
}
