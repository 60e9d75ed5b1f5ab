// What shows a character's own file. It is loaded when it is needed.
export { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
export { clone } from 'three/addons/utils/SkeletonUtils.js';
