import { alongFrames, area, bars, dottedTop, line, note } from './paint.js';
import { clockPieces, isWithin, pace, pieces } from './pieces.js';
import { axis, largest, nice, plain } from './ticks.js';

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
 * @property {Float32Array} [differences] metres between two sides at each frame
 * @property {{ action?: string, difference?: string }} [colours]
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

const BAD = 0.1; // metres between legs from which a splice looks wrong

/**
 * Returns the strips, from above.
 *
 * @param {TimelineData} data
 * @returns {Row[]}
 */
export function rowsOf(data) {
  const { actionTimes, mismatches, differences } = data;
  const rows = [phaseRow(data), contactRow(data, 'left'), contactRow(data, 'right')];
  if (actionTimes) rows.push(actionRow(data, actionTimes));
  if (mismatches) rows.push(mismatchRow(mismatches));
  if (differences) rows.push(differenceRow(differences, data.colours?.difference));
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
        const [start, stride] = [box.x(ramp[0][0]), Math.floor(phases[Math.round(ramp[0][0] + 0.5)])];
        if (box.x(ramp[ramp.length - 1][0]) - start > 28) note(box, String(stride), start + 4, box.top + 9);
      }
    },
    text: (frame) => phases[frame]?.toFixed(2) ?? '',
    words: (frame) => `phase ${phases[frame]?.toFixed(2)} strides`,
    level: fraction,
  };
}

/**
 * Returns the phase as ramps from 0 to 1, one a stride: places in frames, and levels.
 *
 * @param {ArrayLike<number>} phases
 */
export function ramps(phases) {
  /** @type {[number, number][][]} */
  const found = [];
  for (let frame = 0; frame < phases.length; frame++) {
    const phase = phases[frame], before = phases[frame - 1];
    const stride = Math.floor(phase);
    const isNext = frame > 0 && stride === Math.floor(before) + 1;
    const crossing = isNext ? frame - (phase - stride) / (phase - before) : frame;
    if (isNext) found[found.length - 1].push([crossing, 1]);
    if (frame === 0 || stride !== Math.floor(before)) found.push(isNext ? [[crossing, 0]] : []);
    found[found.length - 1].push([frame, phase - stride]);
  }
  return found;
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
function actionRow({ rate, actionDuration = 0, events, colours }, times) {
  const top = Math.max(actionDuration, largest(times)) || 1;
  const parts = clockPieces(times, rate);
  return {
    label: 'Action',
    height: 38,
    paint(box) {
      const colour = colours?.action ?? box.theme.accent;
      dottedTop(box, `${plain(top, nice(top / 10))} s`);
      for (const part of parts) {
        const points = alongFrames(times, part, top);
        area(box, points, colour, 0.14);
        line(box, points, colour, 1.5);
      }
      for (const mark of events.filter(({ event }) => event.startsWith('action'))) {
        const isStart = mark.event === 'action_began';
        flag(box, mark.frame, `${mark.action ?? 'action'} ${isStart ? 'begins' : 'ends'}`, isStart);
      }
    },
    text(frame) {
      const speed = pace(times, rate, frame);
      return Number.isNaN(times[frame] ?? NaN) ? 'none' : `${times[frame].toFixed(2)} s${Number.isNaN(speed) ? '' : `  ${speed.toFixed(2)}×`}`;
    },
    words: (frame) => (Number.isNaN(times[frame] ?? NaN) ? 'no action' : `action at ${times[frame].toFixed(2)} seconds`),
    level: (frame) => times[frame] / top,
  };
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
 * @returns {Row}
 */
function mismatchRow(values) {
  const { top } = axis(100 * largest(values), 5);
  return {
    label: 'Legs apart',
    height: 28,
    paint(box) {
      dottedTop(box, `${top} cm`);
      const bad = box.top + box.height * (1 - (100 * BAD) / top);
      const heat = box.context.createLinearGradient(0, box.top + box.height, 0, bad);
      heat.addColorStop(0, box.theme.faint);
      heat.addColorStop(0.4, box.theme.faint);
      heat.addColorStop(1, box.theme.warn);
      for (const part of pieces(values)) {
        const points = alongFrames(values, part, top / 100);
        area(box, points, heat, 0.45);
        line(box, points, heat, 1.5);
      }
    },
    text: (frame) => centimetres(values[frame]),
    words: (frame) => (centimetres(values[frame]) === 'none' ? '' : `legs ${centimetres(values[frame])} apart`),
    level: (frame) => (100 * values[frame]) / top,
  };
}

/**
 * @param {Float32Array} values metres
 * @param {string} [colour]
 * @returns {Row}
 */
function differenceRow(values, colour) {
  const { top } = axis(100 * largest(values), 2);
  return {
    label: 'Difference',
    height: 28,
    paint(box) {
      dottedTop(box, `${top} cm`);
      for (const part of pieces(values)) {
        const points = alongFrames(values, part, top / 100);
        area(box, points, colour ?? box.theme.accent, 0.14);
        line(box, points, colour ?? box.theme.accent, 1.5);
      }
    },
    text: (frame) => centimetres(values[frame]),
    words: (frame) => (centimetres(values[frame]) === 'none' ? '' : `difference ${centimetres(values[frame])}`),
    level: (frame) => (100 * values[frame]) / top,
  };
}

/** @param {number | undefined} metres */
function centimetres(metres) {
  return metres === undefined || Number.isNaN(metres) ? 'none' : `${(100 * metres).toFixed(1)} cm`;
}
