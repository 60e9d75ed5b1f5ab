import { BufferAttribute, BufferGeometry } from '../vendor/three.js';

const SIDES = 16;

/**
 * Returns a surface of revolution about Y.
 *
 * @param {[number, number][]} profile height and radius of each ring, from below
 */
export function lathe(profile) {
  /** @type {number[]} */
  const places = [];
  /** @type {number[]} */
  const indices = [];
  profile.forEach(([height, radius], ring) => {
    for (let side = 0; side < SIDES; side++) {
      const angle = (2 * Math.PI * side) / SIDES;
      places.push(radius * Math.cos(angle), height, radius * Math.sin(angle));
      const here = SIDES * ring + side, next = SIDES * ring + ((side + 1) % SIDES);
      if (ring) indices.push(here - SIDES, here, next, here - SIDES, next, next - SIDES);
    }
  });
  return new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(places), 3)).setIndex(indices);
}

/** @param {number} radius */
export function ball(radius) {
  return lathe(Array.from({ length: 9 }, (_, ring) => [-radius * Math.cos((Math.PI * ring) / 8), radius * Math.sin((Math.PI * ring) / 8)]));
}
