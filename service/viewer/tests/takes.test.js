import assert from 'node:assert/strict';
import test from 'node:test';
import { DEFAULTS } from '../page/state.js';
import { secondsOf, takeOf } from '../page/takes.js';

/** @import { Catalogue } from '../page/catalogue.js' */

const clips = new Map([['cycle', 1.3, 1], ['stop', 1.3, 0], ['march', 12, 4], ['arms', 8.6, 0]].map(
  ([name, duration, loop]) => [name, { name, duration, loop, rate: 30 }]));
const catalogue = /** @type {Catalogue} */ (/** @type {unknown} */ ({ clips }));
const of = (values) => ({ ...DEFAULTS, locomotion: 'cycle', action: 'arms', ...values });

test('a locomotion that loops repeats until the action ends', () => {
  assert.equal(secondsOf(of({}), catalogue), 8.6);
  assert.equal(secondsOf(of({ at: 2, start: 1 }), catalogue), 9.6);
  const take = takeOf('splice', of({}), catalogue);
  assert.deepEqual([take.frames, take.commands[0].loop], [259, true]);
});

test('else the take is as long as the locomotion, which does not repeat', () => {
  for (const [values, seconds] of [[{ locomotion: 'march' }, 12], [{ locomotion: 'stop' }, 1.3], [{ second: 'stop' }, 1.3], [{ action: '' }, 1.3]]) {
    assert.equal(secondsOf(of(values), catalogue), seconds);
    assert.equal(takeOf('splice', of(values), catalogue).commands[0].loop, false);
  }
});

test('a truth, which does not repeat, is not held longer than the locomotion', () => {
  assert.equal(secondsOf(of({ truth: 'march' }), catalogue), 1.3);
});

test('a length that is asked for holds', () => {
  assert.equal(secondsOf(of({ length: 3 }), catalogue), 3);
});
