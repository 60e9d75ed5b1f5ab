// The project's golden files: answers of the service, always with the world positions of all joints.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import { decode, FormatError, Frames, Motion, Pose, Rig } from '../motionsplice.js';

const FILES = new URL('../../../tests/golden/files/', import.meta.url);
const read = (name) => readFileSync(new URL(name, FILES));
const json = (name) => JSON.parse(read(name));
const messages = json('index.json').filter(({ file }) => /^(characters|splice).*msgpack$/.test(file));

function opened({ file, rig: rigFile, request }) {
  const query = new URLSearchParams(request.split('?')[1]);
  const described = json(rigFile);
  const rig = new Rig(described, described.axes);
  const bytes = new Uint8Array(read(file)).slice(); // a message has a buffer of its own
  return { bytes, rig, encoding: query.get('encoding') ?? 'float32', metre: described.axes === 'unreal' ? 100 : 1 };
}

function* poses(frames) {
  for (let number = 0; number < frames.count; number++) {
    for (let row = 0; row < frames.characters; row++) {
      const pose = Pose.for(frames);
      pose.read(frames, number, row);
      yield pose;
    }
  }
}

for (const entry of messages) {
  test(`joints of ${entry.file} are where the service has them`, () => {
    const { bytes, rig, encoding, metre } = opened(entry);
    const frames = new Frames(decode(bytes), rig, encoding);
    assert.equal(frames.characters, entry.file.startsWith('splice') ? 1 : 2);
    for (const pose of poses(frames)) {
      const most = (encoding === 'int16' ? 1e-4 : 1e-5) * metre;
      pose.worldPositions().forEach((one, at) => assert.ok(Math.abs(one - pose.positions[at]) < most));
    }
  });

  test(`arrays of ${entry.file} are views that equal its JSON`, () => {
    const { bytes, rig, encoding } = opened(entry);
    const frames = new Frames(decode(bytes), rig, encoding);
    const other = json(entry.file.replace('msgpack', 'json'));
    const pairs = [['ids', 'ids'], ['rootPositions', 'root_positions'], ['rotations', 'rotations'],
      ['worldPositions', 'world_positions'], ['rootSteps', 'root_steps'], ['rootTurns', 'root_turns']];
    for (const [name, key] of pairs) {
      if (other[key] === undefined) continue;
      assert.equal(frames[name].buffer, bytes.buffer, name);
      assert.deepEqual(frames[name], frames[name].constructor.from(other[key].flat(Infinity)));
    }
    assert.deepEqual([frames.frame, frames.count, frames.rate], [other.frame, other.count, other.rate]);
  });

  test(`${entry.file} damaged anywhere gives frames or a FormatError`, () => {
    const { bytes, rig, encoding } = opened(entry);
    for (let at = 0; at < bytes.length; at++) {
      for (const damaged of [bytes.slice(0, at), bytes.with(at, bytes[at] ^ 0xff), bytes.with(at, (bytes[at] * 5 + at) % 256)]) {
        try {
          new Frames(decode(damaged), rig, encoding);
        } catch (error) {
          assert.ok(error instanceof FormatError, `byte ${at}: ${error.stack}`);
        }
      }
    }
    assert.throws(() => new Frames(decode(bytes.slice(0, -1)), rig, encoding), FormatError);
    assert.throws(() => new Frames(decode(bytes), { ...rig, joints: rig.joints.slice(1) }, encoding), /expected \d+ numbers, found \d+/);
  });
}

test('frames of another rig, or without what they need, are refused by name', () => {
  const { bytes, rig, encoding } = opened(messages[0]);
  const good = decode(bytes);
  for (const [key, value, message] of [
    ['bank', 'x', /^bank: expected .*, found x/], ['frame', -1, /^frame: .* found -1/], ['count', 0, /^count: .* found 0/],
    ['count', 3, /^root_positions: expected 18 numbers, found 12/], ['rate', 0, /^rate: /], ['time', 'now', /^time: /],
    ['ids', undefined, /^ids: missing/], ['ids', 7, /^ids: not a blob/], ['root_positions', new Uint8Array(5), /5 bytes are not whole/],
  ]) {
    assert.throws(() => new Frames({ ...good, [key]: value }, rig, encoding), (error) => error instanceof FormatError && message.test(error.message));
  }
  assert.throws(() => new Frames({ ...good, rotations: undefined, world_positions: undefined }, rig, encoding), /missing/);
});

test('a stream of one file becomes a motion', () => {
  const bytes = new Uint8Array(read('stream.bin'));
  const found = [];
  for (let at = 0; at < bytes.length;) {
    const length = new DataView(bytes.buffer, bytes.byteOffset + at).getUint32(0);
    found.push(decode(bytes.slice(at + 4, at + 4 + length)));
    at += 4 + length;
  }
  const [header, ...others] = found;
  const motion = new Motion(new Rig(header, header.axes), header.rate);
  for (const one of others) motion.add(new Frames(one, motion.rig, header.encoding));
  assert.equal(motion.held.length, header.frames);
  assert.throws(() => motion.add(new Frames(others[0], motion.rig, header.encoding)), /^FormatError: frame: expected 13, found 10/);
  const [first, second] = [0, 1].map((number) => Float32Array.from(motion.pose(number / motion.rate).root));
  motion.pose(0.5 / motion.rate).root.forEach((one, axis) => assert.ok(Math.abs(one - (first[axis] + second[axis]) / 2) < 1e-6));
  assert.deepEqual(motion.pose(-1).root, first);
  assert.deepEqual(Float32Array.from(motion.pose(99).root), Float32Array.from(motion.pose(motion.duration).root));
});
