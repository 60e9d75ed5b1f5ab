import { Bone, BufferAttribute, BufferGeometry, Color, Group, Matrix4, MeshBasicMaterial, MeshStandardMaterial, Skeleton, SkinnedMesh, Sphere } from '../vendor/three.js';
import { Anatomy } from './anatomy.js';
import { COLOURS } from './differences.js';
import { mannequin } from './mannequin.js';
import { stick } from './stick.js';

/** @import { Pose, Rig } from '../vendor/motionsplice.js' */
/** @import { Shape } from './shape.js' */

/** @typedef {'mannequin' | 'stick'} Style */

const OPAQUE = new MeshStandardMaterial({ vertexColors: true, roughness: 0.72, metalness: 0 });

/** A body in a rig's proportions, in one draw call. */
export class Body {
  object = new Group();
  /** Places of the joints [J][3] in the pose that is shown, without the offset. */
  positions;
  #rig;
  #joints;
  /** Opaque bodies share one, so that the graphics card need not change it between them. */
  #material = OPAQUE;
  #mesh;
  /** Drawn before a body that is seen through, so that its own far side is hidden. @type {SkinnedMesh | undefined} */
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
    this.#joints = new Joints(rig, formsOf(rig).anatomy);
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

  get style() {
    return this.#style ?? 'mannequin';
  }

  set style(style) {
    if (style === this.#style) return;
    this.#style = style;
    const { shape, attributes } = formsOf(this.#rig)[style];
    const geometry = new BufferGeometry();
    geometry.setIndex(attributes.index);
    for (const name of /** @type {const} */ (['position', 'normal', 'skinIndex', 'skinWeight'])) geometry.setAttribute(name, attributes[name]);
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
      this.#mask.renderOrder = 3; // after all that is not seen through, and before what it hides
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
    const { colourJoints, colourShares, shades } = formsOf(this.#rig)[this.style].shape;
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
    mesh.boundingSphere = this.#mesh?.boundingSphere ?? new Sphere(undefined, 1.6 * formsOf(this.#rig).anatomy.size);
    this.object.add(mesh);
    return mesh;
  }
}

/** Where the joints of a body are, as the graphics card reads them. */
class Joints extends Skeleton {
  /**
   * @param {Rig} rig
   * @param {Anatomy} anatomy
   */
  constructor(rig, anatomy) {
    super(rig.joints.map(() => new Bone()));
    this.places = Float32Array.from(anatomy.places.flat());
    this.computeBoneTexture();
  }

  /**
   * Takes each joint from its place in the bind pose to its place in the world.
   *
   * @param {Float32Array} positions
   * @param {ArrayLike<number>} turns
   * @param {ArrayLike<number>} offset
   */
  set(positions, turns, offset) {
    const { places } = this;
    const out = /** @type {Float32Array} */ (this.boneMatrices);
    const [ox, oy, oz] = [offset[0], offset[1], offset[2]];
    for (let at = 0, turn = 0, to = 0; at < places.length; at += 3, turn += 4, to += 16) {
      const x = turns[turn], y = turns[turn + 1], z = turns[turn + 2], w = turns[turn + 3];
      const a = places[at], b = places[at + 1], c = places[at + 2];
      const xx = 1 - 2 * (y * y + z * z), xy = 2 * (x * y + w * z), xz = 2 * (x * z - w * y);
      const yx = 2 * (x * y - w * z), yy = 1 - 2 * (x * x + z * z), yz = 2 * (y * z + w * x);
      const zx = 2 * (x * z + w * y), zy = 2 * (y * z - w * x), zz = 1 - 2 * (x * x + y * y);
      out[to] = xx, out[to + 1] = xy, out[to + 2] = xz;
      out[to + 4] = yx, out[to + 5] = yy, out[to + 6] = yz;
      out[to + 8] = zx, out[to + 9] = zy, out[to + 10] = zz;
      out[to + 12] = positions[at] + ox - (xx * a + yx * b + zx * c);
      out[to + 13] = positions[at + 1] + oy - (xy * a + yy * b + zy * c);
      out[to + 14] = positions[at + 2] + oz - (xz * a + yz * b + zz * c);
    }
    if (this.boneTexture) this.boneTexture.needsUpdate = true;
  }

  /** Nothing: `set` has written the matrices. @override */
  update() {}
}

/** @typedef {{ shape: Shape, attributes: ReturnType<typeof attributesOf> }} Form */

/** @type {WeakMap<Rig, { anatomy: Anatomy, mannequin: Form, stick: Form }>} */
const FORMS = new WeakMap();

/** The surfaces of a rig, which its bodies share. @param {Rig} rig */
function formsOf(rig) {
  let forms = FORMS.get(rig);
  if (!forms) {
    const anatomy = new Anatomy(rig);
    const form = (/** @type {Shape} */ shape) => ({ shape, attributes: attributesOf(shape) });
    forms = { anatomy, mannequin: form(mannequin(anatomy)), stick: form(stick(anatomy)) };
    FORMS.set(rig, forms);
  }
  return forms;
}

/** @param {Shape} shape */
function attributesOf(shape) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(Float32Array.from(shape.positions), 3));
  geometry.setIndex(new BufferAttribute(Uint16Array.from(shape.indices), 1));
  geometry.computeVertexNormals();
  return {
    position: geometry.getAttribute('position'), normal: geometry.getAttribute('normal'), index: geometry.getIndex(),
    skinIndex: new BufferAttribute(Uint16Array.from(shape.skinIndices), 4), skinWeight: new BufferAttribute(Float32Array.from(shape.skinWeights), 4),
  };
}
