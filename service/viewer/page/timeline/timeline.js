import { make } from '../panels/dom.js';
import { FONT, clip, dot } from './paint.js';
import { Plot } from './plot.js';
import { Pointer } from './pointer.js';
import { LANE, RULER, paintMoment, paintRange, paintRuler, paintVisible } from './ruler.js';
import { rowsOf } from './rows.js';

/** @import { Player } from '../player.js' */
/** @import { Row, TimelineData } from './rows.js' */
/** @import { Box } from './paint.js' */

const GAP = 5; // CSS pixels between strips
const NARROW_EDGE = 18; // with the letter of a foot
const HEADING = 14; // above a strip without a gutter
const BAR = 9; // height of the bar of what is visible, below the strips

/** Strips over time: phase, contacts, the action's clock, and distances. A click or a drag seeks. */
export class Timeline extends Plot {
  /** @type {TimelineData | undefined} */
  data = undefined;
  /** Seconds under the pointer; undefined if it is elsewhere. @type {number | undefined} */
  pointed = undefined;
  /** @type {Row[]} */
  #rows = [];
  #time = 0;
  #describedFrame = -1;

  /**
   * @param {HTMLElement} element
   * @param {Player} player
   */
  constructor(element, player) {
    const slider = make('div', { class: 'timeline-strips', tabindex: 0, role: 'slider', 'aria-label': 'Time' });
    super(element, player, slider, NARROW_EDGE);
    this.slider = slider;
    element.classList.add('timeline');
    new Pointer(this);
    new ResizeObserver(() => requestAnimationFrame(() => this.#fit())).observe(element); // later, for it changes the size
    player.state.on((changed) => {
      if (changed.has('from') || changed.has('to')) this.back.request();
      if (changed.has('playing')) this.#describe(true);
    });
  }

  /** @param {TimelineData} data */
  show(data) {
    this.data = data;
    this.#rows = rowsOf(data);
    this.span.resize(data.duration);
    this.#fit();
    this.redraw();
    this.#describe(true);
  }

  /**
   * Shows more of the same motion.
   *
   * @param {Partial<TimelineData>} data
   */
  add(data) {
    if (this.data) this.show({ ...this.data, ...data });
  }

  /** @param {number} time */
  at(time) {
    if (time === this.#time) return;
    this.#time = time;
    this.span.reveal(time);
    this.front.draw();
    this.#describe(false);
  }

  /** Height of all strips. */
  get bottom() {
    return this.#rows.reduce((sum, row) => sum + row.height + GAP + this.#heading(row), RULER + LANE + 2);
  }

  /** @param {Row} row */
  #heading(row) {
    return this.isNarrow && row.level ? HEADING : 0;
  }

  #fit() {
    this.slider.style.height = `${this.bottom + BAR}px`;
  }

  /** @param {number} time */
  frameOf(time) {
    return Math.max(0, Math.min((this.data?.phases.length ?? 1) - 1, Math.round(time * this.player.rate)));
  }

  /**
   * Yields each strip and its box.
   *
   * @param {CanvasRenderingContext2D} context
   * @returns {Generator<[Row, Box]>}
   */
  * #boxes(context) {
    const { left, right, x } = this.axis;
    let top = RULER + LANE + 2;
    for (const row of this.#rows) {
      top += this.#heading(row);
      yield [row, { context, theme: this.theme, left, right, top, height: row.height, x: (frame) => x(frame / this.player.rate) }];
      top += row.height + GAP;
    }
  }

  /** @override @param {CanvasRenderingContext2D} context */
  paintBack(context) {
    const { axis, bottom } = this;
    clip(context, axis.left - 6, axis.right + 6, bottom);
    paintRuler(context, this.theme, axis, this.span, bottom);
    context.restore();
    clip(context, axis.left, axis.right + 1, bottom);
    for (const [row, box] of this.#boxes(context)) {
      context.strokeStyle = this.theme.line;
      context.beginPath();
      context.moveTo(axis.left, box.top + box.height + 0.5);
      context.lineTo(axis.right, box.top + box.height + 0.5);
      context.stroke();
      row.paint(box);
    }
    const { from, to } = this.player.state.values;
    context.restore();
    clip(context, axis.left - 6, axis.right + 6, bottom);
    paintRange(context, this.theme, axis, this.player.range, { isWhole: !from && !to, bottom });
    context.restore();
    paintVisible(context, this.theme, axis, this.span, bottom);
    context.font = FONT;
    context.fillStyle = this.theme.faint;
    for (const [row, { left, top, height }] of this.#boxes(context)) {
      if (!this.isNarrow) context.fillText(row.label, 8, top + height / 2 + 4);
      else if (row.level) context.fillText(row.label, left, top - 4);
      else context.fillText(row.label[0], 5, top + height / 2 + 4);
    }
  }

  /** @override @param {CanvasRenderingContext2D} context */
  paintFront(context) {
    if (!this.data) return;
    const { axis, bottom, pointed, player: { rate } } = this;
    const isApart = pointed !== undefined && Math.abs(axis.x(pointed) - axis.x(this.#time)) >= 1;
    paintMoment(context, this.theme, axis, this.#time, { bottom, rate, isHead: true });
    if (isApart) paintMoment(context, this.theme, axis, pointed, { bottom, rate, isHead: false });
    const frame = this.frameOf(pointed ?? this.#time);
    for (const [row, box] of this.#boxes(context)) {
      if (row.level) dot(box, frame, row.level(frame), this.theme.text);
      this.#value(row, box, frame, isApart);
    }
  }

  /**
   * @param {Row} row
   * @param {Box} box
   * @param {number} frame
   * @param {boolean} isPointed whether it is the value under the pointer
   */
  #value(row, { context, left, top, height }, frame, isPointed) {
    const isNarrow = this.isNarrow;
    if (isNarrow && !row.level) return;
    context.font = FONT;
    context.textAlign = isNarrow ? 'left' : 'right';
    context.fillStyle = isPointed ? this.theme.accent : this.theme.text;
    context.fillText(row.text(frame), isNarrow ? left + 72 : left - 10, isNarrow ? top - 4 : top + height / 2 + 4);
    context.textAlign = 'left';
  }

  /**
   * Describes the moment for screen readers: at each frame while it is paused, once a second while it plays.
   *
   * @param {boolean} isNew whether more has changed than the time
   */
  #describe(isNew) {
    const frame = this.frameOf(this.#time);
    const isQuiet = this.player.state.values.playing && Math.abs(frame - this.#describedFrame) < this.player.rate;
    if (!this.data || (!isNew && (isQuiet || frame === this.#describedFrame))) return;
    this.#describedFrame = frame;
    const values = this.#rows.map((row) => row.words?.(frame) ?? `${row.label} ${row.text(frame)}`).filter(Boolean);
    this.slider.setAttribute('aria-valuemin', '0');
    this.slider.setAttribute('aria-valuemax', this.data.duration.toFixed(3));
    this.slider.setAttribute('aria-valuenow', this.#time.toFixed(3));
    this.slider.setAttribute('aria-valuetext', [`${this.#time.toFixed(2)} seconds`, `frame ${frame}`, ...values].join(', '));
  }
}
