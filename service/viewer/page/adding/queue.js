import { isRefused, messageOf } from '../errors.js';
import { askForToken } from '../panels/entry.js';
import { ConnectionLostError } from '../vendor/motionsplice.js';
import { SKELETON } from './files.js';
import { follow, pause, send } from './sending.js';

/** @import { Service } from '../service.js' */
/** @import { Job } from './sending.js' */

/** @typedef {{ file: Blob, name: string, suffix: string, kind: 'locomotion' | 'action', tags: string }} Wanted */

/**
 * A file on its way into the bank. `isLost`: it failed because the connection was lost, so it can be sent again.
 *
 * @typedef {Wanted & { state: 'queued' | 'sending' | 'checking' | 'aligning' | 'loading' | 'done' | 'failed', share?: number, text: string, bank: string, isLost: boolean }} Item
 */

const BETWEEN = 300; // ms between two looks at which bank is served
const LONGEST = 90_000; // ms until a new bank must be served

/** Sends files one after another, follows the offline job, and waits until the bank that has them is served. */
export class Queue {
  /** @type {Item[]} */
  items = [];
  #isSending = false;
  #isFollowing = false;
  #isLoading = false;
  /** Digests of the banks on disk, in order. @type {string[]} */
  #banks = [];

  /**
   * @param {Service} service
   * @param {object} calls
   * @param {() => void} calls.onChange an item has changed
   * @param {(items: Item[]) => void} calls.onServed the bank that is served has these items
   */
  constructor(service, { onChange, onServed }) {
    this.service = service;
    this.onChange = onChange;
    this.onServed = onServed;
  }

  /** @param {Wanted[]} wanted in the order in which they are sent */
  add(wanted) {
    this.items = this.items.filter((one) => !wanted.some(({ name, suffix }) => one.state === 'failed' && one.name === name && one.suffix === suffix));
    for (const one of wanted) this.items.push({ ...one, state: 'queued', text: 'Waiting for the others', bank: '', isLost: false });
    void this.#send();
  }

  /** @param {Item} item that was lost */
  retry(item) {
    this.#set(item, 'queued', 'Waiting for the others');
    void this.#send();
  }

  /** @param {Item} item that is done or has failed */
  remove(item) {
    this.items = this.items.filter((one) => one !== item);
    this.onChange();
  }

  async #send() {
    this.onChange();
    if (this.#isSending) return;
    this.#isSending = true;
    for (let item; (item = this.items.find(({ state }) => state === 'queued'));) {
      try {
        await this.#sendOne(item);
      } catch (error) {
        if (isRefused(error, 'token')) {
          await askForToken(this.service);
          this.#set(item, 'queued', '');
        } else {
          item.isLost = error instanceof ConnectionLostError;
          this.#set(item, 'failed', messageOf(error));
        }
      }
    }
    this.#isSending = false;
  }

  /** @param {Item} item */
  async #sendOne(item) {
    const { name, suffix, kind, tags, file } = item;
    const isSkeleton = suffix === SKELETON;
    this.#set(item, 'sending', 'Sending', 0);
    const job = await send(this.service, { name: name + suffix, ...(isSkeleton ? {} : { kind, tags }) }, file, (share) => {
      if (share < 1) this.#set(item, 'sending', `Sending, ${Math.floor(100 * share)} %`, share);
      else this.#set(item, 'checking', 'The service is reading it');
    });
    if (isSkeleton) {
      this.#set(item, 'done', 'Stored');
      return;
    }
    this.#set(item, 'aligning', textOf(job));
    void this.#follow();
  }

  /** Follows the job while it has items to do. */
  async #follow() {
    if (this.#isFollowing) return;
    this.#isFollowing = true;
    try {
      for await (const job of follow(this.service)) {
        this.#take(job);
        if (!this.#those('aligning').length) break;
      }
    } catch (error) {
      for (const item of this.#those('aligning')) this.#set(item, 'failed', messageOf(error));
    }
    this.#isFollowing = false;
    if (this.#those('aligning').length) void this.#follow(); // sent in the meantime
  }

  /** @param {Job | undefined} job undefined: the connection is lost */
  #take(job) {
    if (job && job.bank !== this.#banks.at(-1)) this.#banks.push(job.bank);
    for (const item of this.#those('aligning')) {
      if (!job) this.#set(item, 'aligning', 'Connection lost, trying again');
      else if (item.name in job.failed) this.#set(item, 'failed', job.failed[item.name]);
      else if (!job.clips.includes(item.name) && job.state !== 'waiting') {
        item.bank = job.bank;
        this.#set(item, 'loading', 'The service is opening the new bank');
      } else if (job.state === 'failed') this.#set(item, 'failed', job.error || 'The offline job failed. See the log of the service.');
      else this.#set(item, 'aligning', textOf(job), job.total ? job.done / job.total : undefined);
    }
    if (this.#those('loading').length) void this.#load();
  }

  /** Waits until the service has the bank that the job wrote, or a later one. */
  async #load() {
    if (this.#isLoading) return;
    this.#isLoading = true;
    const end = performance.now() + LONGEST;
    while (this.#those('loading').length) {
      const served = await this.service.json('/v1/server').then(({ bank }) => this.#banks.lastIndexOf(bank), () => -1);
      const found = this.#those('loading').filter(({ bank }) => served >= this.#banks.lastIndexOf(bank));
      for (const item of found) this.#set(item, 'done', 'In the bank');
      if (found.length) this.onServed(found);
      if (performance.now() > end) for (const item of this.#those('loading')) this.#set(item, 'failed', 'The service has not opened the new bank. See its log.');
      await pause(BETWEEN);
    }
    this.#isLoading = false;
  }

  /** @param {Item['state']} state */
  #those(state) {
    return this.items.filter((one) => one.state === state);
  }

  /**
   * @param {Item} item
   * @param {Item['state']} state
   * @param {string} text
   * @param {number} [share]
   */
  #set(item, state, text, share) {
    Object.assign(item, { state, text, share });
    this.onChange();
  }
}

/** @param {Job} job */
function textOf({ state, stage, done, total }) {
  if (state !== 'running' || !stage) return 'Waiting for the offline job';
  const name = stage[0].toUpperCase() + stage.slice(1);
  return total ? `${name}, ${done} of ${total} clips` : name;
}
