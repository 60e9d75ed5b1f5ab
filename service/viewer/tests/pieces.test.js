// Curves with gaps and jumps, ranges, ticks, and what is typed as a time.
import assert from 'node:assert/strict';
import test from 'node:test';
import { parseMoment } from '../page/timeline/moment.js';
import { clockPieces, isWithin, pace, pieces, ramps, rangeOf } from '../page/timeline/pieces.js';
import { axis, largest, multiples, plain, readable, timeSteps } from '../page/timeline/ticks.js';

test('an action is cut where it is missing and where it loops', () => {
  const times = [NaN, NaN, 1, 1.1, 1.2, 0.3, 0.4, NaN, 2];
  assert.deepEqual(clockPieces(times, 10), [[2, 4], [5, 6], [8, 8]]);
  assert.deepEqual(pieces(times), [[2, 6], [8, 8]]);
  assert.deepEqual(pieces([]), []);
  assert.deepEqual(pieces([1, 2]), [[0, 1]]);
});

test('the pace is that of the clock, and does not see its jumps', () => {
  const times = [NaN, 1, 1.2, 1.4, 0.5, 0.6, 0.7, NaN];
  const parts = clockPieces(times, 10);
  const paces = times.map((_, frame) => pace(parts, times, 10, frame));
  assert.deepEqual(paces.map((value) => Number(value.toFixed(6))), [NaN, 2, 2, 2, 1, 1, 1, NaN]);
});

test('phase ramps cross at whole strides, between frames', () => {
  const found = ramps([0.5, 0.9, 1.3, 1.7]);
  assert.equal(found.length, 2);
  assert.deepEqual(found[0].at(-1)[1], 1);
  assert.ok(Math.abs(found[0].at(-1)[0] - 1.25) < 1e-9);
  assert.deepEqual(found[1][0], [found[0].at(-1)[0], 0]);
});

test('a loop that goes back by whole strides does not break a ramp, and a cut does', () => {
  assert.equal(ramps([4.2, 4.3, 1.4, 1.5]).length, 1);
  assert.equal(ramps([4.2, 4.3, 1.9, 1.95]).length, 2);
  assert.equal(ramps([4.8, 4.95, 2.1]).length, 2);
});

test('a moment is within an interval with its ends', () => {
  assert.ok(isWithin([[1, 3]], 1) && isWithin([[1, 3]], 3) && !isWithin([[1, 3]], 3.1));
});

test('a range is of whole frames, in any order, and all of the motion is no range', () => {
  assert.deepEqual(rangeOf(2.04, 1.01, 6, 10), { from: 1, to: 2 });
  assert.deepEqual(rangeOf(-1, 9, 6, 10), { from: 0, to: 0 });
  assert.deepEqual(rangeOf(1, 6, 6, 10), { from: 1, to: 0 });
});

test('ticks have room, and are frames where frames have room', () => {
  assert.deepEqual(timeSteps(120, 60), { major: 1, minor: 0.1 });
  assert.deepEqual(timeSteps(1000, 60), { major: 0.1, minor: 1 / 60 });
  assert.deepEqual([...multiples(0.15, 0.41, 0.1)].map((time) => time.toFixed(1)), ['0.2', '0.3', '0.4']);
  assert.deepEqual([plain(0.30000001, 0.1), plain(2, 1), plain(50, 20), plain(0.5, 0.05)], ['0.3', '2', '50', '0.50']);
});

test('axes end little above the largest value', () => {
  assert.deepEqual(axis(12.4, 5), { top: 15, step: 5 });
  assert.deepEqual(axis(680, 50), { top: 800, step: 400 });
  assert.deepEqual(axis(0, 5), { top: 6, step: 2 });
  assert.deepEqual(axis(NaN, 1), { top: 1, step: 0.5 });
  assert.equal(largest([NaN, 2, 1]), 2);
});

test('a time is typed as seconds, minutes or frames', () => {
  const typed = { '1.5': 1.5, ' 1,5 s ': 1.5, '90f': 1.5, '1:02.5': 62.5, '.5': 0.5 };
  for (const [text, time] of Object.entries(typed)) assert.equal(parseMoment(text, 60), time, text);
  for (const text of ['-1', '1:2f', 'soon', '']) assert.equal(parseMoment(text, 60), undefined, text);
});

test('a few outliers do not set the scale of an axis, and real peaks do', () => {
  const even = Float32Array.from({ length: 200 }, (_, frame) => 50 + (frame % 50));
  assert.equal(readable([even, even]), 99);
  assert.ok(readable([even, Float32Array.from([9000])]) < 150);
  assert.equal(readable([Float32Array.from({ length: 100 }, (_, frame) => (frame > 80 ? 600 : 100))]), 600);
  assert.equal(readable([Float32Array.from([NaN])]), 0);
  assert.equal(readable([]), 0);
});
