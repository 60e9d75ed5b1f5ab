// Poses a character's own bones from a live service, and prints how far they are from the service's world positions.
// Usage: node bones.mjs URL CHARACTER.glb
import { readFileSync } from 'node:fs';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import WebSocket from 'ws';
import { connect } from '../motionsplice.js';

globalThis.self = globalThis; // what the loader expects of a browser
globalThis.ProgressEvent = class {};
const [url, file] = process.argv.slice(2);
const loader = new GLTFLoader();
loader.register(() => ({ name: 'no textures', loadTexture: () => Promise.resolve(new THREE.Texture()) }));
const load = async () => (await loader.parseAsync(new Uint8Array(readFileSync(file)).buffer, '')).scene;
const inParts = (scene) => {
  const parts = { model: scene };
  scene.traverse((one) => { parts.skeleton = one.skeleton ?? parts.skeleton; });
  return parts;
};

const service = await connect(url, { WebSocket, parts: 'both' });
const hero = await service.create('walk', { position: [1, 0, 2], heading: 1 });
await hero.act('carry_box');
const targets = { model: await load(), moved: await load(), skeleton: inParts(await load()).skeleton };
targets.moved.position.set(3, 1, -2); // the game's own: the bones go with it
const worst = { model: 0, moved: 0, skeleton: 0 };
let vertex = 0; // how far the mesh's first vertex has come from where it is bound
for (let count = 0; count < 100; count++) {
  await new Promise((resolve) => service.on('frames', resolve));
  const pose = hero.pose();
  for (const [name, target] of Object.entries(targets)) {
    pose.apply(target);
    const places = pose.worldPositions(); // those that were sent, between frames, are on chords
    let top = target.isObject3D ? target : target.bones[0];
    while (top.parent) top = top.parent;
    top.updateMatrixWorld(true);
    const offset = name === 'moved' ? top.position : new THREE.Vector3();
    const bones = target.bones ?? inParts(target).skeleton.bones;
    for (const bone of bones) {
      const joint = pose.rig.joints.findIndex((one) => THREE.PropertyBinding.sanitizeNodeName(one) === bone.name);
      if (joint < 0) continue; // a helper
      const place = new THREE.Vector3().fromArray(places, 3 * joint).add(offset);
      worst[name] = Math.max(worst[name], place.distanceTo(new THREE.Vector3().setFromMatrixPosition(bone.matrixWorld)));
    }
  }
  targets.model.traverse((one) => { if (one.isSkinnedMesh) vertex = one.getVertexPosition(0, new THREE.Vector3()).distanceTo(new THREE.Vector3(...pose.root)); });
}
console.log(JSON.stringify({ worst, vertex }));
service.close();
