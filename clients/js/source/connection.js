import { address } from './address.js';
import { Character } from './character.js';
import { command, idsOf } from './commands.js';
import { ConnectionLostError, FormatError, MotionSpliceError, RefusedError } from './errors.js';
import { Frames } from './frames.js';
import { Link } from './link.js';
import { decode } from './msgpack.js';
import { Playback } from './playback.js';
import { Rig } from './rig.js';

/** @import { How } from './address.js' */
/** @import { Command, CreateOptions, Locomotion, Settings } from './commands.js' */
/** @import { WebSocketClass } from './link.js' */
/** @import { EventMap } from './events.js' */

/**
 * @typedef {object} ConnectOptions
 * @property {number} [rate] frames per second, 60 if not given
 * @property {number} [ahead] frames in a message, 1 if not given
 * @property {WebSocketClass} [WebSocket] for Node before 22, as the package `ws` has it
 */

/**
 * @typedef {object} Pending a message without a reply
 * @property {(frame: number) => void} note called before frames that the message changes arrive
 * @property {(frame: number) => void} resolve
 * @property {(error: Error) => void} reject
 */

const PROTOCOL = 3;
const SILENCE = 8; // seconds without frames after which a connection is lost; the service cuts off after as many

/**
 * Connects to a service's characters.
 *
 * @param {string} url of the service, as `http://127.0.0.1:8000`
 * @param {How & ConnectOptions} [options]
 * @throws {ConnectionLostError} if nobody answers
 * @throws {RefusedError} if the service refuses, which it can tell web pages only
 */
export async function connect(url, options = {}) {
  const connection = new Connection(url, options);
  await connection.link.open();
  return connection;
}

/** A connection to the characters of a service. Made by `connect`. */
export class Connection {
  /**
   * The characters by their ids.
   *
   * @type {Map<number, Character>}
   */
  characters = new Map();
  playback = new Playback();
  /** @type {Map<number, Pending>} */
  pending = new Map();
  /** @type {Map<string, Set<(event: any) => void>>} */
  listeners = new Map();
  /** @type {Error | undefined} */
  refusal = undefined;
  lastRef = 0;
  lastId = 0;

  /**
   * @param {string} url
   * @param {How & ConnectOptions} options
   */
  constructor(url, { token, axes = 'gltf', parts = 'local', encoding = 'float32', rate = 60, ahead = 1, WebSocket = globalThis.WebSocket }) {
    if (!WebSocket) throw new MotionSpliceError('this Node has no WebSocket. Pass that of the package ws: connect(url, { WebSocket })');
    this.encoding = encoding;
    /** What was asked for, which a new connection asks for again. @type {Settings} */
    this.settings = { rate, ahead };
    const query = { axes, parts, encoding, deltas: true };
    this.axes = axes;
    this.link = new Link(WebSocket, token ? ['motionsplice', `bearer.${token}`] : ['motionsplice'], {
      url: () => address(url, '/v1/characters', { ...query, rate: this.settings.rate, ahead: this.settings.ahead }),
      received: (data) => this.received(data),
      patience: () => this.characters.size ? Math.max(SILENCE, (3 * (this.settings.ahead ?? 1)) / (this.settings.rate ?? 1)) : Infinity,
      lost: (error, retry) => this.lost(error, retry),
    });
    /** The joints of the bank whose frames arrive. @type {Rig | undefined} */
    this.rig = undefined;
    /**
     * The clips of the bank, by name.
     *
     * @type {Record<string, { rate: number, duration: number }>}
     */
    this.clips = {};
  }

  /**
   * Calls a listener at each event. Returns a function that ends it.
   *
   * @template {keyof EventMap} K
   * @param {K} name
   * @param {(event: EventMap[K]) => void} listener
   */
  on(name, listener) {
    const listeners = this.listeners.get(name) ?? new Set();
    this.listeners.set(name, listeners.add(listener));
    return () => void listeners.delete(listener);
  }

  /**
   * Creates a character.
   *
   * @param {Locomotion} locomotion
   * @param {CreateOptions & { id?: number }} [options] `id`: a free one if not given
   */
  async create(locomotion, { id = this.freeId(), ...options } = {}) {
    await this.send(command('create', { id, locomotion, ...options }));
    return /** @type {Character} */ (this.characters.get(id));
  }

  /**
   * Changes the connection's rate, look-ahead or events.
   *
   * @param {Settings} settings
   */
  set(settings) {
    return this.send(command('set', settings));
  }

  /**
   * Sends commands as the protocol has them. A list is done at the same frame, or not at all.
   *
   * @param {Command | readonly Command[]} commands
   * @returns {Promise<number>} number of the first frame that shows them
   * @throws {RefusedError | ConnectionLostError}
   */
  async send(commands) {
    const listed = /** @type {Command[]} */ ([]).concat(commands);
    if (this.link.isIdle) await this.link.open();
    return this.ask(listed, (frame) => listed.forEach((one) => this.note(one, frame)));
  }

