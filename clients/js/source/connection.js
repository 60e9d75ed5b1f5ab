import { address } from './address.js';
import { Character } from './character.js';
import { command, idsOf } from './commands.js';
import { ConnectionLostError, FormatError, MotionSpliceError, RefusedError } from './errors.js';
import { Events } from './events.js';
import { Frames } from './frames.js';
import { Link } from './link.js';
import { Memory } from './memory.js';
import { decode } from './msgpack.js';
import { Playback } from './playback.js';
import { Replies } from './replies.js';
import { Rig } from './rig.js';

/** @import { How } from './address.js' */
/** @import { Command, CreateOptions, Locomotion, Settings } from './commands.js' */
/** @import { WebSocketClass } from './link.js' */
/** @import { EventMap } from './events.js' */
/** @import { Reply } from './replies.js' */

/**
 * @typedef {object} ConnectOptions
 * @property {number} [rate] frames per second, 60 if not given
 * @property {number} [ahead] frames in a message, 1 if not given
 * @property {WebSocketClass} [WebSocket] for Node before 22, as the package `ws` has it
 */

const PROTOCOL = 3;
const SILENCE = 8; // seconds without a message after which a connection is lost; the service cuts off after as many

/**
 * Connects to a service's characters.
 *
 * @param {string} url of the service, as `http://127.0.0.1:8000`
 * @param {How & ConnectOptions} [options]
 * @throws {ConnectionLostError} if nobody answers
 * @throws {RefusedError} if the service refuses, which it can tell web pages only
 */
export async function connect(url, options = {}) {
  return new Connection(url, options).open();
}

/** A connection to the characters of a service. Made by `connect`. */
export class Connection {
  /**
   * The characters by their ids.
   *
   * @type {Map<number, Character>}
   */
  characters = new Map();
  #playback = new Playback();
  #replies = new Replies();
  #events = new Events();
  /** @type {Error | undefined} */
  #refusal = undefined;
  #lastId = 0;
  #encoding;
  #axes;
  #settings;
  #link;
  /**
   * What makes each character again.
   *
   * @type {Map<number, Memory>}
   */
  #memories = new Map();
  /**
   * The joints of the bank whose frames arrive.
   *
   * @type {Rig | undefined}
   */
  rig = undefined;
  /**
   * The clips of the bank, by name.
   *
   * @type {Record<string, { rate: number, duration: number }>}
   */
  clips = {};

