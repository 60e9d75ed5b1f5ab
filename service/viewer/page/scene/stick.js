import { Limb } from './limb.js';
import { SHADE } from './mannequin.js';
import { Shape } from './shape.js';
import { minus, norm, plus, times } from './vectors.js';

/** @import { Anatomy, Half } from './anatomy.js' */

const BONE = [[0, 0.008, 0.008], [0.12, 0.015, 0.015], [1, 0.006, 0.006]];
const JOINT = 0.021; // metres

/**
 * Returns the surface of a stick figure: a thin bone to each joint, and a ball at each.
 *
 * @param {Anatomy} anatomy
 */
export function stick(anatomy) {
  const shape = new Shape();
  const limb = new Limb(anatomy, shape);
  const { places, size } = anatomy;
  const shades = places.map(() => 0);
  for (const half of /** @type {Half[]} */ (['left', 'right'])) {
    for (const start of [anatomy.role(`${half}_shoulder`), anatomy.role(`${half}_hip`)]) {
      for (const joint of [start, ...anatomy.below(start)]) shades[joint] = SHADE[half];
    }
  }
  places.forEach((place, joint) => {
    const parent = anatomy.parent(joint);
    const length = parent < 0 ? Infinity : norm(minus(place, places[parent]));
    if (parent >= 0) limb.add([parent, joint], BONE, { shade: shades[joint], sides: 6, scale: Math.min(size, 10 * length) });
    const radius = Math.min(JOINT * size, 0.3 * Math.max(length, 0.02 * size));
    shape.tube([-90, -50, 0, 50, 90].map((angle) => {
      const [sine, cosine] = [Math.sin((angle * Math.PI) / 180), Math.abs(angle) === 90 ? 0 : Math.cos((angle * Math.PI) / 180)];
      return {
        at: plus(place, times([0, 1, 0], radius * sine)), u: [0, 0, 1], v: [1, 0, 0], a: radius * cosine, b: radius * cosine,
        joints: [[joint, 1]], between: [joint, joint, 0],
      };
    }), shades[joint], 8);
  });
  return shape;
}
