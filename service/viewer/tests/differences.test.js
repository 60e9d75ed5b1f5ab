import assert from 'node:assert/strict';
import { test } from 'node:test';
import { COLOURS, distances, heading, mean, shares, upperBody, worst } from '../page/scene/differences.js';
import { smooth } from '../page/scene/path.js';
import { RIGS } from './rigs.js';

const rig = RIGS.standing;
const still = rig.joints.flatMap(() => [0, 0, 0, 1]);
const positions = (/** @type {number[]} */ root, turn = 0) => {
  const rotations = [...still];
  rotations.splice(0, 4, 0, Math.sin(turn / 2), 0, Math.cos(turn / 2));
  const out = new Float32Array(3 * rig.joints.length);
  rig.worldPositions(root, rotations, out);
  return out;
};

test('the distance of each joint is in metres', () => {
  const a = positions([0, 1, 0]), b = positions([0, 1, 0]);
  const hand = rig.joints.indexOf('LeftHand');
  b[3 * hand] += 0.03;
  b[3 * hand + 1] -= 0.04;
  const found = distances(a, b, rig);
  assert.ok(Math.abs(found[hand] - 0.05) < 1e-6);
  assert.deepEqual(worst(found, upperBody(rig)), { joint: hand, metres: found[hand] });
  assert.ok(Math.abs(mean(found, [hand, 0]) - 0.025) < 1e-6);
  assert.ok(Math.abs(shares(found)[hand] - 0.25) < 1e-6);
});

test('measured from the root, place and heading do not count', () => {
  const a = positions([0, 1, 0], 0.3), b = positions([2, 1.2, -3], -1.1);
  assert.ok(Math.max(...distances(a, b, rig, 'root')) < 1e-5);
  assert.ok(Math.min(...distances(a, b, rig, 'world')) > 1);
});

test('a heading is the turn about Y', () => {
  for (const turn of [-3, -1, 0, 0.5, 2]) assert.ok(Math.abs(heading(positions([1, 1, 1], turn), rig) - turn) < 1e-5);
});

test('the upper body has no legs and no hips', () => {
  const names = upperBody(rig).map((joint) => rig.joints[joint]);
  assert.ok(!names.some((name) => /Hips|Leg|Foot|Toe/.test(name)));
  assert.equal(names.length, 10);
});

test('colours darken all the way', () => {
  let before = Infinity;
  for (let row = 0; row < 256; row += 5) {
    const brightness = 0.2126 * COLOURS[3 * row] + 0.7152 * COLOURS[3 * row + 1] + 0.0722 * COLOURS[3 * row + 2];
    assert.ok(brightness < before, `row ${row}`);
    before = brightness;
  }
});

test('a straight path stays as it is, up to its ends', () => {
  const line = Float64Array.from({ length: 90 }, (_, frame) => 0.02 * frame - 1);
  smooth(line, 20).forEach((value, frame) => assert.ok(Math.abs(value - line[frame]) < 1e-9));
  assert.deepEqual([...smooth(Float64Array.of(3), 20)], [3]);
});

test('sway of a stride is levelled out', () => {
  const sway = Float64Array.from({ length: 300 }, (_, frame) => 0.03 * Math.sin((2 * Math.PI * frame) / 60));
  assert.ok(Math.max(...[...smooth(sway, 21)].slice(60, 240).map(Math.abs)) < 0.005);
});
