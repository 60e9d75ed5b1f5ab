import assert from 'node:assert/strict';
import test from 'node:test';
import { Bones } from '../page/crowd/bones.js';
import { member, placeOf, repertoireOf, widthOf } from '../page/crowd/cast.js';
import { CoarseShape } from '../page/crowd/coarse.js';
import { Load } from '../page/crowd/load.js';
import { Anatomy } from '../page/scene/anatomy.js';
import { mannequin } from '../page/scene/mannequin.js';
import { RIGS } from './rigs.js';

const CLIPS = /** @type {any[]} */ ([
  { name: 'walk', kind: 'locomotion', duration: 6 }, { name: 'run', kind: 'locomotion', duration: 2 }, { name: 'wave', kind: 'action', duration: 4 },
]);

test('a link shows the same crowd, whatever the order of the clips', () => {
  const found = Array.from({ length: 50 }, (_, number) => member(number, repertoireOf(CLIPS)));
  assert.deepEqual(Array.from({ length: 50 }, (_, number) => member(number, repertoireOf([...CLIPS].reverse()))), found);
  assert.deepEqual(new Set(found.map(({ locomotion }) => locomotion)), new Set(['walk', 'run']));
  for (const { locomotion, time } of found) assert.ok(time >= 0 && time < (locomotion === 'walk' ? 6 : 2));
  assert.equal(member(0, repertoireOf(CLIPS.slice(0, 2))).action, undefined);
});

test('nobody stands on another, and all stand within the width', () => {
  for (const count of [1, 10, 100, 1000]) {
    const places = Array.from({ length: count }, (_, number) => placeOf(number, count));
    for (const [index, [x, z]] of places.entries()) {
      assert.ok(Math.max(Math.abs(x), Math.abs(z)) < widthOf(count) / 2 + 0.5);
      for (const [u, v] of places.slice(index + 1)) assert.ok(Math.hypot(x - u, z - v) > 0.7);
    }
  }
});

test('matrices take the joints to where the client puts them, turned and moved', () => {
  const rig = Object.values(RIGS)[0];
  const { places } = new Anatomy(rig);
  const joints = rig.joints.length;
  const rotations = Float32Array.from({ length: joints }, (_, joint) => joint).reduce((out, joint) => {
    const turn = [0.3 * Math.sin(joint), 0.2 * Math.cos(joint), 0.1 * joint / joints, 1];
    const length = Math.hypot(...turn);
    return turn.forEach((value, at) => { out[4 * joint + at] = value / length; }), out;
  }, new Float32Array(4 * joints));
  const root = Float32Array.from([0.1, 0.95, -0.2]);
  const [heading, x, z] = [0.7, 3, -2];
  const expected = new Float32Array(3 * joints), out = new Float32Array(12 * (joints + 1));
  rig.worldPositions(root, rotations, expected);
  new Bones(rig, places).write(/** @type {any} */ ({ root, rotations }), heading, x, z, out, 12);
  for (let joint = 0; joint < joints; joint++) {
    const row = (/** @type {number} */ at) => out.subarray(12 * (joint + 1) + 4 * at, 12 * (joint + 1) + 4 * at + 4);
    const found = [0, 1, 2].map((at) => row(at)[0] * places[joint][0] + row(at)[1] * places[joint][1] + row(at)[2] * places[joint][2] + row(at)[3]);
    const [a, b, c] = expected.subarray(3 * joint, 3 * joint + 3);
    const turned = [x + Math.cos(heading) * a + Math.sin(heading) * c, b, z + Math.cos(heading) * c - Math.sin(heading) * a];
    turned.forEach((value, at) => assert.ok(Math.abs(value - found[at]) < 1e-5));
  }
});

test('a body of a crowd has fewer triangles, and as many for each side', () => {
  const anatomy = new Anatomy(Object.values(RIGS)[0]);
  const [fine, coarse] = [mannequin(anatomy), mannequin(anatomy, new CoarseShape(3))];
  assert.ok(coarse.indices.length < fine.indices.length / 5);
  assert.ok(Math.max(...coarse.indices) < coarse.shades.length);
});

test('figures are of the last two seconds', () => {
  const load = new Load();
  load.begin(0);
  for (let now = 0; now < 10_000; now += 20) load.picture(now, now < 8500 ? 50 : 1 + (now % 100) / 100);
  for (let now = 0; now < 10_000; now += 10) load.message(now, 500);
  const { pictures, frames, kilobytes, worst } = load.at(10_000);
  assert.ok(Math.abs(pictures - 50) < 1 && Math.abs(frames - 100) < 1 && Math.abs(kilobytes - 50) < 1);
  assert.equal(worst, 50);
  assert.ok(load.at(11_000).worst < 2);
});
