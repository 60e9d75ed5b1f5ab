import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Anatomy } from '../page/scene/anatomy.js';
import { heightsOverSole } from '../page/scene/foot.js';
import { mannequin } from '../page/scene/mannequin.js';
import { stick } from '../page/scene/stick.js';
import { dot } from '../page/scene/vectors.js';
import { RIGS } from './rigs.js';

for (const [name, rig] of Object.entries(RIGS)) {
  const anatomy = new Anatomy(rig);
  for (const [style, shape] of Object.entries({ mannequin: mannequin(anatomy), stick: stick(anatomy) })) {
    test(`${name}, ${style}: the surface is finite, and moved by joints`, () => {
      assert.ok(shape.positions.every(Number.isFinite));
      assert.ok(shape.positions.every((place) => Math.abs(place) < 2.5));
      const count = shape.positions.length / 3;
      assert.ok(Math.max(...shape.indices) < count);
      for (let vertex = 0; vertex < count; vertex++) {
        const weights = shape.skinWeights.slice(4 * vertex, 4 * vertex + 4);
        assert.ok(Math.abs(weights.reduce((sum, weight) => sum + weight) - 1) < 1e-9 && weights.every((weight) => weight >= 0));
      }
      assert.ok([...shape.skinIndices, ...shape.colourJoints].every((joint) => joint >= 0 && joint < rig.joints.length));
    });
    test(`${name}, ${style}: triangles face outwards`, () => {
      const at = (/** @type {number} */ index) => shape.positions.slice(3 * index, 3 * index + 3);
      let volume = 0;
      for (let index = 0; index < shape.indices.length; index += 3) {
        const [a, b, c] = [0, 1, 2].map((corner) => at(shape.indices[index + corner]));
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
      }
      const [least, most] = style === 'stick' ? [0.0005, 0.02] : [0.05, 0.12]; // cubic metres: of a body of 50 to 120 kg
      assert.ok(volume > least && volume < most, `${volume}`);
    });
  }
}

test('feet point ahead, and their soles are as far down as the joints are high', () => {
  const anatomy = new Anatomy(RIGS.standing);
  const { forward, down, left } = anatomy.foot('left');
  assert.ok(forward[2] > 0.999 && down[1] < -0.999 && left[0] > 0.999);
  const { positions } = mannequin(anatomy);
  const lowest = Math.min(...positions.filter((_, index) => index % 3 === 1));
  const ankle = anatomy.places[anatomy.role('left_ankle')];
  assert.ok(Math.abs(ankle[1] - heightsOverSole(anatomy, 'left').ankle - lowest) < 0.004);
});

test('where the legs are bound upwards, the foot still points ahead of the body', () => {
  const { forward, reach } = new Anatomy(RIGS.alongX).foot('left');
  assert.ok(Math.abs(dot(forward, [0, 1, 0]) - 1) < 1e-9);
  assert.ok(Math.abs(reach - 0.148) < 1e-9);
});
