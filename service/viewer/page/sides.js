import { take as fetchTake } from './vendor/motionsplice.js';
import { SIDES, takeOf } from './takes.js';

/** @import { Catalogue } from './catalogue.js' */
/** @import { Character } from './figure/character.js' */
/** @import { Service } from './service.js' */
/** @import { Values } from './state.js' */
/** @import { SideName, Take } from './takes.js' */

const MOST_KEPT = 60;

/** One of the motions that are compared. */
export class Side {
  /**
   * @param {SideName} name
   * @param {Take} take what was asked for
   * @param {Awaited<ReturnType<typeof fetchTake>>} answer
   * @param {Character} [character] the user's own, that moves as this side does
   */
  constructor(name, take, answer, character) {
    this.name = name;
    this.take = take;
    this.label = SIDES[name].label;
    this.colour = SIDES[name].colour;
    this.motion = answer.motion;
    /** Phase of each frame, in strides. */
    this.phases = answer.phases;
    /** Seconds into the action at each frame; NaN where there is none. */
    this.actionTimes = answer.actionTimes;
    this.events = answer.events;
    /** The motion of the character's nodes. */
    this.nodes = answer.nodes;
    this.character = character;
  }
}

/** Fetches the sides that the state asks for. Those that were fetched lately are kept. */
export class Sides {
  /** The user's own character. @type {Character | undefined} */
  character;
  /** @type {Map<string, Promise<Side>>} */
  #kept = new Map();

  /**
   * @param {Service} service
   * @param {Catalogue} catalogue
   */
  constructor(service, catalogue) {
    this.service = service;
    this.catalogue = catalogue;
  }

  /**
   * Begins anew with another bank.
   *
   * @param {Catalogue} catalogue
   */
  reload(catalogue) {
    this.catalogue = catalogue;
    this.#kept.clear();
  }

  /**
   * Has another character of the user's play the sides; undefined: none.
   *
   * @param {Character | undefined} character
   */
  play(character) {
    this.character = character;
    this.#kept.clear();
  }

  /**
   * Returns the sides that are shown, in order.
   *
   * @param {Values} values
   */
  async of(values) {
    const names = /** @type {SideName[]} */ (values.show.split(',').filter((name) => Object.hasOwn(SIDES, name)));
    const sides = await Promise.all(names.map((name) => this.side(name, values, values.body === 'own' ? this.character : undefined)));
    return sides.filter((side) => side !== undefined);
  }

  /**
   * Returns one side; undefined if there is nothing to show.
   *
   * @param {SideName} name
   * @param {Values} values
   * @param {Character} [character]
   */
  async side(name, values, character) {
    const take = takeOf(name, values, this.catalogue);
    if (!take) return undefined;
    const key = `${name} ${character?.id ?? ''} ${JSON.stringify(take)}`;
    const side = this.#kept.get(key) ?? this.#fetch(name, take, character);
    this.#kept.delete(key);
    this.#kept.set(key, side); // the newest last
    if (this.#kept.size > MOST_KEPT) this.#kept.delete(/** @type {string} */ (this.#kept.keys().next().value));
    side.catch(() => this.#kept.delete(key));
    return side;
  }

  /**
   * @param {SideName} name
   * @param {Take} take
   * @param {Character} [character]
   */
  async #fetch(name, take, character) {
    const order = character ? { ...take, rig: character.rig } : take;
    return new Side(name, take, await fetchTake(this.service.url, order, { token: this.service.token }), character);
  }
}
