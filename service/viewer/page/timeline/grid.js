import { centimetres, make } from '../panels/dom.js';
import { distanceGrid, legClouds } from './distance_grid.js';
import { heat, heatPicture } from './heat.js';
import { FONT, plate } from './paint.js';
import { clockPieces } from './pieces.js';
import { Plot } from './plot.js';
import { Scrub } from './scrub.js';
import { largest, multiples, plain, timeSteps } from './ticks.js';

/** @import { Player } from '../player.js' */
/** @import { Side } from '../sides.js' */
/** @import { DistanceGrid } from './distance_grid.js' */

/**
 * A grid, as it is painted.
 *
 * @typedef {object} Shown
 * @property {Side} locomotion alone, frame for frame as in the splice
 * @property {Side} action as captured
 * @property {DistanceGrid} grid
 * @property {HTMLCanvasElement} picture
 * @property {number} top metres that are lightest
 * @property {number} across seconds of the locomotion
 * @property {number} up seconds of the action
 * @property {Float32Array} times seconds into the action at each frame
 */

const BELOW = 34; // CSS pixels around the map
const ABOVE = 8;
const NARROW_GUTTER = 84;
const SCALE = 10; // width of the scale of colours, on the left
const HALO = 3.5;

/** The distance grid: how far the legs are apart, each frame of a locomotion against each of an action, and the splice's path. */
export class Grid extends Plot {
  /** @type {Shown | undefined} */
  #shown = undefined;
  #time = 0;
  /** Under the pointer: seconds of the locomotion, and of the action. @type {[number, number] | undefined} */
  #pointed = undefined;

  /**
   * @param {HTMLElement} element
   * @param {Player} player
   */
  constructor(element, player) {
    const plot = make('div', { class: 'grid-plot' });
    super(element, player, plot, NARROW_GUTTER);
    this.caption = make('div', { class: 'grid-caption' });
    element.prepend(this.caption);
    element.classList.add('grid');
    new Scrub(plot, player, () => this.axis, (time, event) => {
      const action = this.#up.time(event.offsetY);
      const isOn = time !== undefined && this.#shown && action >= 0 && action <= this.#shown.up && event.offsetX <= this.axis.right;
      this.#pointed = isOn ? [time, action] : undefined;
      this.front.request();
      this.#write();
    });
  }

  /**
   * Shows a splice's grid. As long as its clips stay, only the path through them is another.
   *
   * @param {Side} locomotion alone, frame for frame as in the splice
   * @param {Side} action as captured
   * @param {Float32Array} actionTimes seconds into the action at each frame of the splice; NaN without one
   */
  show(locomotion, action, actionTimes) {
    if (locomotion === this.#shown?.locomotion && action === this.#shown.action) this.#shown.times = actionTimes;
    else {
      const grid = distanceGrid(legClouds(locomotion.motion), legClouds(action.motion));
      const top = largest(grid.values) || 1;
      this.#shown = {
        locomotion, action, grid, top, picture: heatPicture(grid, top), across: locomotion.motion.duration, up: action.motion.duration, times: actionTimes,
      };
    }
    this.redraw();
    this.#write();
  }

  /**
   * Shows a sentence in place of a grid.
   *
   * @param {string} reason
   */
  clear(reason) {
    this.#shown = this.#pointed = undefined;
    this.redraw();
    this.caption.replaceChildren(make('span', { class: 'grid-title' }, reason));
  }

