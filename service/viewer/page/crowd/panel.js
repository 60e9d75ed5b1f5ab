import { button, make } from '../panels/dom.js';

/**
 * @typedef {object} Figures
 * @property {number} characters
 * @property {number} pictures a second
 * @property {number} frames a second
 * @property {number} kilobytes a second
 * @property {number} median ms of script for a picture
 * @property {number} worst ms
 * @property {number | undefined} delay seconds
 */

/** @type {Record<string, [string, (figures: Figures) => string]>} explanation and text by label */
const ROWS = {
  Characters: ['Characters that are shown', ({ characters }) => characters.toLocaleString('en')],
  Pictures: ['Pictures drawn in a second', ({ pictures }) => `${pictures.toFixed(0)} /s`],
  Frames: ['Frames received in a second', ({ frames }) => `${frames.toFixed(0)} /s`],
  Script: ['Time that the script of a picture takes: median of the last two seconds', ({ median }) => `${median.toFixed(1)} ms`],
  Worst: ['The longest of them', ({ worst }) => `${worst.toFixed(1)} ms`],
  Delay: ['How long after it is due a frame is shown', ({ delay }) => (delay === undefined ? '' : `${(1000 * delay).toFixed(0)} ms`)],
  Traffic: ['Kilobytes received in a second', ({ kilobytes }) => `${kilobytes.toLocaleString('en', { maximumFractionDigits: 0 })} kB/s`],
};

/** The figures of a crowd, over the stage. */
export class Panel {
  /**
   * @param {HTMLElement} element
   * @param {() => void} onEnd
   */
  constructor(element, onEnd) {
    this.element = element;
    this.problem = make('p', { class: 'fault', role: 'alert' });
    this.values = new Map(Object.entries(ROWS).map(([label, [title]]) => [label, make('dd', { title })]));
    const list = make('dl', {}, ...[...this.values].map(([label, value]) => make('div', {}, make('dt', { title: value.title }, label), value)));
    element.replaceChildren(make('header', {}, make('h2', {}, 'Crowd'), button('End', onEnd, { title: 'Back to the splice' })), list, this.problem);
  }

  /** @param {boolean} isOn */
  show(isOn) {
    this.element.hidden = !isOn;
    this.fault('');
    for (const value of this.values.values()) value.textContent = '';
  }

  /** @param {string} problem */
  fault(problem) {
    if (this.problem.textContent !== problem) this.problem.textContent = problem;
  }

  /** @param {Figures} figures */
  at(figures) {
    for (const [label, value] of this.values) {
      const text = ROWS[label][1](figures);
      if (value.textContent !== text) value.textContent = text;
    }
  }
}
