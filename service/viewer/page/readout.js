import { FULL, STOPS } from './scene/differences.js';

/** @import { Side } from './sides.js' */

/** @typedef {{ label: string, mean: number, worst: number, joint: string }} Apart */

/** What stands over the stage: which colour is which side, and how far they are apart. */
export class Readout {
  #shown = '';

  /** @param {HTMLElement} element */
  constructor(element) {
    this.names = document.createElement('p');
    this.apart = document.createElement('p');
    this.problem = document.createElement('p');
    this.scale = document.createElement('p');
    const colours = document.createElement('i');
    colours.style.background = `linear-gradient(to right, ${STOPS.join(', ')})`;
    this.scale.append('0', colours, `${100 * FULL} cm`);
    this.scale.className = 'scale';
    this.scale.hidden = true;
    this.names.className = 'names';
    this.problem.className = 'fault';
    this.problem.setAttribute('role', 'alert');
    this.apart.className = 'apart';
    element.replaceChildren(this.names, this.apart, this.scale, this.problem);
  }

  /**
   * Says why something cannot be shown.
   *
   * @param {string} problem
   */
  fault(problem) {
    this.problem.textContent = problem;
  }

  /** @param {Side[]} sides */
  sides(sides) {
    this.problem.textContent = '';
    this.names.replaceChildren(...sides.map(({ label, colour }) => {
      const name = document.createElement('span');
      const swatch = document.createElement('i');
      swatch.style.background = colour;
      name.append(swatch, label);
      return name;
    }));
  }

  /** @param {Apart | undefined} apart */
  at(apart) {
    const text = apart ? `${centimetres(apart.mean)} from ${apart.label.toLowerCase()}, at most ${centimetres(apart.worst)} at ${apart.joint}` : '';
    if (text === this.#shown) return;
    this.apart.textContent = this.#shown = text;
    this.scale.hidden = !apart;
  }
}

/** @param {number} metres */
function centimetres(metres) {
  return `${(100 * metres).toFixed(1)} cm`;
}
