// What a user writes, for tsc --strict.
import * as THREE from 'three';
import { connect, ConnectionLostError, FormatError, Frames, Motion, Pose, RefusedError, splice, stream } from 'motionsplice';
import type { Character, Connection } from 'motionsplice';

const service: Connection = await connect('http://127.0.0.1:8000', { token: 'x', axes: 'gltf', parts: 'both', encoding: 'int16', rate: 60, ahead: 4 });
const hero: Character = await service.create({ walk: 0.5, run: 0.5 }, { position: [1, 0, 2], heading: 1, inPlace: true });
const frame: number = await hero.act('wave', { when: 'left_foot', blendOut: 0.2, ownClock: [0, 1], mask: 'arms', posture: 'running' });
await hero.look({ point: [1, 1.6, 4] }, { maxYaw: 1 });
await hero.aim({ direction: [0, 0, 1] }, { part: 'right_arm', steady: 1 });
await hero.look(null, { blend: 1 });
// @ts-expect-error: look has no part
void hero.look({ point: [1, 1.6, 4] }, { part: 'chest' });
const end: () => void = service.on('action_began', ({ ids, action }) => console.log(ids.map((id) => id + 1), action.length, frame));
service.on('reconnected', ({ failed }) => failed.forEach(({ id, error }) => console.log(id, error.type)));
service.on('frames', (frames: Frames) => frames.ids?.length);
service.on('error', (error: FormatError) => console.log(error.message));
end();
await service.set({ rate: 30, events: ['stride', 'left_down'] });
await service.send([{ do: 'speed', id: [1, 2], speed: 0.5 }]);
const scene = new THREE.Group();
const mesh = new THREE.SkinnedMesh();
const shown: boolean = hero.apply(scene) && hero.apply(mesh) && hero.apply(mesh.skeleton) && hero.apply([new THREE.Bone()]);
const pose: Pose | undefined = hero.pose();
const places: Float32Array | undefined = pose?.worldPositions();
const motion: Motion = await splice('http://127.0.0.1:8000', { locomotion: 'walk', action: 'wave', method: 'splice' }, { parts: 'world' });
const streamed = await stream('http://127.0.0.1:8000', { locomotion: 'walk', pace: 'realtime', ahead: 2 });
for await (const frames of streamed.frames) console.log(frames.rotations?.[0], motion.pose(0.5)?.root, shown, places);
try {
  await hero.play('run');
} catch (error) {
  if (error instanceof RefusedError) console.log(error.type);
  if (error instanceof ConnectionLostError) console.log(error.code);
}
// @ts-expect-error: no such curve
void hero.stop({ curve: 'steep' });
// @ts-expect-error: no such event
service.on('wellcome', () => {});
// @ts-expect-error: a locomotion is required
void hero.play();
