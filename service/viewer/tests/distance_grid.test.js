// The distance grid, against a slow twin that searches over turns, and the distance of aligned moments.
import assert from 'node:assert/strict';
import test from 'node:test';
import { alignedDistances, cloudDistance, distanceGrid, legClouds } from '../page/timeline/distance_grid.js';
import { motionOf, turnY } from './motions.js';

const RATE = 30;

/** Legs that swing, lean and go up, so that no two frames are alike. */
function swinging(count, { phase = 0, heading = 0, shift = [0, 0, 0], lean = 0.1 } = {}) {
  return motionOf(RATE, count, (frame) => {
    const at = phase + frame / 7;
    const [half, spin] = [lean * Math.sin(at), turnY(heading)];
    const tilt = [Math.sin(half), 0, 0, Math.cos(half)]; // about X, then turned about Y
    const [, y, , w] = spin;
    const turn = [w * tilt[0], y * tilt[3], -y * tilt[0], w * tilt[3]];
    return { root: [shift[0] + at / 5, 1 + shift[1] + 0.02 * Math.sin(2 * at), shift[2]], turns: { root: turn } };
  });
}

/** Least root mean square over turns, by search; the best shift lays mean on mean. */
function slowDistance(a, i, b, j) {
  const sumAt = (turn) => [0, 1, 2].reduce((sum, point) => {
    const [bx, bz] = [b[j + point], b[j + 3 + point]];
    const [x, z] = [Math.cos(turn) * bx + Math.sin(turn) * bz, Math.cos(turn) * bz - Math.sin(turn) * bx];
    return sum + (a[i + point] - x) ** 2 + (a[i + 3 + point] - z) ** 2 + (a[i + 6 + point] - b[j + 6 + point]) ** 2;
  }, 0);
  let [best, step] = [0, Math.PI / 90];
  for (let turn = -Math.PI; turn < Math.PI; turn += step) if (sumAt(turn) < sumAt(best)) best = turn;
  for (; step > 1e-9; step /= 2) for (const turn of [best - step, best + step]) if (sumAt(turn) < sumAt(best)) best = turn;
  return Math.sqrt(sumAt(best) / 3);
}

test('the closed form is the least over all turns', () => {
  const [a, b] = [legClouds(swinging(20)), legClouds(swinging(17, { phase: 1.3, heading: 2, lean: 0.4 }))];
  const { columns, rows, values } = distanceGrid(a, b);
  assert.deepEqual([columns, rows], [20, 17]);
  for (let row = 0; row < rows; row += 4) {
    for (let column = 0; column < columns; column += 3) {
      const slow = slowDistance(a.values, 9 * column, b.values, 9 * row);
      assert.ok(Math.abs(values[row * columns + column] - slow) < 1e-4, `${values[row * columns + column]} for ${slow}`);
    }
  }
});

test('turned, shifted and lifted legs are at no distance', () => {
  const [a, b] = [legClouds(swinging(20)), legClouds(swinging(20, { heading: 1, shift: [3, 0.7, -2] }))];
  for (let frame = 0; frame < 20; frame++) assert.ok(cloudDistance(a.values, 9 * frame, b.values, 9 * frame) < 1e-3);
});

test('many frames are thinned evenly, from the first to the last', () => {
  const [a, b] = [legClouds(swinging(900)), legClouds(swinging(301, { lean: 0.3 }))];
  const { columns, rows, values } = distanceGrid(a, b);
  assert.deepEqual([columns, rows], [200, 200]);
  assert.equal(values[0], Math.fround(cloudDistance(a.values, 0, b.values, 0)));
  assert.equal(values.at(-1), Math.fround(cloudDistance(a.values, 9 * 899, b.values, 9 * 300)));
});

test('distances of aligned moments are between frames, and missing without an action or in its seam', () => {
  const [a, b] = [legClouds(swinging(5)), legClouds(swinging(60, { phase: 0.5 / 7 }))];
  const times = [NaN, 0.5 / RATE, 1.5 / RATE, 2.5 / RATE, 2.2]; // the action is half a frame behind
  const distances = alignedDistances(a, b, times);
  assert.equal(distances.length, 5);
  assert.deepEqual([...distances].map(Number.isNaN), [true, false, false, false, true]);
  [0.5, 1.5, 2.5].forEach((place, at) => {
    const slow = slowDistance(a.values, 9 * (at + 1), between(b, place), 0);
    assert.ok(Math.abs(distances[at + 1] - slow) < 1e-4, `${distances[at + 1]} for ${slow}`);
  });
  assert.ok(alignedDistances(a, a, [0, 1, 2, 3, 4].map((frame) => frame / RATE)).every((metres) => metres < 1e-3));
});

/** Returns the cloud halfway between two frames. */
function between({ values }, place) {
  const before = Math.floor(place);
  return Float32Array.from({ length: 9 }, (_, at) => (values[9 * before + at] + values[9 * (before + 1) + at]) / 2);
}
