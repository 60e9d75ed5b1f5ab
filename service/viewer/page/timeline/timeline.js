import { FONT, plate } from './paint.js';
import { Pointer } from './pointer.js';
import { LANE, RULER, paintMoment, paintRange, paintRuler, timeAxis } from './ruler.js';
import { rowsOf } from './rows.js';
import { Span } from './span.js';
import { Surface, make } from './surface.js';
import { onTheme, themeOf } from './theme.js';

/** @import { Player } from '../player.js' */
/** @import { Row, TimelineData } from './rows.js' */
/** @import { Box } from './paint.js' */
/** @import { Theme } from './theme.js' */

const GAP = 5; // CSS pixels between strips
const GUTTER = 132; // of labels and values, on the left
const NARROW = 620; // width without a gutter: labels are in the strips
const EDGE = 10;

/** Strips over time: what the legs and the action do, and where the splice is good. Click or drag to seek. */
export class Timeline {
  /** @type {TimelineData | undefined} */
  data = undefined;
  /** Seconds that are pointed at; undefined if none are. @type {number | undefined} */
  pointed = undefined;
  /** @type {Row[]} */
  #rows = [];
  /** @type {Theme} */
  #theme;
  #time = 0;
  #spokenFrame = -1;

  /**
   * @param {HTMLElement} element
   * @param {Player} player
   */
  constructor(element, player) {
    this.element = element;
    this.player = player;
    this.span = Span.of(player);
    element.classList.add('timeline');
    this.slider = make('div', 'timeline-strips');
    this.slider.tabIndex = 0;
    this.slider.setAttribute('role', 'slider');
    this.slider.setAttribute('aria-label', 'Time');
    element.append(this.slider);
    this.#theme = themeOf(element);
    this.back = new Surface(this.slider, (context, width) => this.#paintStrips(context, width));
    this.front = new Surface(this.slider, (context, width) => this.#paintMoments(context, width));
    new Pointer(this);
    this.span.on(() => this.redraw());
    onTheme(() => this.redraw());
    player.state.on((changed) => {
      if (changed.has('from') || changed.has('to')) this.back.request();
      if (changed.has('playing')) this.#speak(true);
    });
  }

  /** @param {TimelineData} data */
  show(data) {
    this.data = data;
    this.#rows = rowsOf(data);
    this.slider.style.height = `${this.bottom + 4}px`;
    this.span.resize(data.duration);
    this.redraw();
    this.#speak(true);
  }

  /** @param {number} time */
  at(time) {
    if (time === this.#time) return;
    this.#time = time;
    if (this.player.state.values.playing) this.span.reveal(time);
    this.front.draw();
    this.#speak(false);
  }

  /** Paints all again, as when a stylesheet has changed the colours. */
  redraw() {
    this.back.request();
    this.front.request();
  }

  /** Where times are. */
  get axis() {
    const { clientWidth } = this.slider;
    return timeAxis(this.span, clientWidth < NARROW ? EDGE : GUTTER, clientWidth - EDGE);
  }

  /** Height of all strips. */
  get bottom() {
    return this.#rows.reduce((sum, row) => sum + row.height + GAP, RULER + LANE + 2);
  }

  /** @param {number} time */
  frameOf(time) {
    return Math.max(0, Math.min((this.data?.phases.length ?? 1) - 1, Math.round(time * this.player.rate)));
  }

  /**
   * Yields the strips and where they are.
   *
   * @param {CanvasRenderingContext2D} context
   * @returns {Generator<[Row, Box]>}
   */
  * #boxes(context) {
    const { left, right, x } = this.axis;
    let top = RULER + LANE + 2;
    for (const row of this.#rows) {
      yield [row, { context, theme: this.#theme, left, right, top, height: row.height, x: (frame) => x(frame / this.player.rate) }];
      top += row.height + GAP;
    }
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {number} width
   */
  #paintStrips(context, width) {
    this.#theme = themeOf(this.element);
    const { axis, bottom } = this;
    const isNarrow = width < NARROW;
    context.save();
    context.beginPath();
    context.rect(axis.left - 6, 0, axis.right - axis.left + 12, bottom);
    context.clip();
    paintRuler(context, this.#theme, axis, this.span, bottom);
    for (const [row, box] of this.#boxes(context)) {
      context.strokeStyle = this.#theme.line;
      context.beginPath();
      context.moveTo(axis.left, box.top + box.height + 0.5);
      context.lineTo(axis.right, box.top + box.height + 0.5);
      context.stroke();
      row.paint(box);
    }
    const { from, to } = this.player.state.values;
    const range = /** @type {[number, number]} */ (this.player.range);
    paintRange(context, this.#theme, axis, range, { isWhole: !from && !to, bottom });
    context.restore();
    if (isNarrow) return;
    context.font = FONT;
    context.fillStyle = this.#theme.faint;
    for (const [row, { top, height }] of this.#boxes(context)) context.fillText(row.label, 8, top + height / 2 + 4);
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {number} width
   */
  #paintMoments(context, width) {
    if (!this.data) return;
    const { axis, bottom, pointed } = this;
    const shown = pointed ?? this.#time;
    const name = (/** @type {number} */ time) => `${time.toFixed(2)} s  ${Math.round(time * this.player.rate)}`;
    const isApart = pointed !== undefined && Math.abs(axis.x(pointed) - axis.x(this.#time)) >= 1;
    paintMoment(context, this.#theme, axis, this.#time, { bottom, text: name(this.#time), isHead: true });
    if (isApart) paintMoment(context, this.#theme, axis, pointed, { bottom, text: name(pointed), isHead: false });
    const frame = this.frameOf(shown);
    for (const [row, box] of this.#boxes(context)) {
      this.#dot(row, box, frame);
      if (width >= NARROW) this.#value(context, row.text(frame), box, isApart);
      else if (row.height > 20) plate(context, this.#theme, `${row.label}  ${row.text(frame)}`, 0, box.top + 9, { left: 2, right: width });
    }
  }

  /**
   * @param {Row} row
   * @param {Box} box
   * @param {number} frame
   */
  #dot(row, { context, left, right, top, height, x }, frame) {
    const level = row.level?.(frame) ?? NaN;
    if (Number.isNaN(level) || x(frame) < left || x(frame) > right) return;
    context.beginPath();
    context.arc(x(frame), top + height * (1 - Math.min(1, level)), 3, 0, 2 * Math.PI);
    context.fillStyle = this.#theme.text;
    context.strokeStyle = this.#theme.panel;
    context.fill();
    context.stroke();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {string} text
   * @param {Box} box
   * @param {boolean} isPointed
   */
  #value(context, text, { left, top, height }, isPointed) {
    context.font = FONT;
    context.textAlign = 'right';
    context.fillStyle = isPointed ? this.#theme.accent : this.#theme.text;
    context.fillText(text, left - 10, top + height / 2 + 4);
    context.textAlign = 'left';
  }

  /**
   * Says the moment to screen readers: each frame while it stands, once a second while it plays.
   *
   * @param {boolean} isNew whether more has changed than the time
   */
  #speak(isNew) {
    const frame = this.frameOf(this.#time);
    const isQuiet = this.player.state.values.playing && Math.abs(frame - this.#spokenFrame) < this.player.rate;
    if (!this.data || (!isNew && (isQuiet || frame === this.#spokenFrame))) return;
    this.#spokenFrame = frame;
    const values = this.#rows.map((row) => row.words?.(frame) ?? `${row.label} ${row.text(frame)}`).filter(Boolean);
    this.slider.setAttribute('aria-valuemin', '0');
    this.slider.setAttribute('aria-valuemax', this.data.duration.toFixed(3));
    this.slider.setAttribute('aria-valuenow', this.#time.toFixed(3));
    this.slider.setAttribute('aria-valuetext', [`${this.#time.toFixed(2)} seconds`, `frame ${frame}`, ...values].join(', '));
  }
}
