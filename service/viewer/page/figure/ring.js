import { BufferAttribute, BufferGeometry, Mesh, MeshBasicMaterial } from '../vendor/three.js';

const INNER = 0.3, OUTER = 0.34; // metres
const SIDES = 48;
const RAISED = 0.008; // metres above the floor

/** A ring on the floor in the colour of a side, below a user's character, which has colours of its own. */
export class Ring {
  /** @param {string} colour */
  constructor(colour) {
    const geometry = new BufferGeometry();
    const places = new Float32Array(6 * (SIDES + 1));
    const triangles = [];
    for (let at = 0; at <= SIDES; at++) {
      const x = Math.cos((2 * Math.PI * at) / SIDES), z = Math.sin((2 * Math.PI * at) / SIDES);
      places.set([INNER * x, 0, INNER * z, OUTER * x, 0, OUTER * z], 6 * at);
      const inner = 2 * at;
      if (at < SIDES) triangles.push(inner, inner + 2, inner + 1, inner + 1, inner + 2, inner + 3);
    }
    geometry.setAttribute('position', new BufferAttribute(places, 3));
    geometry.setIndex(triangles);
    this.object = new Mesh(geometry, new MeshBasicMaterial({ color: colour }));
  }

  /**
   * @param {number} x metres
   * @param {number} floor metres
   * @param {number} z metres
   */
  place(x, floor, z) {
    this.object.position.set(x, floor + RAISED, z);
  }

  dispose() {
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}
