/** What a pointer shows in the scene. */

import { Vector3 } from '../vendor/three.js';

/** @import { Stage } from '../scene/stage.js' */

/** @typedef {{ from: Vector3, along: Vector3 }} Ray `along` has length 1 */

/**
 * Returns the ray of what is seen below a pointer.
 *
 * @param {{ offsetX: number, offsetY: number }} event on the canvas
 * @param {Pick<Stage, 'camera' | 'canvas'>} stage
 * @returns {Ray}
 */
export function rayAt({ offsetX, offsetY }, { camera, canvas }) {
  const x = (2 * offsetX) / canvas.clientWidth - 1, y = 1 - (2 * offsetY) / canvas.clientHeight;
  const from = new Vector3(x, y, -1).unproject(camera);
  return { from, along: new Vector3(x, y, 1).unproject(camera).sub(from).normalize() };
}

/**
 * Returns where a ray meets a plane; undefined if it is parallel to it, or the plane lies behind.
 *
 * @param {Ray} ray
 * @param {Vector3} point of the plane
 * @param {Vector3} normal
 */
export function onPlane({ from, along }, point, normal) {
  const slope = along.dot(normal);
  const distance = point.clone().sub(from).dot(normal) / slope;
  return Math.abs(slope) > 1e-6 && distance > 0 ? from.clone().addScaledVector(along, distance) : undefined;
}

/**
 * Returns the place on a line that is nearest to a ray; undefined if both are nearly parallel.
 *
 * @param {Ray} ray
 * @param {Vector3} point of the line
 * @param {'x' | 'y' | 'z'} axis of the world, along which the line goes
 */
export function alongAxis({ from, along }, point, axis) {
  const line = new Vector3();
  line[axis] = 1;
  const cosine = line.dot(along);
  if (cosine ** 2 > 0.998) return undefined;
  const apart = from.clone().sub(point);
  const distance = (apart.dot(line) - cosine * apart.dot(along)) / (1 - cosine ** 2);
  return point.clone().addScaledVector(line, distance);
}
