// Motions of three joints for tests: a root, and both knees 0.1 m beside and 0.5 m below it.
import { Frames, Motion, Rig } from '../page/vendor/motionsplice.js';

const JOINTS = ['root', 'left_knee', 'right_knee'];
const RIG = new Rig({
  bank: 'a', joints: JOINTS, parents: [-1, 0, 0], offsets: [[0, 0, 0], [0.1, -0.5, 0], [-0.1, -0.5, 0]],
  roles: Object.fromEntries(JOINTS.map((name) => [name, name])),
}, 'gltf');

/** Returns a rotation about Y by radians. */
export function turnY(radians) {
  return [0, Math.sin(radians / 2), 0, Math.cos(radians / 2)];
}

/** Returns a motion from `poseOf(frame)`: the root's place, and rotations by joint. A rotation that is not given is none. */
export function motionOf(rate, count, poseOf) {
  const poses = Array.from({ length: count }, (_, frame) => poseOf(frame));
  const bytes = (numbers) => new Uint8Array(Float32Array.from(numbers).buffer);
  const message = {
    bank: 'a', frame: 0, count, rate,
    root_positions: bytes(poses.flatMap(({ root }) => root)),
    rotations: bytes(poses.flatMap(({ turns }) => JOINTS.flatMap((name) => turns[name] ?? [0, 0, 0, 1]))),
  };
  return new Motion(RIG, rate).add(new Frames(message, RIG, 'float32'));
}
