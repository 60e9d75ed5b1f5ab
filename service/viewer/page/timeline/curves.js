import { make } from '../panels/dom.js';
import { jointCurves } from './curve_values.js';
import { FONT, alongFrames, clip, dot, line, note } from './paint.js';
import { Plot } from './plot.js';
import { RULER, paintMoment, paintRuler } from './ruler.js';
import { Scrub } from './scrub.js';
import { axis as valueAxis, multiples, plain, readable } from './ticks.js';

/** @import { Player } from '../player.js' */
/** @import { Side } from '../sides.js' */
/** @import { JointCurves } from './curve_values.js' */
/** @import { Box } from './paint.js' */

/** @typedef {{ label: string, colour: string, curves: JointCurves }} Shown */

/** @type {{ key: keyof JointCurves, label: string, unit: string, least: number, digits: number, width: number }[]} */
const PLOTS = [
  { key: 'angle', label: 'Angle from bind pose', unit: '°', least: 10, digits: 1, width: 5 },
  { key: 'turning', label: 'Angular speed', unit: '°/s', least: 50, digits: 0, width: 4 },
  { key: 'speed', label: 'World speed', unit: 'm/s', least: 0.5, digits: 2, width: 4 },
];
const GAP = 13;
const NARROW_GUTTER = 34;
const DIGIT_SPACE = '\u2007'; // as wide as a digit, so that numbers stand still

/** Curves of one joint over time, a line for each side. */
export class Curves extends Plot {
  /** @type {Shown[]} */
  #shown = [];
  /** Computed curves by joint. @type {WeakMap<Side, Map<string, JointCurves | undefined>>} */
  #known = new WeakMap();
  /** @type {Record<string, { top: number, step: number }>} */
  #axes = {};
  /** @type {HTMLElement[]} */
  #numbers = [];
  #time = 0;
  /** Seconds under the pointer. @type {number | undefined} */
  #pointed = undefined;

  /**
   * @param {HTMLElement} element
   * @param {Player} player
   */
  constructor(element, player) {
    const plots = make('div', { class: 'curves-plots' });
    super(element, player, plots, NARROW_GUTTER);
    this.plots = plots;
    this.legend = make('div', { class: 'curves-legend' });
    element.prepend(this.legend);
    element.classList.add('curves');
    new Scrub(this.plots, player, () => this.axis, (time) => {
      this.#pointed = time;
      this.front.request();
      this.#write();
    });
  }

