import { BufferAttribute, BufferGeometry, Color, Group, Matrix4, MeshBasicMaterial, MeshStandardMaterial, SkinnedMesh, Sphere } from '../vendor/three.js';
import { COLOURS } from './differences.js';
import { formsOf } from './forms.js';
import { Joints } from './joints.js';

/** @import { Pose, Rig } from '../vendor/motionsplice.js' */
/** @import { Style } from './forms.js' */

const OPAQUE = new MeshStandardMaterial({ vertexColors: true, roughness: 0.72, metalness: 0 });

/** A body in a rig's proportions, in one draw call. */
export class Body {
  object = new Group();
  /** Places of the joints [J][3] in the pose that is shown, without the offset. */
  positions;
  #rig;
  #forms;
  #joints;
  /** Opaque bodies share one, which saves uploads of uniforms. */
  #material = OPAQUE;
  #mesh;
  /** Drawn before a transparent body, to hide its own far side. @type {SkinnedMesh | undefined} */
  #mask;
  /** @type {Style | undefined} */
  #style;
  #colour;
  #isCompared = false;

  /**
   * @param {Rig} rig
   * @param {string} colour
   */
  constructor(rig, colour) {
    this.#rig = rig;
    this.#colour = new Color(colour);
    this.#forms = formsOf(rig);
    this.#joints = new Joints(this.#forms.anatomy.places);
    this.positions = new Float32Array(3 * rig.joints.length);
    this.#mesh = this.#skinned(new BufferGeometry(), this.#material);
    this.#mesh.castShadow = true;
    this.style = 'mannequin';
  }

  /**
   * Shows a pose.
   *
   * @param {Pose} pose with rotations
   * @param {ArrayLike<number>} offset metres, [3]
   */
  set(pose, offset) {
    const turns = this.#rig.worldPositions(pose.root, /** @type {Float32Array} */ (pose.rotations), this.positions);
    this.#joints.set(this.positions, turns, offset);
    const sphere = /** @type {Sphere} */ (this.#mesh.boundingSphere);
    sphere.center.set(this.positions[0] + offset[0], this.positions[1] + offset[1], this.positions[2] + offset[2]);
  }

  /** The rig's body parts. */
  get anatomy() {
    return this.#forms.anatomy;
  }

  get style() {
    return this.#style ?? 'mannequin';
  }

  set style(style) {
    if (style === this.#style) return;
    this.#style = style;
    const { shape, geometry: { index, attributes } } = this.#forms.of(style);
    const geometry = new BufferGeometry();
    geometry.setIndex(index);
    for (const [name, attribute] of Object.entries(attributes)) geometry.setAttribute(name, attribute);
    geometry.setAttribute('color', new BufferAttribute(new Float32Array(shape.positions.length), 3));
    this.#mesh.geometry.dispose();
    this.#mesh.geometry = geometry;
    if (this.#mask) this.#mask.geometry = geometry;
    this.#paint(undefined);
  }

  get opacity() {
    return this.#mesh.material.opacity;
  }

  set opacity(opacity) {
    const isTransparent = opacity < 1;
    if (isTransparent && this.#material === OPAQUE) this.#material = Object.assign(OPAQUE.clone(), { transparent: true });
    if (this.#material !== OPAQUE) this.#material.opacity = opacity;
    this.#mesh.material = isTransparent ? this.#material : OPAQUE;
    this.#mesh.castShadow = opacity > 0.4;
    if (isTransparent && !this.#mask) {
      this.#mask = this.#skinned(this.#mesh.geometry, new MeshBasicMaterial({ colorWrite: false, transparent: true }));
      this.#mask.renderOrder = 3; // after all opaque objects, before the body that it belongs to
    }
    if (this.#mask) this.#mask.visible = isTransparent;
    this.#mesh.renderOrder = isTransparent ? 4 : 0;
  }

  /**
   * Colours the joints.
   *
   * @param {Float32Array | undefined} values 0 to 1 of each joint [J]; undefined: the body's own colour
   */
  colours(values) {
    if (values || this.#isCompared) this.#paint(values);
  }

  dispose() {
    this.object.removeFromParent();
    this.#mesh.geometry.dispose();
    if (this.#material !== OPAQUE) this.#material.dispose();
    /** @type {MeshBasicMaterial | undefined} */ (this.#mask?.material)?.dispose();
    this.#joints.dispose();
  }

  /** @param {Float32Array | undefined} values */
  #paint(values) {
    this.#isCompared = values !== undefined;
    const { colourJoints, colourShares, shades } = this.#forms.of(this.style).shape;
    const attribute = /** @type {BufferAttribute} */ (this.#mesh.geometry.getAttribute('color'));
    const out = /** @type {Float32Array} */ (attribute.array);
    const { r, g, b } = this.#colour;
    for (let vertex = 0; vertex < shades.length; vertex++) {
      let red = r, green = g, blue = b, shade = shades[vertex];
      if (values) {
        const first = values[colourJoints[2 * vertex]];
        const value = first + colourShares[vertex] * (values[colourJoints[2 * vertex + 1]] - first);
        const row = 3 * Math.round(255 * Math.max(0, Math.min(1, value || 0)));
        red = COLOURS[row], green = COLOURS[row + 1], blue = COLOURS[row + 2];
        shade = shade < 0 ? 0.3 * shade : 0; // the colours must be readable
      }
      const white = Math.max(0, shade), kept = 1 - Math.abs(shade);
      out[3 * vertex] = red * kept + white;
      out[3 * vertex + 1] = green * kept + white;
      out[3 * vertex + 2] = blue * kept + white;
    }
    attribute.needsUpdate = true;
  }

  /**
   * @param {BufferGeometry} geometry
   * @param {MeshStandardMaterial | MeshBasicMaterial} material
   */
  #skinned(geometry, material) {
    const mesh = new SkinnedMesh(geometry, material);
    mesh.bind(this.#joints, new Matrix4());
    mesh.bindMode = 'detached';
    mesh.matrixAutoUpdate = mesh.matrixWorldAutoUpdate = false; // the joints place it
    mesh.boundingSphere = this.#mesh?.boundingSphere ?? new Sphere(undefined, 1.6 * this.#forms.anatomy.size);
    this.object.add(mesh);
    return mesh;
  }
}
