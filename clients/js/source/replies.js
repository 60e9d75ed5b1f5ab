import { RefusedError } from './errors.js';

/**
 * An event `done` or `refused`.
 *
 * @typedef {{ event: string, ref: unknown, frame: number, type: string, detail: string }} Reply
 */

/** The messages that the service has not replied to yet, by their `ref`. */
export class Replies {
  /** @type {Map<unknown, { note: (frame: number) => void, resolve: (frame: number) => void, reject: (error: Error) => void }>} */
  #waiting = new Map();
  #last = 0;

  /**
   * Returns a `ref` for a message, and the promise of its reply.
   *
   * @param {(frame: number) => void} note called at once when the service has done the message: a promise's listeners
   *   may run only after the frames that follow
   * @returns {{ ref: number, reply: Promise<number> }}
   */
  expect(note) {
    const ref = ++this.#last;
    const reply = new Promise((resolve, reject) => this.#waiting.set(ref, { note, resolve, reject }));
    return { ref, reply };
  }

  /**
   * Takes a reply. Returns whether a message waits for it.
   *
   * @param {Reply} reply
   */
  take({ event, ref, frame, type, detail }) {
    const waiting = this.#waiting.get(ref);
    if (!waiting) return false;
    this.#waiting.delete(ref);
    if (event === 'done') {
      waiting.note(frame);
      waiting.resolve(frame);
    } else waiting.reject(new RefusedError(type, detail));
    return true;
  }

  /**
   * Fails all messages: no reply will come.
   *
   * @param {Error} error
   */
  fail(error) {
    for (const { reject } of this.#waiting.values()) reject(error);
    this.#waiting.clear();
  }
}
