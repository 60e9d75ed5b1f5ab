import assert from 'node:assert/strict';
import test from 'node:test';
import { BINDINGS } from '../page/panels/keys.js';
import { DEFAULTS } from '../page/state.js';

test('no key is bound twice', () => {
  const keys = BINDINGS.flatMap((one) => one.keys);
  assert.deepEqual(keys, [...new Set(keys)]);
});

test('keys change only values that the state has', () => {
  /** @type {string[]} */
  const changed = [];
  const state = { values: { ...DEFAULTS }, set: (/** @type {object} */ values) => changed.push(...Object.keys(values)) };
  const player = { range: [0, 1], time: 0.5, seek() {}, step() {}, toggle() {} };
  const parts = { state, player, lists: { step() {}, find() {} }, takeAway: { savePicture() {}, copyLink() {} }, help: { toggle() {} }, own: {} };
  for (const { run, keys } of BINDINGS) for (const key of keys) run?.(/** @type {any} */ (parts), key);
  assert.deepEqual(changed.filter((key) => !(key in DEFAULTS)), []);
  assert.ok(changed.includes('view') && changed.includes('show'));
});
