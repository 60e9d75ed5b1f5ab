import { Frames, Motion, Rig, decode } from './vendor/motionsplice.js';
import { SIDES, takeOf } from './takes.js';

/** @import { Catalogue } from './catalogue.js' */
/** @import { Service } from './service.js' */
/** @import { Values } from './state.js' */
/** @import { SideName, Take } from './takes.js' */

/** @typedef {{ frame: number, event: string, action?: string }} Happened */

/** One of the motions that are compared. */
export class Side {
  /**
   * @param {SideName} name
   * @param {Take} take what was asked for
   * @param {Motion} motion
   * @param {any} message the answer
   */
  constructor(name, take, motion, message) {
    this.name = name;
    this.take = take;
    this.motion = motion;
    this.label = SIDES[name].label;
    this.colour = SIDES[name].colour;
    /** Phase of each frame, in strides. */
    this.phases = floats(message.phases);
    /** Seconds into the action at each frame; NaN where there is none. */
    this.actionTimes = floats(message.action_times);
    /** @type {Happened[]} */
    this.events = message.events;
  }
}

/** Fetches what the state asks for. Takes that were fetched before are kept. */
export class Sides {
  /** @type {Map<string, Promise<Side>>} */
  #kept = new Map();
  /** @type {Map<string, Promise<Rig>>} */
  #rigs = new Map();

  /**
   * @param {Service} service
   * @param {Catalogue} catalogue
   */
  constructor(service, catalogue) {
    this.service = service;
    this.catalogue = catalogue;
  }

  /**
   * Returns the sides that are shown, in order.
   *
   * @param {Values} values
   */
  async of(values) {
    const names = /** @type {SideName[]} */ (values.show.split(',').filter((name) => name in SIDES));
    const sides = await Promise.all(names.map((name) => this.#side(name, values)));
    return sides.filter((side) => side !== undefined);
  }

  /**
   * @param {SideName} name
   * @param {Values} values
   */
  async #side(name, values) {
    const take = takeOf(name, values, this.catalogue);
    if (!take) return undefined;
    const key = `${name} ${JSON.stringify(take)}`;
    const side = this.#kept.get(key) ?? this.#fetch(name, take);
    this.#kept.delete(key);
    this.#kept.set(key, side); // the newest last
    if (this.#kept.size > MOST_KEPT) this.#kept.delete(/** @type {string} */ (this.#kept.keys().next().value));
    side.catch(() => this.#kept.delete(key));
    return side;
  }

  /**
   * @param {SideName} name
   * @param {Take} take
   */
  async #fetch(name, take) {
    const response = await this.service.request('/v1/take?format=msgpack', {
      method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(take),
    });
    const message = /** @type {any} */ (decode(new Uint8Array(await response.arrayBuffer())));
    const rig = await this.#rig(message.bank);
    return new Side(name, take, new Motion(rig, message.rate).add(new Frames(message, rig, 'float32')), message);
  }

  /** @param {string} bank */
  #rig(bank) {
    const rig = this.#rigs.get(bank) ?? this.service.json(`/v1/banks/${bank}/skeleton`).then((found) => new Rig({ ...found, bank }, 'gltf'));
    this.#rigs.set(bank, rig);
    return rig;
  }
}

const MOST_KEPT = 60;

/** @param {Uint8Array} blob */
function floats(blob) {
  return new Float32Array(blob.buffer, blob.byteOffset, blob.byteLength / 4);
}
