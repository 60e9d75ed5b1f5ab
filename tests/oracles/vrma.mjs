// Plays a VRM animation on a VRM character by three.js and @pixiv/three-vrm-animation, and prints the world positions of
// the bones of the character: JSON, one map of bones for each time. Usage: node vrma.mjs CHARACTER ANIMATION TIME...
import fs from 'node:fs';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { VRMLoaderPlugin } from '@pixiv/three-vrm';
import { VRMAnimationLoaderPlugin, createVRMAnimationClip } from '@pixiv/three-vrm-animation';
globalThis.self = globalThis;
globalThis.ProgressEvent = class {};
const [model, animation, ...times] = process.argv.slice(2);
async function load(file, plugin) {
  const loader = new GLTFLoader();
  loader.register((parser) => new plugin(parser));
  const data = fs.readFileSync(file);
  return loader.parseAsync(data.buffer.slice(data.byteOffset, data.byteOffset + data.length), '');
}
const { vrm } = (await load(model, VRMLoaderPlugin)).userData;
const { vrmAnimations } = (await load(animation, VRMAnimationLoaderPlugin)).userData;
const mixer = new THREE.AnimationMixer(vrm.scene);
const action = mixer.clipAction(createVRMAnimationClip(vrmAnimations[0], vrm));
action.setLoop(THREE.LoopOnce);
action.clampWhenFinished = true;
action.play();
const frames = times.map((time) => {
  mixer.setTime(Number(time));
  vrm.humanoid.update();
  vrm.scene.updateMatrixWorld(true);
  return Object.fromEntries(
    Object.entries(vrm.humanoid.humanBones).map(([bone, { node }]) => [bone, node.getWorldPosition(new THREE.Vector3()).toArray()]),
  );
});
console.log(JSON.stringify(frames));
