/** @import { Receiver } from './commands.js' */
/** @import { Frames } from './frames.js' */
/** @import { RigMessage } from './rig.js' */
/** @import { FormatError, RefusedError } from './errors.js' */

/**
 * An event of characters: `ids` are the characters, and `frame` is the first frame that shows it.
 *
 * @typedef {{ event: string, ids: number[], frame: number }} Happened
 */

/** @typedef {RigMessage & { clips: Record<string, { rate: number, duration: number }> }} BankEvent */

/**
 * The events of a connection: the service's, under the protocol's names, and this client's own.
 *
 * @typedef {object} EventMap
 * @property {BankEvent & { protocol: number, max_characters: number, receivers: Receiver[] }} welcome the service has greeted, at first and again
 * @property {BankEvent & { frame: number }} bank from `frame` on, frames are of another bank
 * @property {{ bank: string, missing: string[] }} bank_kept a newer bank misses clips that are played here
 * @property {{ reason: string }} closing the service stops
 * @property {Happened & { action: string }} action_began
 * @property {Happened & { action: string }} action_ended
 * @property {Happened} locomotion_ended
 * @property {Happened} left_down
 * @property {Happened} left_up
 * @property {Happened} right_down
 * @property {Happened} right_up
 * @property {Happened} stride
 * @property {{ to: Receiver, ids: number[], reason: string }} sending_ended characters are no longer sent to a receiver
 * @property {{ to: Receiver, reason: string }} undelivered the system refused what was sent to a receiver
 * @property {Frames} frames a message of frames has arrived
 * @property {{ error: Error, retry: number }} disconnected the connection was lost; it is opened again in `retry` seconds
 * @property {{ failed: { id: number, error: RefusedError }[] }} reconnected the characters are there again, but
 *   for `failed`
 * @property {{ error: Error }} closed the connection was closed or refused, or has nothing to do; it is not opened again
 *   before the next command
 * @property {FormatError} error a message was not what the protocol describes, and was dropped
 */

/** Calls listeners at events. */
export class Events {
  /** @type {Map<string, Set<(event: any) => void>>} */
  #listeners = new Map();

  /**
   * @param {string} name
   * @param {(event: any) => void} listener
   * @returns {() => void} ends it
   */
  on(name, listener) {
    const listeners = this.#listeners.get(name) ?? new Set();
    this.#listeners.set(name, listeners.add(listener));
    return () => void listeners.delete(listener);
  }

  /**
   * @param {string} name
   * @param {any} event
   */
  emit(name, event) {
    const listeners = this.#listeners.get(name);
    if (name === 'error' && !listeners?.size) console.error(event);
    listeners?.forEach((listener) => listener(event));
  }
}
