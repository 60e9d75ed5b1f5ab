import assert from 'node:assert/strict';
import test from 'node:test';
import { summary } from '../page/panels/listing.js';

const clip = { name: 'one', warnings: ['odd'], duration: 2, rate: 30, cycles: 1.5, mean_mismatch: 0.06, worst_mismatch: 0.2, loop: 1, stands: false, uses: [] };

test('a clip with a gait has strides, a mismatch and a loop', () => {
  const lines = summary(/** @type {any} */ (clip));
  assert.deepEqual(lines.slice(0, 3), ['one', '⚠ odd', '2.00 s at 30 frames/s, 1.5 strides']);
  assert.match(lines[3], /^Legs differ from the baseline's by 6/);
  assert.equal(lines[4], 'Repeats by 1 stride');
});

test('an action captured standing has none of them, and says what it uses', () => {
  const lines = summary(/** @type {any} */ ({ ...clip, stands: true, uses: ['right_arm', 'head'] }));
  assert.deepEqual(lines, ['one', '⚠ odd', '2.00 s at 30 frames/s', 'Captured standing: plays at its own speed', 'Uses right arm, head']);
});
