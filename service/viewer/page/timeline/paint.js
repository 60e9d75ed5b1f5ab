/** How strips and plots are painted. */

/** @import { Theme } from './theme.js' */

/**
 * Where something is painted. Levels go from 0 at the bottom to 1 at the top.
 *
 * @typedef {object} Box
 * @property {CanvasRenderingContext2D} context
 * @property {Theme} theme
 * @property {number} left CSS pixels
 * @property {number} right
 * @property {number} top
 * @property {number} height
 * @property {(frame: number) => number} x CSS pixels of a frame
 */

/** @typedef {[number, number]} Point a frame and a level */

export const FONT = '11px system-ui, sans-serif';
const SMALL = '10px system-ui, sans-serif';

/**
 * Paints only between two sides, until the context is restored.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {number} left
 * @param {number} right
 * @param {number} bottom
 */
export function clip(context, left, right, bottom) {
  context.save();
  context.beginPath();
  context.rect(left, 0, right - left, bottom);
  context.clip();
}

/**
 * Returns a part of a curve as points.
 *
 * @param {ArrayLike<number>} values
 * @param {[number, number]} part first and last frames
 * @param {number} top value at the top
 * @returns {Point[]}
 */
export function alongFrames(values, [first, last], top) {
  return Array.from({ length: last - first + 1 }, (_, at) => [first + at, values[first + at] / top]);
}

/**
 * @param {Box} box
 * @param {Point[]} points
 * @param {string | CanvasGradient} colour
 * @param {number} width CSS pixels
 */
export function line(box, points, colour, width) {
  const { context } = box;
  trace(box, points);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.lineJoin = 'round';
  context.stroke();
  context.lineWidth = 1;
}

/**
 * Fills what is below a curve.
 *
 * @param {Box} box
 * @param {Point[]} points
 * @param {string | CanvasGradient} colour
 * @param {number} alpha
 */
export function area(box, points, colour, alpha) {
  const { context, top, height } = box;
  trace(box, points);
  context.lineTo(box.x(points[points.length - 1][0]), top + height);
  context.lineTo(box.x(points[0][0]), top + height);
  context.closePath();
  context.globalAlpha = alpha;
  context.fillStyle = colour;
  context.fill();
  context.globalAlpha = 1;
}

/**
 * @param {Box} box
 * @param {Point[]} points
 */
function trace({ context, top, height, x }, points) {
  context.beginPath();
  for (const [frame, level] of points) context.lineTo(x(frame), top + height * (1 - Math.min(1, level)));
}

/**
 * Marks a point of a curve, unless it is missing or out of sight.
 *
 * @param {Box} box
 * @param {number} frame
 * @param {number} level
 * @param {string} colour
 */
export function dot({ context, theme, left, right, top, height, x }, frame, level, colour) {
  if (Number.isNaN(level) || x(frame) < left || x(frame) > right) return;
  context.beginPath();
  context.arc(x(frame), top + height * (1 - Math.min(1, level)), 3, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.strokeStyle = theme.panel;
  context.fill();
  context.stroke();
}

/**
 * Fills intervals of frames.
 *
 * @param {Box} box
 * @param {number[][]} intervals
 * @param {string} colour
 */
export function bars({ context, top, height, x }, intervals, colour) {
  context.fillStyle = colour;
  for (const [from, to] of intervals) {
    context.beginPath();
    context.roundRect(x(from), top + 2, Math.max(2, x(to) - x(from)), height - 4, 2);
    context.fill();
  }
}

/**
 * Draws a dotted line at a level.
 *
 * @param {Box} box
 * @param {number} [height] level
 */
export function dotted(box, height = 1) {
  const { context, theme, left, right } = box;
  const top = Math.round(box.top + box.height * (1 - height));
  context.strokeStyle = theme.line;
  context.setLineDash([2, 3]);
  context.beginPath();
  context.moveTo(left, top + 0.5);
  context.lineTo(right, top + 0.5);
  context.stroke();
  context.setLineDash([]);
}

/**
 * Writes the value of a dotted line at its right end, over the curves.
 *
 * @param {Box} box
 * @param {string} text
 * @param {number} [height] level
 */
export function level(box, text, height = 1) {
  box.context.textAlign = 'right';
  note(box, text, box.right - 3, Math.round(box.top + box.height * (1 - height)) + 10);
  box.context.textAlign = 'left';
}

/**
 * Writes small text on the baseline y, readable over curves.
 *
 * @param {Box} box
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} [colour]
 */
export function note({ context, theme }, text, x, y, colour = theme.faint) {
  context.font = SMALL;
  context.lineWidth = 3;
  context.strokeStyle = theme.panel;
  context.lineJoin = 'round';
  context.strokeText(text, x, y);
  context.lineWidth = 1;
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

/**
 * Writes text on a plate of its own, kept between two sides.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} theme
 * @param {string} text
 * @param {number} x of the middle
 * @param {number} y of the middle
 * @param {{ left: number, right: number, fill?: string, ink?: string }} how
 */
export function plate(context, theme, text, x, y, { left, right, fill = theme.panel, ink = theme.text }) {
  context.font = FONT;
  const width = context.measureText(text).width + 8;
  const start = Math.max(left, Math.min(right - width, x - width / 2));
  context.beginPath();
  context.roundRect(start, y - 8, width, 16, 3);
  context.lineWidth = 4;
  context.strokeStyle = theme.panel; // keeps off what is beside it
  context.stroke();
  context.lineWidth = 1;
  context.fillStyle = fill;
  context.fill();
  context.fillStyle = ink;
  context.textAlign = 'left';
  context.textBaseline = 'middle';
  context.fillText(text, start + 4, y + 0.5);
  context.textBaseline = 'alphabetic';
}