  /** Closes the connection for good. */
  close() {
    this.link.close();
  }

  /** Between which frames, and where between them, characters are to be shown now; undefined before the first. */
  moment() {
    return this.playback.at(performance.now() / 1000);
  }

  /**
   * @param {Command[]} listed
   * @param {(frame: number) => void} note
   * @returns {Promise<number>}
   */
  ask(listed, note) {
    if (!this.link.isReady) return Promise.reject(new ConnectionLostError('no connection'));
    return new Promise((resolve, reject) => {
      const ref = ++this.lastRef;
      this.pending.set(ref, { note, resolve, reject });
      const [first, ...others] = listed;
      this.link.send(JSON.stringify(others.length ? [{ ...first, ref }, ...others] : { ...first, ref }));
    });
  }

  freeId() {
    do this.lastId++; while (this.characters.has(this.lastId));
    return this.lastId;
  }

  /**
   * @param {Command} done
   * @param {number} frame
   */
  note(done, frame) {
    if (done.do === 'set') {
      const { do: _, ref: __, ...settings } = done;
      Object.assign(this.settings, settings);
    }
    for (const id of idsOf(done)) {
      if (done.do === 'create') this.characters.set(id, new Character(this, done, id, frame));
      else if (done.do === 'remove') this.characters.delete(id);
      else this.characters.get(id)?.memory.note(done, frame);
    }
  }

  /** @param {string | ArrayBuffer} data */
  received(data) {
    try {
      if (typeof data === 'string') this.happened(JSON.parse(data));
      else this.arrived(decode(new Uint8Array(data)));
    } catch (error) {
      if (!(error instanceof FormatError || error instanceof SyntaxError)) throw error;
      this.emit('error', error instanceof FormatError ? error : new FormatError(`an event is not JSON: ${error.message}`));
    }
  }

  /** @param {unknown} message */
  arrived(message) {
    if (!this.rig) throw new FormatError('frames came before the event welcome');
    const frames = new Frames(message, this.rig, this.encoding);
    this.playback.take(frames, performance.now() / 1000, (id) => this.characters.get(id)?.memory.placed);
    this.emit('frames', frames);
  }

  /** @param {any} event */
  happened(event) {
    if (event?.event === 'done' || event?.event === 'refused') this.replied(event);
    if (event?.event === 'welcome' || event?.event === 'bank') {
      this.rig = new Rig(event, this.axes);
      this.clips = event.clips;
    }
    if (event?.event === 'bank') this.playback.discard(event.frame);
    if (event?.event === 'welcome') {
      if (event.protocol !== PROTOCOL) {
        this.refusal = new MotionSpliceError(`the service speaks protocol ${event.protocol}, this client ${PROTOCOL}`);
        this.link.close();
        return;
      }
      this.link.greeted();
      void this.restore();
    }
    this.emit(event?.event, event);
  }

  /** @param {{ event: string, ref: unknown, frame: number, type: string, detail: string }} reply */
  replied({ event, ref, frame, type, detail }) {
    const pending = this.pending.get(/** @type {number} */ (ref));
    this.pending.delete(/** @type {number} */ (ref));
    if (event === 'done') {
      this.playback.discard(frame);
      pending?.note(frame);
      pending?.resolve(frame);
    } else if (pending) pending.reject(new RefusedError(type, detail));
    else this.refusal = new RefusedError(type, detail); // of the connection itself
  }

  /**
   * @param {ConnectionLostError} error
   * @param {number | undefined} retry
   */
  lost(error, retry) {
    const last = this.playback.held.at(-1);
    for (const character of this.characters.values()) character.memory.rest(last);
    this.playback = new Playback();
    const why = this.refusal ?? error;
    this.refusal = undefined;
    for (const { reject } of this.pending.values()) reject(why);
    this.pending.clear();
    this.emit(retry === undefined ? 'closed' : 'disconnected', { error: why, retry });
  }

  /** Makes the characters again on a new connection. */
  async restore() {
    const { events } = this.settings;
    if (events) this.ask([command('set', { events })], () => {}).catch(() => {});
    if (!this.characters.size) return;
    /** @type {{ character: Character, error: RefusedError }[]} */
    const failed = [];
    await Promise.all(Array.from(this.characters.values(), async (character) => {
      try {
        await this.ask(character.memory.again(), (frame) => character.memory.begin(frame));
      } catch (error) {
        if (!(error instanceof RefusedError)) return; // lost again
        this.characters.delete(character.id);
        failed.push({ character, error });
      }
    }));
    if (this.link.isReady) this.emit('reconnected', { failed });
  }

  /**
   * @param {string} name
   * @param {any} event
   */
  emit(name, event) {
    const listeners = this.listeners.get(name);
    if (name === 'error' && !listeners?.size) console.error(event);
    listeners?.forEach((listener) => listener(event));
  }
}
