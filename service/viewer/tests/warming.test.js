import assert from 'node:assert/strict';
import test from 'node:test';
import { RefusedError } from '../page/vendor/motionsplice.js';
import { Warming } from '../page/warming.js';

const refusal = new RefusedError('not-ready', 'the kernels are still being compiled');

/** Waits for a service with these answers of `/readyz`. Returns what was said and how it ended. */
async function waited(/** @type {unknown[]} */ ...answers) {
  /** @type {unknown[]} */
  const said = [];
  const service = { request: async () => { const answer = answers.shift(); if (answer) throw answer; } };
  const then = { say: (/** @type {string} */ text) => said.push(text), ready: () => said.push('ready'), failed: (/** @type {unknown} */ error) => said.push(error) };
  const warming = new Warming(/** @type {any} */ (service), then, 1);
  await Promise.all([warming.wait(refusal), warming.wait(refusal)]);
  return { said, left: answers.length };
}

test('it waits until the service is ready, and says for how long', async () => {
  const { said, left } = await waited(refusal, refusal, undefined);
  assert.equal(left, 0);
  assert.match(String(said[0]), /not ready: the kernels are still being compiled\. .* Waited 0 s so far\./);
  assert.deepEqual(said.slice(-1), ['ready']);
  assert.equal(said.filter((one) => one === 'ready').length, 1);
});

test('another failure ends the wait', async () => {
  const gone = new Error('gone');
  const { said } = await waited(refusal, gone);
  assert.equal(said.at(-1), gone);
});