  /**
   * @param {Side[]} sides
   * @param {string} joint
   */
  show(sides, joint) {
    this.#shown = [];
    for (const side of sides) {
      const curves = this.#of(side, joint);
      if (curves) this.#shown.push({ label: side.label, colour: side.colour, curves });
    }
    for (const { key, least } of PLOTS) {
      this.#axes[key] = valueAxis(readable(this.#shown.map(({ curves }) => curves[key])), least);
    }
    const isEmpty = !this.#shown.length;
    this.plots.hidden = isEmpty;
    const reason = joint ? `Joint ${joint} not found` : 'Choose a joint to see its curves';
    this.legend.replaceChildren(isEmpty ? make('span', { class: 'curves-empty' }, reason) : make('span', { class: 'curves-joint' }, joint));
    this.#numbers = this.#shown.map(({ label, colour }) => {
      const swatch = make('span', { class: 'curves-swatch' }), numbers = make('span', { class: 'curves-numbers' });
      swatch.style.background = colour;
      this.legend.append(make('span', { class: 'curves-side' }, swatch, make('span', { class: 'curves-name' }, label), numbers));
      return numbers;
    });
    this.redraw();
    this.#write();
  }

  /** @param {number} time */
  at(time) {
    if (time === this.#time) return;
    this.#time = time;
    if (!this.#shown.length || !this.back.width) return;
    this.front.draw();
    this.#write();
  }

  /**
   * @param {Side} side
   * @param {string} joint
   */
  #of(side, joint) {
    const known = this.#known.get(side) ?? new Map();
    this.#known.set(side, known);
    if (!known.has(joint)) known.set(joint, jointCurves(side.motion, joint));
    return /** @type {JointCurves | undefined} */ (known.get(joint));
  }

  /** Writes the values under the pointer, or else at the playhead. */
  #write() {
    const frame = Math.round((this.#pointed ?? this.#time) * this.player.rate);
    this.#shown.forEach(({ curves }, at) => {
      const last = curves.angle.length - 1;
      const values = PLOTS.map(({ key, unit, digits, width }) => {
        const number = curves[key][Math.min(frame, last)].toFixed(digits).padStart(width, DIGIT_SPACE);
        return `${number}${unit === '°' ? '' : ' '}${unit}`;
      });
      const text = values.join(' ');
      if (this.#numbers[at].textContent !== text) this.#numbers[at].textContent = text;
    });
  }

  /**
   * Yields each plot, its box, and its value axis.
   *
   * @param {CanvasRenderingContext2D} context
   * @param {number} bottom
   * @returns {Generator<[PLOTS[0], Box, { top: number, step: number }]>}
   */
  * #boxes(context, bottom) {
    const { left, right, x } = this.axis;
    const height = (bottom - RULER - GAP * PLOTS.length - 8) / PLOTS.length;
    let top = RULER + GAP;
    for (const plot of PLOTS) {
      const place = (/** @type {number} */ frame) => x(frame / this.player.rate);
      const box = { context, theme: this.theme, left, right, top, height, x: place };
      yield [plot, box, this.#axes[plot.key]];
      top += height + GAP;
    }
  }

  /** @override @param {CanvasRenderingContext2D} context @param {number} bottom */
  paintBack(context, bottom) {
    if (!this.#shown.length) return;
    const { axis } = this;
    clip(context, axis.left - 6, axis.right + 6, bottom);
    paintRuler(context, this.theme, axis, this.span, bottom);
    context.restore();
    for (const [plot, box, { top, step }] of this.#boxes(context, bottom)) {
      this.#levels(box, top, step);
      clip(context, axis.left, axis.right, bottom);
      for (const { curves, colour } of [...this.#shown].reverse()) {
        const values = curves[plot.key];
        line(box, alongFrames(values, [0, values.length - 1], top), colour, 1.5); // the first side on top
      }
      context.restore();
      if (this.isNarrow) note(box, `${plot.label} (${plot.unit})`, axis.left + 4, box.top + 9);
      else this.#label(box, plot.label, plot.unit);
    }
  }

  /**
   * @param {Box} box
   * @param {number} top
   * @param {number} step
   */
  #levels({ context, theme, left, right, top: start, height }, top, step) {
    context.font = FONT;
    context.textAlign = 'right';
    context.textBaseline = 'middle';
    for (const value of multiples(0, top, step)) {
      const y = Math.round(start + height * (1 - value / top)) + 0.5;
      context.strokeStyle = theme.line;
      context.beginPath();
      context.moveTo(left, y);
      context.lineTo(right, y);
      context.stroke();
      context.fillStyle = theme.faint;
      context.fillText(plain(value, step), left - 6, y);
    }
    context.textAlign = 'left';
    context.textBaseline = 'alphabetic';
  }

  /**
   * @param {Box} box
   * @param {string} label
   * @param {string} unit
   */
  #label({ context, theme, top, height }, label, unit) {
    context.font = FONT;
    context.fillStyle = theme.faint;
    const words = label.split(' from ');
    context.fillText(words[0], 8, top + height / 2 - 2);
    context.fillText(words[1] ? `from ${words[1]}, ${unit}` : unit, 8, top + height / 2 + 12);
  }

  /** @override @param {CanvasRenderingContext2D} context @param {number} bottom */
  paintFront(context, bottom) {
    if (!this.#shown.length) return;
    const { axis, player: { rate } } = this, pointed = this.#pointed;
    paintMoment(context, this.theme, axis, this.#time, { bottom, rate, isHead: true });
    if (pointed !== undefined) paintMoment(context, this.theme, axis, pointed, { bottom, rate, isHead: false });
    const frame = Math.round((pointed ?? this.#time) * rate);
    for (const [plot, box, { top }] of this.#boxes(context, bottom)) {
      for (const { curves, colour } of [...this.#shown].reverse()) {
        dot(box, frame, curves[plot.key][Math.min(frame, curves.angle.length - 1)] / top, colour);
      }
    }
  }
}