  /**
   * @param {string} url
   * @param {How & ConnectOptions} options
   */
  constructor(url, { token, axes = 'gltf', parts = 'local', encoding = 'float32', rate = 60, ahead = 1, WebSocket = globalThis.WebSocket }) {
    if (!WebSocket) throw new MotionSpliceError('this Node has no WebSocket. Pass that of the package ws: connect(url, { WebSocket })');
    this.#encoding = encoding;
    this.#axes = axes;
    const settings = this.#settings = /** @type {Settings & { rate: number, ahead: number }} */ ({ rate, ahead });
    this.#link = new Link(WebSocket, token ? ['motionsplice', `bearer.${token}`] : ['motionsplice'], {
      url: () => address(url, '/v1/characters', { axes, parts, encoding, deltas: true, rate: settings.rate, ahead: settings.ahead }),
      received: (data) => this.#received(data),
      patience: () => this.#patience(),
      lost: (error, retry) => this.#lost(error, retry),
    });
  }

  /**
   * Resolves once the service has greeted.
   *
   * @returns {Promise<this>}
   */
  async open() {
    await this.#link.open();
    return this;
  }

  /**
   * Calls a listener at each event. Returns a function that ends it.
   *
   * @template {keyof EventMap} K
   * @param {K} name
   * @param {(event: EventMap[K]) => void} listener
   */
  on(name, listener) {
    return this.#events.on(name, listener);
  }

  /**
   * Creates a character.
   *
   * @param {Locomotion} locomotion
   * @param {CreateOptions & { id?: number }} [options] `id`: a free one if not given
   */
  async create(locomotion, { id = this.#freeId(), ...options } = {}) {
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
    if (this.#link.isIdle) await this.#link.open();
    return this.#ask(listed, (frame) => listed.forEach((one) => this.#note(one, frame)));
  }

  /** Seconds after a frame is due at which it is shown; undefined before the first one. */
  get delay() {
    return this.#playback.delay;
  }

  /** Closes the connection for good. */
  close() {
    this.#link.close();
  }

  /**
   * @param {Command[]} listed
   * @param {(frame: number) => void} note
   * @returns {Promise<number>}
   */
  #ask(listed, note) {
    if (!this.#link.isReady) return Promise.reject(new ConnectionLostError('no connection'));
    const { ref, reply } = this.#replies.expect(note);
    const [first, ...others] = listed;
    this.#link.send(JSON.stringify(others.length ? [{ ...first, ref }, ...others] : { ...first, ref }));
    return reply;
  }

  /** Returns the seconds without a message after which the connection is lost. Without characters none need come. */
  #patience() {
    if (!this.#link.isReady) return SILENCE;
    return this.characters.size ? Math.max(SILENCE, 3 * this.#settings.ahead / this.#settings.rate) : Infinity;
  }

  #freeId() {
    do this.#lastId++; while (this.characters.has(this.#lastId));
    return this.#lastId;
  }

  /**
   * @param {Command} done
   * @param {number} frame
   */
  #note(done, frame) {
    if (done.do === 'set') {
      const { do: _, ref: __, ...settings } = done;
      Object.assign(this.#settings, settings);
    }
    for (const id of idsOf(done)) {
      if (done.do === 'create') this.#add(new Memory(done, id, frame));
      else if (done.do === 'remove') this.#remove(id);
      else this.#memories.get(id)?.note(done, frame);
    }
  }

  /** @param {Memory} memory */
  #add(memory) {
    const moment = () => this.#playback.at(performance.now() / 1000);
    this.#memories.set(memory.id, memory);
    this.characters.set(memory.id, new Character(memory, moment, (one) => this.send(one)));
  }

  /** @param {number} id */
  #remove(id) {
    this.#memories.delete(id);
    this.characters.delete(id);
  }

  /** @param {string | ArrayBuffer} data */
  #received(data) {
    try {
      if (typeof data === 'string') this.#happened(JSON.parse(data));
      else this.#arrived(decode(new Uint8Array(data)));
    } catch (error) {
      const problem = error instanceof SyntaxError ? new FormatError(`an event is not JSON: ${error.message}`) : error;
      if (!(problem instanceof FormatError)) throw problem;
      if (this.#link.isReady) this.#events.emit('error', problem);
      else this.#end(problem);
    }
  }

  /** @param {unknown} message */
  #arrived(message) {
    if (!this.rig) throw new FormatError('frames came before the event welcome');
    const frames = new Frames(message, this.rig, this.#encoding);
    this.#playback.take(frames, performance.now() / 1000, (id) => this.#memories.get(id)?.placed);
    this.#events.emit('frames', frames);
  }

  /** @param {any} event */
  #happened(event) {
    if (event?.event === 'done' || event?.event === 'refused') this.#replied(event);
    if (event?.event === 'welcome' || event?.event === 'bank') {
      this.rig = new Rig(event, this.#axes);
      this.clips = event.clips;
    }
    if (event?.event === 'bank') this.#playback.discard(event.frame);
    if (event?.event === 'welcome') {
      if (event.protocol !== PROTOCOL) {
        this.#end(new MotionSpliceError(`the service speaks protocol ${event.protocol}, this client ${PROTOCOL}`));
        return;
      }
      this.#link.greeted();
      void this.#restore();
    }
    this.#events.emit(event?.event, event);
  }

  /** @param {Error} error why there will be no connection */
  #end(error) {
    this.#refusal = error;
    this.#link.close();
  }

  /** @param {Reply} reply */
  #replied(reply) {
    if (reply.event === 'done') this.#playback.discard(reply.frame);
    if (this.#replies.take(reply) || reply.event === 'done') return;
    this.#refusal = new RefusedError(reply.type, reply.detail); // of the connection itself
  }

  /**
   * @param {ConnectionLostError} error
   * @param {number | undefined} retry
   */
  #lost(error, retry) {
    const last = this.#playback.held.at(-1);
    for (const memory of this.#memories.values()) memory.rest(last);
    this.#playback = new Playback();
    const why = this.#refusal ?? error;
    this.#refusal = undefined;
    this.#replies.fail(why);
    this.#events.emit(retry === undefined ? 'closed' : 'disconnected', { error: why, retry });
    return why;
  }

  /** Makes the characters again on a new connection. */
  async #restore() {
    const { events } = this.#settings;
    if (events) this.#ask([command('set', { events })], () => {}).catch(() => {});
    if (!this.#memories.size) return;
    /** @type {{ id: number, error: RefusedError }[]} */
    const failed = [];
    await Promise.all(Array.from(this.#memories.values(), async (memory) => {
      try {
        await this.#ask(memory.again(), (frame) => memory.begin(frame));
      } catch (error) {
        if (!(error instanceof RefusedError)) return; // lost again
        this.#remove(memory.id);
        failed.push({ id: memory.id, error });
      }
    }));
    if (this.#link.isReady) this.#events.emit('reconnected', { failed });
  }
}
