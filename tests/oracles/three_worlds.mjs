// Prints the world matrices of a glTF file's nodes, by three.js: a line of JSON with their names [N], and for each
// animation a line with matrices [F][N][16], by columns. Usage: node three_worlds.mjs FILE ANIMATIONS, which are JSON:
// [{frames, rate}]. Frames count from the first key.
import { readFileSync } from 'node:fs';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

globalThis.self = globalThis; // what the loader expects of a browser
globalThis.ProgressEvent = class {};

const [file, animations] = process.argv.slice(2);
const loader = new GLTFLoader();
loader.register(() => ({ name: 'no textures', loadTexture: () => Promise.resolve(new THREE.Texture()) }));
const data = new Uint8Array(readFileSync(file));
const gltf = await loader.parseAsync(file.endsWith('.gltf') ? new TextDecoder().decode(data) : data.buffer, '');
const { json } = gltf.parser;
const order = []; // each node before its children, as our reader lists them
const visit = (number) => {
  order.push(number);
  json.nodes[number].children?.forEach(visit);
};
const children = new Set(json.nodes.flatMap((node) => node.children ?? []));
json.nodes.forEach((_, number) => children.has(number) || visit(number));
const nodes = await Promise.all(order.map((number) => gltf.parser.getDependency('node', number)));

console.log(JSON.stringify(order.map((number) => json.nodes[number].name)));
JSON.parse(animations).forEach(({ frames, rate }, number) => {
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const clip = gltf.animations[number];
  const action = mixer.clipAction(clip).setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const first = Math.min(...clip.tracks.map((track) => track.times[0]));
  const worlds = Array.from({ length: frames }, (_, frame) => {
    mixer.setTime(Math.fround(first + frame / rate)); // as keys are rounded, which matters to steps
    gltf.scene.traverse((node) => node.quaternion.normalize()); // as glTF asks; three.js leaves whole-number keys as they are
    gltf.scene.updateMatrixWorld(true);
    return nodes.map((node) => node.matrixWorld.toArray());
  });
  mixer.stopAllAction(); // puts the nodes back at rest
  console.log(JSON.stringify(worlds));
});
