import { centimetres, make } from './panels/dom.js';
import { FULL, STOPS } from './scene/differences.js';

/** @import { Side } from './sides.js' */

/** @typedef {{ label: string, mean: number, worst: number, joint: string, isColoured: boolean }} Apart */

/** What stands over the stage: which colour is which side, and how far they are apart. */
export class Readout {
  #shown = '';

  /** @param {HTMLElement} element */
  constructor(element) {
    const colours = make('i');
    colours.style.background = `linear-gradient(to right, ${STOPS.join(', ')})`;
    this.names = make('p', { class: 'names' });
    this.apart = make('p', { class: 'apart' });
    this.scale = make('p', { class: 'scale', hidden: true }, '0', colours, `${100 * FULL} cm`);
    this.expected = make('p');
    this.problem = make('p', { class: 'fault', role: 'alert' });
    element.replaceChildren(this.names, this.scale, this.apart, this.expected, this.problem);
  }

  /**
   * Says why something cannot be shown.
   *
   * @param {string} problem
   */
  fault(problem) {
    this.problem.textContent = problem;
  }

  /**
   * @param {Side[]} sides
   * @param {string} problem empty if there is none
   */
  sides(sides, problem) {
    if (this.problem.textContent !== problem) this.fault(problem);
    this.names.replaceChildren(...sides.map(({ label, colour }) => {
      const swatch = make('i');
      swatch.style.background = colour;
      return make('span', {}, swatch, label);
    }));
  }

  /** @param {Apart | undefined} apart */
  at(apart) {
    const text = apart ? `${centimetres(apart.mean)} from ${apart.label.toLowerCase()}, at most ${centimetres(apart.worst)} at ${apart.joint}` : '';
    if (text === this.#shown) return;
    this.apart.textContent = this.#shown = text;
    this.scale.hidden = !apart?.isColoured;
  }
}
