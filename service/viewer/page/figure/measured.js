import { Matrix4, Mesh, SkinnedMesh, Vector3 } from '../vendor/three.js';
import { Anatomy } from '../scene/anatomy.js';
import { heightsOverSole } from '../scene/foot.js';
import { tracks } from '../scene/tracks.js';

/** @import { Object3D } from '../vendor/three.js' */
/** @import { Motion } from '../vendor/motionsplice.js' */
/** @import { Figure } from './figure.js' */

const SAMPLES = 40; // frames
const HEIGHT = 1.78; // metres of a mannequin of size 1
const GIANT = 1.25; // times the mannequin's height, arms down
/** Directions in which points of a bone are outermost: to the sides, edges and corners of a cube. */
const DIRECTIONS = [-1, 0, 1].flatMap((x) => [-1, 0, 1].flatMap((y) => [-1, 0, 1].map((z) => [x, y, z]))).filter((one) => one.some(Boolean));

/**
 * Measures a figure against the mannequin. Legs are as long as the mannequin's, but the feet below may be thicker, and the body
 * above much larger.
 *
 * @param {Figure} figure
 * @param {Motion} motion of the bank's skeleton, which the figure shows
 * @returns {{ lift: number, shrink: number }} metres by which it must be raised for its lowest points to be where the
 *   mannequin's soles are, and by what it is to be made smaller not to be a giant
 */
export function measured(figure, motion) {
  const outermost = outermostPoints(figure.object);
  const anatomy = new Anatomy(motion.rig);
  const { count, positions } = tracks(motion);
  const lifts = [], heights = [];
  for (let sample = 0; sample < SAMPLES; sample++) {
    const frame = Math.round((sample / (SAMPLES - 1)) * (count - 1));
    figure.at(frame / motion.rate);
    figure.object.updateMatrixWorld(true);
    const [low, high] = extent(outermost);
    lifts.push(solesAt(anatomy, positions.subarray(3 * motion.rig.joints.length * frame)) - low);
    heights.push(high - low);
  }
  const taller = median(heights) / (HEIGHT * anatomy.size);
  return { lift: median(lifts), shrink: taller > GIANT ? 1 / taller : 1 };
}

/** @param {number[]} values */
function median(values) {
  return values.sort((a, b) => a - b)[values.length >> 1];
}

/**
 * Returns the height of the lower sole of the mannequin.
 *
 * @param {Anatomy} anatomy
 * @param {Float32Array} positions
 */
function solesAt(anatomy, positions) {
  return Math.min(...(/** @type {const} */ (['left', 'right'])).flatMap((half) => {
    const over = heightsOverSole(anatomy, half);
    const ankle = positions[3 * anatomy.role(`${half}_ankle`) + 1] - over.ankle;
    return anatomy.has(`${half}_toe`) ? [ankle, positions[3 * anatomy.role(`${half}_toe`) + 1] - over.toe] : [ankle];
  }));
}

/** @typedef {{ object: Object3D, points: Vector3[] }} Outermost points in the space of an object */

/**
 * Returns the outermost vertices that each bone moves most.
 *
 * @param {Object3D} model
 * @returns {Outermost[]}
 */
function outermostPoints(model) {
  /** @type {Map<Object3D, { reach: number[], points: Vector3[] }>} */
  const found = new Map();
  const [point, matrix] = [new Vector3(), new Matrix4()];
  const note = (/** @type {Object3D} */ object) => {
    let one = found.get(object);
    if (!one) found.set(object, one = { reach: DIRECTIONS.map(() => -Infinity), points: DIRECTIONS.map(() => new Vector3()) });
    const { reach, points } = one;
    DIRECTIONS.forEach(([x, y, z], direction) => {
      const far = x * point.x + y * point.y + z * point.z;
      if (far > reach[direction]) {
        reach[direction] = far;
        points[direction].copy(point);
      }
    });
  };
  model.traverse((mesh) => {
    if (!(mesh instanceof Mesh)) return;
    const { position, skinIndex, skinWeight } = mesh.geometry.attributes;
    const isSkinned = mesh instanceof SkinnedMesh && skinIndex && skinWeight;
    const inwards = isSkinned ? mesh.skeleton.boneInverses.map((inverse) => matrix.multiplyMatrices(inverse, mesh.bindMatrix).clone()) : [];
    for (let vertex = 0; vertex < position.count; vertex++) {
      point.fromBufferAttribute(position, vertex);
      if (!isSkinned) {
        note(mesh);
        continue;
      }
      let column = 0;
      for (let other = 1; other < 4; other++) if (skinWeight.getComponent(vertex, other) > skinWeight.getComponent(vertex, column)) column = other;
      const bone = skinIndex.getComponent(vertex, column);
      if (!inwards[bone]) continue;
      point.applyMatrix4(inwards[bone]);
      note(mesh.skeleton.bones[bone]);
    }
  });
  return [...found].map(([object, { points }]) => ({ object, points }));
}

/**
 * Returns the heights of the lowest and the highest point.
 *
 * @param {Outermost[]} outermost
 */
function extent(outermost) {
  let low = Infinity, high = -Infinity;
  for (const { object, points } of outermost) {
    const [, b, , , , f, , , , j, , , , n] = object.matrixWorld.elements;
    for (const { x, y, z } of points) {
      const height = b * x + f * y + j * z + n;
      low = Math.min(low, height);
      high = Math.max(high, height);
    }
  }
  return [low, high];
}
