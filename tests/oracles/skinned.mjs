// Plays an animation of a GLB file by three.js, and prints the world positions of its first skinned mesh's vertices, as
// JSON, for each time. Usage: node skinned.mjs FILE ANIMATION TIME...
import fs from 'node:fs';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
globalThis.self = globalThis;
globalThis.ProgressEvent = class {};
const [file, name, ...times] = process.argv.slice(2);
const data = fs.readFileSync(file);
const gltf = await new GLTFLoader().parseAsync(data.buffer.slice(data.byteOffset, data.byteOffset + data.length), '');
const mixer = new THREE.AnimationMixer(gltf.scene);
const action = mixer.clipAction(gltf.animations.find((one) => one.name === name));
action.setLoop(THREE.LoopOnce);
action.clampWhenFinished = true;
action.play();
let mesh;
gltf.scene.traverse((one) => (mesh = one.isSkinnedMesh ? one : mesh));
for (const time of times) {
  mixer.setTime(Number(time));
  gltf.scene.updateMatrixWorld(true);
  const count = mesh.geometry.attributes.position.count;
  const vertices = [];
  for (let i = 0; i < count; i++) {
    vertices.push(mesh.localToWorld(mesh.getVertexPosition(i, new THREE.Vector3())).toArray());
  }
  console.log(JSON.stringify(vertices));
}
