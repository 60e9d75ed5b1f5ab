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
    this.names.className = 'names';
    this.problem.className = 'fault';
    this.problem.setAttribute('role', 'alert');
    this.apart.className = 'apart';
    element.replaceChildren(this.names, this.apart, this.problem);
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
    if (text !== this.#shown) this.apart.textContent = this.#shown = text;
  }
}

/** @param {number} metres */
function centimetres(metres) {
  return `${(100 * metres).toFixed(1)} cm`;
}
