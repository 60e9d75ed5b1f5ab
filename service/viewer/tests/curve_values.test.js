// Curves of a joint, with motions whose angles and speeds are known.
import assert from 'node:assert/strict';
import test from 'node:test';
import { jointCurves } from '../page/timeline/curve_values.js';
import { motionOf, turnY } from './motions.js';

const RATE = 50;

test('a joint that turns evenly has a straight angle, and its speed', () => {
  const motion = motionOf(RATE, 40, (frame) => ({ root: [0, 1, 0], turns: { left_knee: turnY((frame * Math.PI) / 100) } }));
  const { angle, turning } = jointCurves(motion, 'left_knee');
  angle.forEach((degrees, frame) => assert.ok(Math.abs(degrees - 1.8 * frame) < 1e-3, `${degrees} at ${frame}`));
  turning.forEach((degrees) => assert.ok(Math.abs(degrees - 1.8 * RATE) < 1e-2, `${degrees}`));
});

test('the angle is the shorter way, whatever the sign of the quaternion', () => {
  const turn = turnY((350 * Math.PI) / 180);
  const poseOf = (frame) => ({ root: [0, 1, 0], turns: { left_knee: frame === 1 ? turn.map((x) => -x) : turn } });
  const motion = motionOf(RATE, 3, poseOf);
  const { angle, turning } = jointCurves(motion, 'left_knee');
  angle.forEach((degrees) => assert.ok(Math.abs(degrees - 10) < 1e-3, `${degrees}`));
  turning.forEach((degrees) => assert.ok(degrees < 1e-2, `${degrees}`));
});

test('a tiny angle is not rounded to nothing', () => {
  const { angle } = jointCurves(motionOf(RATE, 2, () => ({ root: [0, 0, 0], turns: { left_knee: turnY(1e-5) } })), 'left_knee');
  assert.ok(Math.abs(angle[0] - (1e-5 * 180) / Math.PI) < 1e-8);
});

test('world speed is that of the joint, with what its parents do', () => {
  const motion = motionOf(RATE, 30, (frame) => ({ root: [0, 1, (2 * frame) / RATE], turns: {} }));
  for (const name of ['root', 'left_knee']) {
    jointCurves(motion, name).speed.forEach((speed) => assert.ok(Math.abs(speed - 2) < 1e-3, `${speed}`));
  }
  const spun = motionOf(RATE, 30, (frame) => ({ root: [0, 1, 0], turns: { root: turnY((3 * frame) / RATE) } }));
  const around = jointCurves(spun, 'left_knee').speed; // 0.1 m from the axis
  around.forEach((speed) => assert.ok(Math.abs(speed - 0.3) < 1e-2, `${speed}`));
});

test('one frame has no speed, and a rig without the joint has no curves', () => {
  const motion = motionOf(RATE, 1, () => ({ root: [0, 1, 0], turns: {} }));
  assert.deepEqual([...jointCurves(motion, 'root').speed], [0]);
  assert.deepEqual([...jointCurves(motion, 'root').turning], [0]);
  assert.equal(jointCurves(motion, 'tail'), undefined);
});
