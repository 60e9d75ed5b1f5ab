import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Frames, Motion } from '../page/vendor/motionsplice.js';
import { Anatomy } from '../page/scene/anatomy.js';
import { heightsOverSole } from '../page/scene/foot.js';
import { floorOf, groundOf, stancesOf } from '../page/scene/stances.js';
import { RIGS } from './rigs.js';

const rig = RIGS.standing;
const RATE = 10;

/** A body that stands still, turned, and is lifted by so much in each frame. @param {number[]} heights @param {number} turn */
function lifted(heights, turn = 0) {
  const ankle = new Anatomy(rig).places[rig.joints.indexOf('LeftFoot')];
  const hips = heightsOverSole(new Anatomy(rig), 'left').ankle - ankle[1];
  const bytes = (/** @type {number[]} */ values) => new Uint8Array(Float32Array.from(values).buffer);
  const pose = rig.joints.flatMap((_, joint) => (joint ? [0, 0, 0, 1] : [0, Math.sin(turn / 2), 0, Math.cos(turn / 2)]));
  const message = {
    bank: rig.bank, frame: 0, count: heights.length, rate: RATE,
    root_positions: bytes(heights.flatMap((height) => [0, hips + height, 0])), rotations: bytes(heights.flatMap(() => pose)),
  };
  return new Motion(rig, RATE).add(new Frames(message, rig, 'float32'));
}

test('marks are at the height of the steps, in the order of time, and point as the feet do', () => {
  const motion = lifted([0, 0, 0, 0.17, 0.17, 0.17, 0.34, 0.34], 0.5);
  const stances = stancesOf(motion, { left: [[0, 0.2], [0.6, 0.7]], right: [[0.3, 0.5]] });
  assert.deepEqual(stances.map(({ half }) => half), ['left', 'right', 'left']);
  stances.forEach(({ at, heading }, step) => {
    assert.ok(Math.abs(at[1] - 0.17 * step) < 1e-5);
    assert.ok(Math.abs(heading - 0.5) < 1e-5);
  });
  const ground = groundOf(stances, 8, RATE);
  assert.ok(Math.abs(ground[0]) < 1e-5 && Math.abs(ground[7] - 0.34) < 1e-5);
  assert.ok(ground.every((height, frame) => !frame || height >= ground[frame - 1]));
});

test('the floor is the lowest ground, or 0 under stairs', () => {
  const at = (/** @type {number} */ height) => ({ half: /** @type {const} */ ('left'), from: 0, to: 1, heading: 0, at: /** @type {[number, number, number]} */ ([0, height, 0]) });
  assert.equal(floorOf([]), 0);
  assert.equal(floorOf([at(-0.06), at(-0.05)]), -0.06);
  assert.equal(floorOf([at(0), at(-1.7)]), -1.7);
  assert.equal(floorOf([at(0.34), at(0.51)]), 0);
});

test('a stance without frames, and ones beyond the motion, are left out', () => {
  assert.equal(stancesOf(lifted([0, 0]), { left: [[0.02, 0.08], [5, 6]], right: [] }).length, 0);
});
