import assert from 'node:assert/strict';
import { test } from 'node:test';
import { COLUMNS, filtered, grade, linkTo, meanOf, sorted } from '../page/report/pairs.js';

const NOTHING = { error: null, worst_error: null, ratio: null, posture: null, lag: null, jitter: null, mismatch: null };

/** @param {string} locomotion @param {string} action @param {number | null} ratio @returns {import('../page/report/pairs.js').Pair} */
const pair = (locomotion, action, ratio, truth = '') => ({
  locomotion, action, truth, example: '', oracle: null, floor: null, measure: ratio === null ? 'legs' : 'error',
  methods: [{ ...NOTHING, method: 'naive', error: 4 }, { ...NOTHING, method: 'splice', ratio }], over_time: { splice: [1, 2] }, worst: { time: 1 / 30, value: 2 },
});
const PAIRS = [pair('walk', 'wave', 0.3), pair('run', 'wave', null), pair('clip_10', 'push', 0.8), pair('clip_9', 'push', 0.5)];
const names = (/** @type {import('../page/report/pairs.js').Pair[]} */ pairs) => pairs.map(({ locomotion }) => locomotion);

test('pairs are sorted by a number, those without it last', () => {
  assert.deepEqual(names(sorted(PAIRS, 'ratio', true)), ['clip_10', 'clip_9', 'walk', 'run']);
  assert.deepEqual(names(sorted(PAIRS, 'ratio', false)), ['walk', 'clip_9', 'clip_10', 'run']);
});

test('names are sorted as people count', () => {
  assert.deepEqual(names(sorted(PAIRS, 'locomotion', false)), ['clip_9', 'clip_10', 'run', 'walk']);
  assert.deepEqual(names(sorted(PAIRS, 'action', false)), ['clip_9', 'clip_10', 'run', 'walk']);
});

test('a filter finds all its words', () => {
  assert.deepEqual(names(filtered(PAIRS, ' WAVE run')), ['run']);
  assert.equal(filtered(PAIRS, '').length, 4);
});

test('means leave out what is unknown', () => {
  assert.ok(Math.abs((meanOf(PAIRS, 'ratio') ?? 0) - 1.6 / 3) < 1e-12);
  assert.equal(meanOf(PAIRS, 'floor'), undefined);
});

test('a value is graded by its bounds', () => {
  const ratio = COLUMNS.find(({ key }) => key === 'ratio');
  assert.ok(ratio);
  assert.deepEqual([0.4, 0.6, 0.8].map((value) => grade(ratio, value)), ['good', 'fair', 'bad']);
});

test('a link opens the worst moment, beside the truth if the bank has it', () => {
  const clips = new Set(['walk', 'wave', 'truth & <b>']);
  const query = (/** @type {string} */ truth) => Object.fromEntries(new URL(linkTo(pair('walk', 'wave', 0.3, truth), clips) ?? '', 'http://x/view/').searchParams);
  assert.deepEqual(query('truth & <b>'), {
    locomotion: 'walk', action: 'wave', truth: 'truth & <b>', show: 'splice,naive,truth', against: 'truth', time: '0.0333', playing: 'false',
  });
  assert.deepEqual(query('walk+wave'), { locomotion: 'walk', action: 'wave', against: 'naive', time: '0.0333', playing: 'false' });
  assert.equal(linkTo(pair('run', 'wave', 0.3), clips), undefined);
  assert.match(linkTo(pair('walk', 'wave', null), clips, 2) ?? '', /^\.\/\?locomotion=walk&action=wave&time=2&playing=false$/);
});
