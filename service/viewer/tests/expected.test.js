import assert from 'node:assert/strict';
import test from 'node:test';
import { queryOf, wordsOf } from '../page/expected.js';
import { DEFAULTS } from '../page/state.js';

const chosen = { ...DEFAULTS, locomotion: 'walk', action: 'wave' };

test('the pair that is shown is asked for as it is shown', () => {
  const query = queryOf({ ...chosen, start: 0.5, hands: 'count', mirror: true, posture: 'off' });
  assert.equal(String(query), 'locomotion=walk&action=wave%7Emirror&start=0.5&posture=off&hands=count');
});

test('nothing is expected of a part, a mix, an own clock, or what is not shown', () => {
  for (const other of [{ weight: 0.5 }, { mask: 'arms' }, { second: 'run' }, { own: true }, { show: 'naive' }, { action: '' }]) {
    assert.equal(queryOf({ ...chosen, ...other }), undefined);
  }
});

test('errors are in whole centimetres, and a small gain is a warning', () => {
  assert.equal(wordsOf({ error: 0.031, replaced: 0.082, gains_little: false }), 'Expected error 3 cm, plain replacement 8 cm');
  assert.match(wordsOf({ error: 0.09, replaced: 0.1, gains_little: true }), /^Expected error 9 cm, plain replacement 10 cm: little is gained/);
  assert.equal(wordsOf({ error: 0.001, replaced: 0.002, gains_little: false }), 'Expected error under 1 cm, plain replacement under 1 cm');
  assert.equal(wordsOf(null), '');
});
