// Prints the world matrices of a glTF or FBX file's nodes, by three.js: a line of JSON with their names [N], and for each
// animation a line {worlds, keyed}: matrices [F][N][16] by columns, and whether all tracks of a node, and of those above
// it, have a key at a frame [F][N].
// Usage: node three_worlds.mjs FILE ANIMATIONS, which are JSON: [{frames, rate}]. Frames count from the first key.
import { readFileSync } from 'node:fs';
import * as THREE from 'three';
import { FBXLoader } from 'three/addons/loaders/FBXLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

globalThis.self = globalThis.window = globalThis; // what the loaders expect of a browser
globalThis.ProgressEvent = class {};
console.warn = () => {};

const AT_A_KEY = 1e-4; // seconds

async function loadGltf(data, isText) {
  const loader = new GLTFLoader();
  loader.register(() => ({ name: 'no textures', loadTexture: () => Promise.resolve(new THREE.Texture()) }));
  const { scene, animations, parser } = await loader.parseAsync(isText ? new TextDecoder().decode(data) : data.buffer, '');
  const listed = parser.json.nodes;
  const order = []; // each node before its children, as our reader lists them
  const visit = (number) => {
    order.push(number);
    listed[number].children?.forEach(visit);
  };
  const children = new Set(listed.flatMap((node) => node.children ?? []));
  listed.forEach((_, number) => children.has(number) || visit(number));
  const nodes = await Promise.all(order.map((number) => parser.getDependency('node', number)));
  return { scene, animations, nodes, names: order.map((number) => listed[number].name) };
}

function loadFbx(data) {
  const scene = new FBXLoader().parse(data.buffer, '');
  const nodes = [];
  scene.traverse((node) => node.userData.originalName && nodes.push(node));
  return { scene, animations: scene.animations, nodes, names: nodes.map((node) => node.userData.originalName) };
}

const [file, wanted] = process.argv.slice(2);
const data = new Uint8Array(readFileSync(file));
const loaded = file.endsWith('.fbx') ? loadFbx(data) : await loadGltf(data, file.endsWith('.gltf'));
const { scene, animations, nodes, names } = loaded;
console.log(JSON.stringify(names));
JSON.parse(wanted).forEach(({ frames, rate }, number) => {
  const mixer = new THREE.AnimationMixer(scene);
  const { tracks } = animations[number];
  const action = mixer.clipAction(animations[number]).setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const first = Math.min(...tracks.map((track) => track.times[0]));
  // Rounded as keys are, which matters to steps.
  const times = Array.from({ length: frames }, (_, frame) => Math.fround(first + frame / rate));
  const isKeyed = (node, time) => node === null || (isKeyed(node.parent, time) && tracks.every(({ name, times: keys }) =>
    name.split('.')[0] !== node.name || keys.some((key) => Math.abs(key - time) < AT_A_KEY)));
  const worlds = times.map((time) => {
    mixer.setTime(time);
    scene.traverse((node) => node.quaternion.normalize()); // as glTF asks; three.js leaves whole-number keys as they are
    scene.updateMatrixWorld(true);
    return nodes.map((node) => node.matrixWorld.toArray());
  });
  mixer.stopAllAction(); // puts the nodes back at rest
  console.log(JSON.stringify({ worlds, keyed: times.map((time) => nodes.map((node) => isKeyed(node, time))) }));
});
