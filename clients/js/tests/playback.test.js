// "Between frames" of the protocol, with frames of one joint that go along x by 1 a second.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Frames, Pose, Rig } from '../motionsplice.js';
import { Character } from '../source/character.js';
import { Memory } from '../source/memory.js';
import { Playback } from '../source/playback.js';

const BOTH = { joints: ['hips'], parents: [-1], offsets: [[0, 0, 0]], roles: {} };
const [RIG, OTHER] = ['a', 'b'].map((bank) => new Rig({ ...BOTH, bank }, 'gltf'));
const bytes = (array) => new Uint8Array(array.buffer);

function message(frame, { count = 1, rate = 60, x = (number) => number / rate, rig = RIG, ids = [7], turn = 0, skew = 0 } = {}) {
  const rows = count * ids.length;
  const roots = Float32Array.from({ length: 3 * rows }, (_, at) => at % 3 ? 0 : x(frame + Math.floor(at / 3 / ids.length)));
  const rotations = Float32Array.from({ length: 4 * rows }, (_, at) => [0, Math.sin(turn / 2), 0, Math.cos(turn / 2)][at % 4]);
  return new Frames({
    bank: rig.bank, frame, count, rate, time: 1000 + frame / rate + skew, ids: bytes(Uint32Array.from(ids)),
    root_positions: bytes(roots), rotations: bytes(rotations),
    root_steps: bytes(new Float32Array(3 * rows)), root_turns: bytes(new Float32Array(rows)),
  }, rig, 'float32');
}

function played() {
  const playback = new Playback();
  const memory = new Memory({ do: 'create', locomotion: 'walk' }, 7, 0);
  const clock = { now: 0 };
  const hero = new Character(memory, () => playback.at(clock.now), async () => 0);
  const take = (frames, now) => {
    clock.now = now;
    playback.take(frames, now, () => memory.placed);
  };
  const x = (now) => {
    clock.now = now;
    return hero.pose()?.root[0];
  };
  const still = (moment, rate = 60) => { // at a moment of the service's, with the delay as it is
    playback.lateness = playback.delay - 1 / rate;
    return x(moment + playback.delay);
  };
  return { playback, memory, hero, take, x, still };
}

const near = (one, other, most = 1e-4) => assert.ok(Math.abs(one - other) <= most, `${one} is not ${other}`);

test('motion is even although messages are not', () => {
  const { take, x, playback } = played();
  const late = (number) => 0.004 * ((number * 7919) % 11) / 10; // up to 4 ms
  let seconds = 0, before = 0;
  for (let number = 0; number < 1200; number++) {
    const arrival = number / 60 + late(number);
    for (; seconds < arrival; seconds += 1 / 144) {
      const shown = x(seconds);
      if (seconds > 5) near(shown - before, 1 / 144, 0.06 / 144); // 5 % by the slewed delay, and float32
      before = shown ?? 0;
    }
    take(message(number), arrival);
  }
  near(playback.delay, 1 / 60 + 0.004, 1e-3);
  near(playback.offset, -1000, 1e-6);
});

test('with look-ahead as well, and what a command has changed is not shown', () => {
  const { take, still, playback } = played();
  for (let number = 0; number < 80; number += 8) take(message(number, { count: 8 }), number / 60);
  playback.discard(75);
  assert.equal(playback.held.at(-1).number, 74);
  take(message(75, { count: 8, x: () => 50 }), 72.5 / 60); // at once, before it is due
  near(still(74 / 60), 74 / 60);
  near(still(75 / 60 + 1e-3), 50);
  near(playback.offset, -1000, 1e-6);
});

test('nothing is extrapolated, and only short gaps are interpolated', () => {
  const { take, x, still } = played();
  take(message(0), 0);
  take(message(6), 0.1);
  near(still(0.05), 0.05);
  near(x(9), 0.1);
  const other = played();
  other.take(message(0), 0);
  other.take(message(30), 0.5);
  near(other.still(0.4), 0);
  near(other.still(0.6), 0.5);
  const slow = played(); // frames that follow each other, half a second apart
  slow.take(message(0, { rate: 2 }), 0);
  slow.take(message(1, { rate: 2 }), 0.5);
  near(slow.still(0.25, 2), 0.25);
});

test('a character jumps where it is placed, appears, and goes', () => {
  const { take, still, memory } = played();
  take(message(0, { ids: [9, 7] }), 0);
  memory.note({ do: 'place', position: [9, 0, 0] }, 1);
  take(message(1, { x: () => 9 }), 1 / 60);
  near(still(0.5 / 60), 0);
  near(still(1 / 60 + 1e-6), 9);
  take(message(2, { ids: [8] }), 2 / 60);
  near(still(1.5 / 60), 9);
  near(still(3 / 60), 9);
});

test('frames of two banks are not mixed', () => {
  const { take, still, hero } = played();
  take(message(0), 0);
  take(message(1, { rig: OTHER }), 1 / 60);
  near(still(0.9 / 60), 0);
  assert.equal(hero.pose().rig, RIG);
  near(still(1 / 60 + 1e-6), 1 / 60);
  assert.equal(hero.pose().rig, OTHER);
});

test('rotations take the shorter arc at length 1', () => {
  for (let count = 0; count < 500; count++) {
    const random = () => { const q = Array.from({ length: 4 }, () => Math.random() - 0.5); const l = Math.hypot(...q); return q.map((v) => v / l); };
    const [one, other] = [new Pose(RIG, true, false), new Pose(RIG, true, false)];
    const [a, b] = [random(), random()];
    one.rotations.set(a);
    other.rotations.set(b);
    const share = Math.random();
    one.mix(other, share);
    const c = Array.from(one.rotations);
    const angle = (p, q) => 2 * Math.acos(Math.min(1, Math.abs(p.reduce((sum, v, at) => sum + v * q[at], 0))));
    near(Math.hypot(...c), 1, 1e-6);
    near(angle(a, c) + angle(c, b), angle(a, b), 2e-3); // on the arc
    if (angle(a, b) < Math.PI / 6) near(angle(a, c), share * angle(a, b), 0.03 * Math.PI / 180 + 1e-3);
  }
});

test('a delay that was too short grows slowly, and then nothing is held', () => {
  const { take, playback } = played();
  for (let number = 0; number < 300; number++) take(message(number, { rate: 30 }), number / 30 + (number % 3 ? 0 : 0.2));
  near(playback.delay, 1 / 30 + 0.2, 0.02);
});
