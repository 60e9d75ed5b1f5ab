import { messageOf } from '../errors.js';
import { connect } from '../vendor/motionsplice.js';
import { member, repertoireOf } from './cast.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { Service } from '../service.js' */
/** @import { Connection } from '../vendor/motionsplice.js' */
/** @import { Member } from './cast.js' */

const AT_ONCE = 200; // characters in a message, which may have 64 KiB

/** The characters of a crowd at the service: as many as are wanted, as soon as it has made them. */
export class Company {
  /** Called for each message of frames, with its size in bytes. */
  onframes = (/** @type {number} */ _bytes) => {};
  /** Called with what is wrong; empty if nothing is any more. */
  onproblem = (/** @type {string} */ _problem) => {};
  /** Those that are there. @type {Member[]} */
  members = [];
  /** @type {Connection | undefined} */
  connection;
  #wanted = 0;
  #isBusy = false;

  /**
   * @param {Service} service
   * @param {() => Catalogue} catalogue
   */
  constructor(service, catalogue) {
    this.service = service;
    this.catalogue = catalogue;
  }

  /**
   * Changes how many characters there are. Without any, there is no connection either.
   *
   * @param {number} count
   */
  set(count) {
    this.#wanted = count;
    if (count === 0) this.#leave();
    else if (!this.#isBusy) void this.#reach();
  }

  async #reach() {
    this.#isBusy = true;
    this.onproblem('');
    try {
      while (this.#wanted && this.#wanted !== this.members.length) await this.#step();
    } catch (error) {
      if (this.#wanted) this.onproblem(messageOf(error));
    } finally {
      this.#isBusy = false;
    }
  }

  /** Connects, or makes or removes some characters. */
  async #step() {
    const { members } = this;
    const connection = this.connection ?? await this.#join();
    if (connection !== this.connection) return; // it was left meanwhile
    if (members.length > this.#wanted) {
      const gone = Array.from({ length: members.length - this.#wanted }, (_, index) => this.#wanted + index);
      members.length = this.#wanted;
      await connection.send({ do: 'remove', id: gone });
      return;
    }
    const repertoire = repertoireOf(this.catalogue().clips.values());
    const made = Array.from({ length: Math.min(AT_ONCE, this.#wanted - members.length) }, (_, index) => member(members.length + index, repertoire));
    await connection.send(made.flatMap((one, index) => commands(one, members.length + index)));
    if (connection === this.connection) members.push(...made);
  }

  async #join() {
    const { url, token } = this.service;
    const connection = await connect(url, { token, encoding: 'int16' });
    if (!this.#wanted) {
      connection.close();
      return connection;
    }
    this.connection = connection;
    connection.on('frames', ({ rotations }) => this.onframes(rotations?.buffer.byteLength ?? 0));
    connection.on('disconnected', ({ error, retry }) => this.onproblem(`${error.message}. Trying again in ${retry.toFixed(0)} s`));
    connection.on('reconnected', () => this.onproblem(''));
    connection.on('closed', ({ error }) => {
      if (connection !== this.connection) return;
      this.#leave();
      this.onproblem(error.message);
    });
    return connection;
  }

  #leave() {
    const { connection } = this;
    this.connection = undefined;
    this.members = [];
    connection?.close();
  }
}

/**
 * @param {Member} one
 * @param {number} id
 */
function commands({ locomotion, action, time }, id) {
  const create = { do: 'create', id, locomotion, time, in_place: true };
  return action === undefined ? [create] : [create, { do: 'act', id, action, blend: 0 }];
}