  /** @param {number} time */
  at(time) {
    if (time === this.#time) return;
    this.#time = time;
    if (!this.#shown || !this.back.width) return;
    this.front.draw();
    this.#write();
  }

  get #up() {
    const bottom = this.back.height - BELOW;
    const pixels = (bottom - ABOVE) / (this.#shown?.up || 1);
    const y = (/** @type {number} */ time) => bottom - time * pixels;
    const time = (/** @type {number} */ at) => (bottom - at) / pixels;
    return { bottom, pixels, y, time };
  }

  /** Writes the values under the pointer, or else where the splice is. */
  #write() {
    if (!this.#shown) return;
    const place = this.#pointed ?? this.#place();
    const words = ['Distance between the legs of the locomotion and the action'];
    if (place) {
      const [across, up] = place;
      words.push(`locomotion ${across.toFixed(2)} s`, `action ${up.toFixed(2)} s`, centimetres(this.#distance(across, up)));
    }
    words.forEach((text, at) => {
      const item = this.caption.children[at] ?? this.caption.appendChild(make('span', { class: at ? 'curves-numbers' : 'grid-title' }));
      if (item.textContent !== text) item.textContent = text;
    });
    while (this.caption.children.length > words.length) this.caption.lastElementChild?.remove();
  }

  /**
   * Returns where the splice is; undefined without an action, and in the seam after its end, which is not in the grid.
   *
   * @returns {[number, number] | undefined}
   */
  #place() {
    const action = this.#shown?.times[Math.round(this.#time * this.player.rate)] ?? NaN;
    return action <= (this.#shown?.up ?? 0) ? [this.#time, action] : undefined;
  }

  /**
   * @param {number} across seconds of the locomotion
   * @param {number} up seconds of the action
   */
  #distance(across, up) {
    const { grid: { columns, rows, values }, across: width, up: height } = /** @type {Shown} */ (this.#shown);
    const column = Math.min(columns - 1, Math.round((across / (width || 1)) * (columns - 1)));
    const row = Math.min(rows - 1, Math.round((up / (height || 1)) * (rows - 1)));
    return values[row * columns + column];
  }

  /** @override @param {CanvasRenderingContext2D} context */
  paintBack(context) {
    if (!this.#shown) return;
    const { left, right, x } = this.axis, { bottom, y } = this.#up;
    const { picture, times, across } = this.#shown;
    this.#ticks(context);
    context.save();
    context.beginPath();
    context.rect(left, ABOVE, right - left, bottom - ABOVE);
    context.clip();
    context.drawImage(picture, x(0), ABOVE, x(across) - x(0), bottom - ABOVE);
    context.beginPath();
    for (const [first, last] of clockPieces(times, this.player.rate)) {
      context.moveTo(x(first / this.player.rate), y(times[first]));
      for (let frame = first + 1; frame <= last; frame++) context.lineTo(x(frame / this.player.rate), y(times[frame]));
    }
    context.lineJoin = 'round';
    for (const [colour, width] of /** @type {[string, number][]} */ ([['#000000', HALO], ['#ffffff', 1.5]])) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.stroke();
    }
    context.restore();
    this.#scale(context);
  }

  /** @param {CanvasRenderingContext2D} context */
  #ticks(context) {
    const { left, right, x } = this.axis, { bottom, y, pixels } = this.#up;
    const { up } = /** @type {Shown} */ (this.#shown);
    context.font = FONT;
    context.fillStyle = this.theme.faint;
    const wide = timeSteps((right - left) / (this.span.to - this.span.from), this.player.rate).major;
    context.textAlign = 'center';
    for (const time of multiples(this.span.from, this.span.to, wide)) {
      context.fillText(plain(time, wide), Math.min(x(time), right - 4), bottom + 14);
    }
    context.fillText('locomotion, s', (left + right) / 2, bottom + 29);
    const high = timeSteps(2 * pixels, this.player.rate).major;
    context.textAlign = 'right';
    for (const time of multiples(0, up, high)) context.fillText(plain(time, high), left - 6, y(time) + 4);
    context.save();
    context.translate(left - 33, (ABOVE + bottom) / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = 'center';
    context.fillText('action, s', 0, 0);
    context.restore();
    context.textAlign = 'left';
  }

  /** @param {CanvasRenderingContext2D} context */
  #scale(context) {
    const { bottom } = this.#up;
    const { top } = /** @type {Shown} */ (this.#shown);
    const colours = context.createLinearGradient(0, bottom, 0, ABOVE);
    for (let stop = 0; stop <= 8; stop++) colours.addColorStop(stop / 8, `rgb(${heat(stop / 8).map(Math.round).join(' ')})`);
    context.fillStyle = colours;
    context.fillRect(8, ABOVE, SCALE, bottom - ABOVE);
    context.fillStyle = this.theme.faint;
    context.font = FONT;
    for (const share of [0, 0.5, 1]) {
      const text = `${(100 * share * top).toFixed(0)}${share === 1 ? ' cm' : ''}`;
      context.fillText(text, SCALE + 13, bottom - share * (bottom - ABOVE) + (share === 1 ? 9 : share * 8));
    }
  }

  /** @override @param {CanvasRenderingContext2D} context */
  paintFront(context) {
    if (!this.#shown) return;
    const { left, right, x } = this.axis, { bottom, y } = this.#up;
    const place = this.#place();
    const isVisible = x(this.#time) >= left - 1 && x(this.#time) <= right + 1;
    context.lineWidth = 1.5;
    context.strokeStyle = '#ffffff';
    if (isVisible) stroke(context, [[x(this.#time), ABOVE], [x(this.#time), bottom]]);
    if (place && isVisible) {
      context.beginPath();
      context.arc(x(place[0]), y(place[1]), 5, 0, 2 * Math.PI);
      context.fillStyle = this.theme.accent;
      context.fill();
      context.stroke();
    }
    if (!this.#pointed) return;
    const [px, py] = [x(this.#pointed[0]), y(this.#pointed[1])];
    context.lineWidth = 1;
    context.setLineDash([3, 3]);
    stroke(context, [[px, ABOVE], [px, bottom]]);
    stroke(context, [[left, py], [right, py]]);
    context.setLineDash([]);
    plate(context, this.theme, centimetres(this.#distance(...this.#pointed)), px, py < 30 ? py + 18 : py - 16, { left, right });
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {[[number, number], [number, number]]} ends
 */
function stroke(context, [from, to]) {
  context.globalAlpha = 0.8;
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
  context.globalAlpha = 1;
}
