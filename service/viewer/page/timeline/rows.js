import { centimetres } from '../panels/dom.js';
import { alongFrames, area, bars, dotted, level, line, note } from './paint.js';
import { clockPieces, isWithin, pace, pieces, ramps } from './pieces.js';
import { axis, largest } from './ticks.js';

/** @import { Box } from './paint.js' */

/**
 * What a timeline shows. Frames are those of the motion that is played.
 *
 * @typedef {object} TimelineData
 * @property {number} duration seconds
 * @property {number} rate frames per second
 * @property {Float32Array} phases strides at each frame
 * @property {Float32Array} [actionTimes] seconds into the action at each frame; NaN without one
 * @property {number} [actionDuration] seconds
 * @property {{ left: [number, number][], right: [number, number][] }} contacts seconds of each stance
 * @property {{ frame: number, event: string, action?: string }[]} events
 * @property {Float32Array} [mismatches] metres between the legs at each frame; NaN without an action
 * @property {boolean} [stands] whether the action was captured standing, so that its legs do not matter
 * @property {Float32Array} [differences] metres between two sides at each frame
 * @property {{ action?: string, difference?: string }} [colours]
 * @property {{ action?: string, difference?: string }} [names] of the clip, and of what is compared
 */

/**
 * One strip of the timeline.
 *
 * @typedef {object} Row
 * @property {string} label
 * @property {number} height CSS pixels
 * @property {(box: Box) => void} paint
 * @property {(frame: number) => string} text the value at a frame
 * @property {(frame: number) => string} [words] the value for a screen reader, if the text says too little
 * @property {(frame: number) => number} [level] the value's place in the strip: 0 at the bottom, 1 at the top, NaN if missing
 */

const NONE = new Float32Array(0); // the strip is there before the mismatches, so that the page does not jump
const BAD = 0.1; // metres between legs from which a splice looks wrong

/**
 * Returns the strips, from above.
 *
 * @param {TimelineData} data
 * @returns {Row[]}
 */
export function rowsOf(data) {
  const { actionTimes, mismatches = NONE, differences } = data;
  const rows = [phaseRow(data), contactRow(data, 'left'), contactRow(data, 'right')];
  if (actionTimes) rows.push(actionRow(data, actionTimes));
  if (actionTimes && !data.stands) rows.push(mismatchRow(mismatches, actionTimes));
  if (differences) rows.push(differenceRow(differences, data.names?.difference ?? 'Difference', data.colours?.difference));
  return rows;
}

/**
 * @param {TimelineData} data
 * @returns {Row}
 */
function phaseRow({ phases }) {
  const fraction = (/** @type {number} */ frame) => phases[frame] - Math.floor(phases[frame]);
  return {
    label: 'Phase',
    height: 26,
    paint(box) {
      for (const ramp of ramps(phases)) {
        area(box, ramp, box.theme.text, 0.1);
        line(box, ramp, box.theme.text, 1.25);
        const start = Math.max(box.left, box.x(ramp[0][0]));
        const stride = Math.floor(phases[Math.floor(ramp[0][0] + 1)] ?? NaN);
        if (box.x(ramp[ramp.length - 1][0]) - start > 28) note(box, String(stride), start + 4, box.top + 9);
      }
    },
    text: (frame) => phases[frame]?.toFixed(2) ?? '',
    words: (frame) => `phase ${phases[frame]?.toFixed(2)} strides`,
    level: fraction,
  };
}

/**
 * @param {TimelineData} data
 * @param {'left' | 'right'} foot
 * @returns {Row}
 */
function contactRow({ contacts, rate }, foot) {
  return {
    label: foot === 'left' ? 'Left foot' : 'Right foot',
    height: 13,
    paint: (box) => bars(box, contacts[foot].map(([from, to]) => [from * rate, to * rate]), box.theme[foot]),
    text: (frame) => (isWithin(contacts[foot], frame / rate) ? 'down' : 'up'),
    words: (frame) => `${foot} foot ${isWithin(contacts[foot], frame / rate) ? 'down' : 'up'}`,
  };
}

/**
 * @param {TimelineData} data
 * @param {Float32Array} times
 * @returns {Row}
 */
