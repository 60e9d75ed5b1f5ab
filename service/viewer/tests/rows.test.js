import assert from 'node:assert/strict';
import test from 'node:test';
import { rowsOf } from '../page/timeline/rows.js';

const data = { duration: 0.1, rate: 30, phases: new Float32Array(3), actionTimes: new Float32Array(3), actionDuration: 1, contacts: { left: [], right: [] }, events: [] };
const labels = (/** @type {object} */ more) => rowsOf(/** @type {any} */ ({ ...data, ...more })).map(({ label }) => label);

test('an action has a strip of mismatches, unless it was captured standing', () => {
  assert.deepEqual(labels({}), ['Phase', 'Left foot', 'Right foot', 'Action', 'Mismatch']);
  assert.deepEqual(labels({ stands: true }), ['Phase', 'Left foot', 'Right foot', 'Action']);
});
