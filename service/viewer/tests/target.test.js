import assert from 'node:assert/strict';
import test from 'node:test';
import { DEFAULTS } from '../page/state.js';
import { pointOf, takeOf } from '../page/takes.js';
import { alongAxis, onPlane, rayAt } from '../page/target/rays.js';
import { OrthographicCamera, PerspectiveCamera, Vector3 } from '../page/vendor/three.js';

const clip = { rate: 60, duration: 2 };
const catalogue = /** @type {any} */ ({ clips: new Map(['walk', 'wave'].map((name) => [name, { ...clip, name }])) });
const canvas = /** @type {any} */ ({ clientWidth: 400, clientHeight: 200 });

/** @param {import('../page/takes.js').SideName} side */
function commands(side, values = {}) {
  const all = { ...DEFAULTS, locomotion: 'walk', action: 'wave', lock_feet: true, look: true, chest: true, steady: true, right_arm: true, point: '1 2 -3', ...values };
  return takeOf(side, all, catalogue)?.commands.slice(1).filter((one) => one.do !== 'act');
}

test('splice and naive have the layers, what was captured has none', () => {
  const target = { at: 0, point: [1, 2, -3], blend: 0 };
  const layers = [
    { at: 0, do: 'lock_feet', lock_feet: true }, { ...target, do: 'look' }, { ...target, do: 'aim', part: 'chest', steady: 1 },
    { ...target, do: 'aim', part: 'right_arm' },
  ];
  for (const side of /** @type {const} */ (['splice', 'naive'])) assert.deepEqual(commands(side), layers);
  for (const side of /** @type {const} */ (['locomotion', 'action'])) assert.deepEqual(commands(side), []);
  assert.ok(commands('splice', { turned: 0.5 })?.slice(1).every(({ weight }) => weight === 0.5));
});

test('a point without a place turns nobody', () => {
  for (const point of ['', '1 2', '1 2 x', '1 2 3 4', 'NaN 0 0']) {
    assert.equal(pointOf(point), undefined);
    assert.equal(commands('splice', { point })?.length, 1);
  }
  assert.deepEqual(pointOf(' 1  -2.5 3e0 '), [1, -2.5, 3]);
});

for (const camera of [new PerspectiveCamera(40, 2, 0.1, 50), new OrthographicCamera(-4, 4, 2, -2, 0.1, 50)]) {
  const stage = { camera, canvas };
  camera.position.set(3, 2, 5);
  camera.lookAt(0, 1, 0);
  camera.updateMatrixWorld();
  const seen = (/** @type {Vector3} */ place) => {
    const { x, y } = place.clone().project(camera);
    return { offsetX: 200 * (x + 1), offsetY: 100 * (1 - y) };
  };

  test(`${camera.type}: a pointer shows the place that is drawn below it`, () => {
    const place = new Vector3(0.4, 1.3, -0.2), point = new Vector3(-0.5, 1, 0.3);
    for (const axis of /** @type {const} */ (['x', 'y', 'z'])) {
      const on = point.clone();
      on[axis] += 0.7;
      assert.ok(/** @type {Vector3} */ (alongAxis(rayAt(seen(on), stage), point, axis)).distanceTo(on) < 1e-3);
    }
    const normal = camera.getWorldDirection(new Vector3());
    assert.ok(/** @type {Vector3} */ (onPlane(rayAt(seen(place), stage), place, normal)).distanceTo(place) < 1e-3);
  });

  test(`${camera.type}: a line seen end-on and a plane edge-on or behind show no place`, () => {
    const along = new Vector3(0, 0, -1), ray = { from: new Vector3(), along };
    assert.equal(alongAxis(ray, new Vector3(1, 1, 1), 'z'), undefined);
    assert.equal(onPlane(ray, new Vector3(1, 1, 1), new Vector3(0, 1, 0)), undefined);
    assert.equal(onPlane(ray, new Vector3(0, 0, 1), along), undefined);
  });
}
