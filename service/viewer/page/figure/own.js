import { messageOf } from '../errors.js';
import { RefusedError, take } from '../vendor/motionsplice.js';

/** @import { Character } from './character.js' */
/** @import { Service } from '../service.js' */
/** @import { Sides } from '../sides.js' */
/** @import { State } from '../state.js' */

const LEFT_OUT = 'not carried over, the skeleton has no such joints: '; // the service's note
const TRIED = { rate: 30, frames: 60 }; // of the baseline, from which it is seen how high the soles are

/** The user's own character: chosen, checked, and shown in place of the mannequin. */
export class Own {
  /** What is being done, or why it failed. */
  status = '';
  isFault = false;
  /** Called when the status or the character has changed. */
  onchange = () => {};
  /**
   * Called with the reason when a file cannot be shown.
   *
   * @type {(problem: string) => void}
   */
  onfault = () => {};
  #newest = 0;

  /** Called to have what is shown fetched again. */
  refresh = () => {};

  /**
   * @param {Service} service
   * @param {State} state
   * @param {Sides} sides
   */
  constructor(service, state, sides) {
    this.service = service;
    this.state = state;
    this.sides = sides;
  }

  get character() {
    return this.sides.character;
  }

  /**
   * Shows the character in a file. If it cannot be shown, the status says why, and all else stays as it is.
   *
   * @param {File} file
   */
  async choose(file) {
    const number = ++this.#newest;
    this.#say(`Reading ${file.name} …`);
    let character;
    try {
      const { Character } = await import('./character.js'); // which most people never need
      character = await Character.read(file.name, await file.arrayBuffer());
      const notes = await this.#try(character);
      if (number !== this.#newest) return character.dispose();
      this.#use(character);
      const leftOut = notes.find((note) => note.startsWith(LEFT_OUT))?.slice(LEFT_OUT.length);
      this.#say(leftOut ? `Not shown: ${leftOut}, which it does not have.` : '');
    } catch (error) {
      character?.dispose();
      if (number === this.#newest) this.#say(`${file.name}: ${reason(error)}`, true);
    }
  }

  /** Shows the mannequin again. */
  remove() {
    this.#newest++;
    this.#use(undefined);
    this.#say('');
  }

  /**
   * Puts a short take onto it. Returns the service's notes.
   *
   * @param {Character} character
   */
  async #try(character) {
    const commands = [{ do: /** @type {const} */ ('create'), locomotion: this.sides.catalogue.baseline, loop: true }];
    const { motion, nodes } = await take(this.service.url, { ...TRIED, commands, rig: character.rig }, { token: this.service.token });
    if (!nodes) throw new Error('The service is too old to move characters.');
    const [{ followBody }, { measured }] = await Promise.all([import('./followers.js'), import('./measured.js')]);
    followBody(character.model, nodes);
    const figure = character.figure(nodes);
    Object.assign(character, measured(figure, motion));
    figure.dispose();
    return nodes.notes;
  }

  /** @param {Character | undefined} character */
  #use(character) {
    this.character?.dispose();
    this.sides.play(character);
    const body = character ? 'own' : 'mannequin';
    if (this.state.values.body === body) this.refresh();
    else this.state.set({ body });
  }

  /**
   * @param {string} status
   * @param {boolean} [isFault]
   */
  #say(status, isFault = false) {
    Object.assign(this, { status, isFault });
    this.onchange();
    if (isFault) this.onfault(status);
  }
}

/** @param {unknown} error */
function reason(error) {
  if (error instanceof RefusedError) return error.message.replace(/^rig: (.)/, (_, letter) => letter.toUpperCase());
  return messageOf(error);
}
