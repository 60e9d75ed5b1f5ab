import { FONT, plate } from './paint.js';
import { multiples, plain, timeSteps } from './ticks.js';

/** @import { Theme } from './theme.js' */
/** @import { Span } from './span.js' */

export const RULER = 22; // CSS pixels
export const GUTTER = 140; // of labels, left of strips and plots
export const NARROW = 620; // width below which there is no gutter
export const EDGE = 10;
export const LANE = 11; // below the ruler, with the bar of the repeated range

/**
 * Where times are on a strip.
 *
 * @typedef {object} Axis
 * @property {number} left CSS pixels
 * @property {number} right
 * @property {(time: number) => number} x
 * @property {(x: number) => number} time
 */

/**
 * @param {Span} span
 * @param {number} left
 * @param {number} right
 * @returns {Axis}
 */
export function timeAxis(span, left, right) {
  const pixels = Math.max(1, right - left) / (span.to - span.from);
  return { left, right, x: (time) => left + (time - span.from) * pixels, time: (x) => span.from + (x - left) / pixels };
}

/**
 * Paints ticks, with seconds and the frame's number at the large ones, and lines down through the strips.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} theme
 * @param {Axis} axis
 * @param {Span} span
 * @param {number} bottom of the lines
 */
export function paintRuler(context, theme, axis, span, bottom) {
  const { rate } = span.player;
  const { major, minor } = timeSteps((axis.right - axis.left) / (span.to - span.from), rate);
  context.font = FONT;
  context.strokeStyle = theme.line;
  context.beginPath();
  for (const time of multiples(span.from, span.to, minor)) stroke(context, axis.x(time), RULER - 4, RULER);
  context.stroke();
  for (const time of multiples(span.from, span.to, major)) {
    const x = axis.x(time);
    context.beginPath();
    stroke(context, x, 5, RULER);
    context.strokeStyle = theme.faint;
    context.stroke();
    context.globalAlpha = 0.55;
    context.beginPath();
    stroke(context, x, RULER, bottom);
    context.strokeStyle = theme.line;
    context.stroke();
    context.globalAlpha = 1;
    const seconds = `${plain(time, major)} s`;
    const width = context.measureText(seconds).width;
    const frame = String(Math.round(time * rate));
    if (x + width + 4 > axis.right) continue;
    context.fillStyle = theme.text;
    context.fillText(seconds, x + 4, 14);
    context.fillStyle = theme.faint;
    if (x + width + context.measureText(frame).width + 10 < axis.right) context.fillText(frame, x + width + 10, 14);
  }
}

/**
 * Paints the bar of the repeated range with its handles, and dims the strips outside it.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} theme
 * @param {Axis} axis
 * @param {[number, number]} range seconds
 * @param {{ isWhole: boolean, bottom: number }} how
 */
export function paintRange(context, theme, axis, [from, to], { isWhole, bottom }) {
  const [start, end] = [from, to].map((time) => Math.max(axis.left, Math.min(axis.right, axis.x(time))));
  const colour = isWhole ? theme.line : theme.accent;
  context.fillStyle = colour;
  context.globalAlpha = isWhole ? 0.6 : 0.35;
  context.fillRect(start, RULER + 4, end - start, 4);
  context.globalAlpha = 1;
  context.fillStyle = isWhole ? theme.faint : colour;
  for (const [x, side] of [[axis.x(from), 0], [axis.x(to), -5]]) {
    if (x < axis.left - 1 || x > axis.right + 1) continue;
    context.beginPath();
    context.roundRect(x + side, RULER + 1.5, 5, 9, 1.5);
    context.fill();
  }
  if (isWhole) return;
  context.fillStyle = theme.panel;
  context.globalAlpha = 0.6;
  context.fillRect(axis.left, RULER + LANE, start - axis.left, bottom - RULER - LANE);
  context.fillRect(end, RULER + LANE, axis.right - end, bottom - RULER - LANE);
  context.globalAlpha = 1;
}

/**
 * Paints a bar that shows which part of the motion is visible. Paints nothing if all of it is.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} theme
 * @param {Axis} axis
 * @param {Span} span
 * @param {number} top
 */
export function paintVisible(context, theme, axis, span, top) {
  if (span.isWhole) return;
  const pixels = (axis.right - axis.left) / span.duration;
  context.globalAlpha = 0.7;
  context.fillStyle = theme.faint;
  context.beginPath();
  context.roundRect(axis.left + span.from * pixels, top + 2, Math.max(8, (span.to - span.from) * pixels), 4, 2);
  context.fill();
  context.globalAlpha = 1;
}

/**
 * Paints a moment: a line through all strips, and on the ruler a plate with its time and its frame.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} theme
 * @param {Axis} axis
 * @param {number} time
 * @param {{ bottom: number, rate: number, isHead: boolean }} how `isHead` for the playhead, else for the pointer
 */
export function paintMoment(context, theme, axis, time, { bottom, rate, isHead }) {
  const x = axis.x(time);
  if (x < axis.left - 1 || x > axis.right + 1) return;
  context.strokeStyle = isHead ? theme.accent : theme.faint;
  context.lineWidth = isHead ? 1.5 : 1;
  context.beginPath();
  stroke(context, x, RULER - 4, bottom);
  context.stroke();
  context.lineWidth = 1;
  const how = isHead ? { fill: theme.accent, ink: theme.back } : { fill: theme.line, ink: theme.text };
  plate(context, theme, `${time.toFixed(2)} s  ${Math.round(time * rate)}`, x, 11, { left: axis.left - 4, right: axis.right + 4, ...how });
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x
 * @param {number} top
 * @param {number} bottom
 */
function stroke(context, x, top, bottom) {
  context.moveTo(Math.round(x) + 0.5, top);
  context.lineTo(Math.round(x) + 0.5, bottom);
}