function actionRow({ rate, actionDuration = 0, colours, names }, times) {
  const end = largest(times);
  const top = Math.max(actionDuration, end) || 1; // the seam after the clip's end is beyond its duration
  const parts = clockPieces(times, rate);
  const name = names?.action ?? 'action';
  return {
    label: 'Action',
    height: 38,
    paint(box) {
      const colour = colours?.action ?? box.theme.accent;
      if (actionDuration) dotted(box, actionDuration / top);
      for (const part of parts) {
        const points = alongFrames(times, part, top);
        area(box, points, colour, 0.14);
        line(box, points, colour, 1.5);
      }
      for (const [first, last] of pieces(times)) {
        if (first > 0) flag(box, first, `${name} begins`, true);
        if (last < times.length - 1) flag(box, last, `${name} ends`, false);
      }
      if (actionDuration) level(box, `${actionDuration.toFixed(2)} s`, actionDuration / top);
    },
    text(frame) {
      const speed = pace(parts, times, rate, frame);
      return isMissing(times[frame]) ? 'none' : `${times[frame].toFixed(2)} s${Number.isNaN(speed) ? '' : `  ${speed.toFixed(2)}×`}`;
    },
    words: (frame) => (isMissing(times[frame]) ? 'no action' : `action at ${times[frame].toFixed(2)} seconds`),
    level: (frame) => times[frame] / top,
  };
}

/** @param {number | undefined} value */
function isMissing(value) {
  return value === undefined || Number.isNaN(value);
}

/**
 * @param {Box} box
 * @param {number} frame
 * @param {string} text
 * @param {boolean} isStart the flag hangs to the right of a start and to the left of an end
 */
function flag(box, frame, text, isStart) {
  const { context, theme, top, height } = box;
  const x = Math.round(box.x(frame)) + 0.5;
  context.fillStyle = context.strokeStyle = theme.text;
  context.beginPath();
  context.moveTo(x, top + height);
  context.lineTo(x, top);
  context.stroke();
  context.beginPath();
  context.moveTo(x, top);
  context.lineTo(x + (isStart ? 6 : -6), top + 3.5);
  context.lineTo(x, top + 7);
  context.fill();
  context.textAlign = isStart ? 'left' : 'right';
  note(box, text, x + (isStart ? 9 : -9), top + 8, theme.text);
  context.textAlign = 'left';
}

/**
 * @param {Float32Array} values metres
 * @param {Float32Array} times seconds into the action
 * @returns {Row}
 */
function mismatchRow(values, times) {
  const { top } = axis(100 * largest(values), 5);
  return {
    label: 'Mismatch',
    height: 28,
    paint(box) {
      dotted(box);
      const bad = box.top + box.height * (1 - (100 * BAD) / top);
      const heat = box.context.createLinearGradient(0, box.top + box.height, 0, bad);
      heat.addColorStop(0.5, box.theme.faint);
      heat.addColorStop(1, box.theme.warn);
      for (const part of pieces(values)) {
        const points = alongFrames(values, part, top / 100);
        area(box, points, heat, 0.25);
        line(box, points, heat, 1.5);
      }
      level(box, `${top} cm`);
    },
    text(frame) {
      if (frame >= values.length) return '';
      return isMissing(values[frame]) && !isMissing(times[frame]) ? 'seam' : distance(values[frame]);
    },
    words: (frame) => (isMissing(values[frame]) ? '' : `leg mismatch ${centimetres(values[frame])}`),
    level: (frame) => (100 * values[frame]) / top,
  };
}

/**
 * @param {Float32Array} values metres
 * @param {string} label
 * @param {string} [colour]
 * @returns {Row}
 */
function differenceRow(values, label, colour) {
  const { top } = axis(100 * largest(values), 2);
  return {
    label,
    height: 28,
    paint(box) {
      dotted(box);
      for (const part of pieces(values)) {
        const points = alongFrames(values, part, top / 100);
        area(box, points, colour ?? box.theme.accent, 0.14);
        line(box, points, colour ?? box.theme.accent, 1.5);
      }
      level(box, `${top} cm`);
    },
    text: (frame) => distance(values[frame]),
    words: (frame) => (isMissing(values[frame]) ? '' : `${label} ${centimetres(values[frame])}`),
    level: (frame) => (100 * values[frame]) / top,
  };
}

/** @param {number | undefined} metres */
function distance(metres) {
  return metres === undefined || isMissing(metres) ? 'none' : centimetres(metres);
}
