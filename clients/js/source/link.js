import { ConnectionLostError } from './errors.js';

/**
 * What a link calls.
 *
 * @typedef {object} Hooks
 * @property {() => URL} url to connect to
 * @property {(data: string | ArrayBuffer) => void} received
 * @property {() => number} patience seconds without a message after which the connection is lost
 * @property {(error: ConnectionLostError, retry: number | undefined) => Error} lost `retry`: seconds until it is opened
 *   again; undefined if it is not. Returns the error for those who wait
 */

/** @typedef {new (url: string, protocols: string[]) => WebSocket} WebSocketClass */

const FIRST_RETRY = 0.5; // seconds
const LONGEST_RETRY = 15; // seconds
const IDLE = 4408; // close code: no characters and no command for a minute
const FINAL = new Set([1003, 1009, 4401, 4403, 4404, 4422]); // close codes after which another try would end alike

/** A WebSocket that is opened again when it is lost, after longer and longer pauses. */
export class Link {
  /** @type {WebSocket | undefined} */
  socket = undefined;
  isReady = false; // the service has greeted
  isIdle = false; // opened again on demand only
  isClosed = false;
  tries = 0;
  heard = 0;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  timer = undefined;
  /** @type {ReturnType<typeof setInterval> | undefined} */
  watch = undefined;
  /** @type {{ resolve: () => void, reject: (error: Error) => void }[]} */
  waiting = [];

  /**
   * @param {WebSocketClass} type
   * @param {string[]} protocols
   * @param {Hooks} hooks
   */
  constructor(type, protocols, hooks) {
    this.type = type;
    this.protocols = protocols;
    this.hooks = hooks;
  }

  /**
   * Resolves once the service has greeted.
   *
   * @returns {Promise<void>}
   */
  open() {
    if (!this.socket) this.connect();
    return new Promise((resolve, reject) => this.waiting.push({ resolve, reject }));
  }

  connect() {
    const url = this.hooks.url();
    url.protocol = url.protocol.replace(/^http/, 'ws');
    const socket = new this.type(url.href, this.protocols);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.isIdle = false;
    this.heard = performance.now();
    socket.onmessage = ({ data }) => {
      this.heard = performance.now();
      this.hooks.received(data);
    };
    let problem = '';
    socket.onerror = (event) => { problem = /** @type {ErrorEvent} */ (event).message ?? ''; }; // browsers have none
    socket.onclose = ({ code, reason }) => this.drop(code, reason || problem);
    this.watch = setInterval(() => {
      const silence = (performance.now() - this.heard) / 1000;
      if (silence > this.hooks.patience()) this.drop(1006, `nothing received for ${silence.toFixed()} s`);
    }, 1000);
  }

  /** To be called when the service has greeted. */
  greeted() {
    this.isReady = true;
    this.tries = 0;
    for (const { resolve } of this.waiting.splice(0)) resolve();
  }

  /**
   * @param {string} text
   */
  send(text) {
    this.socket?.send(text);
  }

  /**
   * Closes the connection for good.
   *
   * @param {number} [code]
   * @param {string} [reason]
   */
  close(code = 1000, reason = 'closed by the client') {
    if (this.isClosed) return;
    this.isClosed = true;
    this.drop(code, reason);
  }

  /**
   * Notes that there is no connection any more, and opens another one unless it is closed or idle.
   *
   * @param {number} code
   * @param {string} reason
   */
  drop(code, reason) {
    const wasReady = this.isReady;
    clearInterval(this.watch);
    clearTimeout(this.timer);
    if (this.socket) {
      this.socket.onmessage = this.socket.onclose = null;
      this.socket.close();
    }
    this.socket = undefined;
    this.isReady = false;
    this.isClosed ||= FINAL.has(code);
    const isFirst = !wasReady && this.tries === 0; // the caller of `open` is told, and may try again
    this.isIdle = !this.isClosed && (code === IDLE || isFirst);
    const retry = this.isClosed || this.isIdle ? undefined : this.pause();
    if (retry !== undefined) this.timer = setTimeout(() => this.connect(), 1000 * retry);
    const error = new ConnectionLostError(`${wasReady ? 'disconnected' : 'not connected'}: ${reason || `code ${code}`}`, code);
    const why = this.hooks.lost(error, retry);
    for (const { reject } of this.waiting.splice(0)) reject(why);
  }

  /** Returns the next pause in seconds. Part of it is random, so that clients do not come back all at once. */
  pause() {
    const longest = Math.min(LONGEST_RETRY, FIRST_RETRY * 2 ** this.tries++);
    return longest * (0.5 + 0.5 * Math.random());
  }
}
