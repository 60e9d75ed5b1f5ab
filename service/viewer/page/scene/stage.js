import {
  Color, DirectionalLight, HemisphereLight, OrbitControls, OrthographicCamera, PCFShadowMap, PerspectiveCamera, Scene, WebGLRenderer,
} from '../vendor/three.js';
import { Ground } from './ground.js';

/** @import { Object3D } from '../vendor/three.js' */

/** Half the height that front, side and top show at first, in metres. */
const HALF_HEIGHT = 1.25;

const THEMES = {
  light: { back: '#eceef1', line: '#5d6673', shadow: 0.2, strength: 0.8, sky: '#ffffff', floor: '#b9bdc6', fill: 1.55, key: 1.9 },
  dark: { back: '#1b1e23', line: '#aab4c3', shadow: 0.5, strength: 0.5, sky: '#e4ebf7', floor: '#454b57', fill: 1.35, key: 1.85 },
};

/** The canvas, its lights, its floor and its cameras. It draws only when `draw` is called, and after a resize. */
export class Stage {
  scene = new Scene();
  perspective = new PerspectiveCamera(32, 1, 0.05, 120);
  orthographic = new OrthographicCamera(-1, 1, 1, -1, 0.1, 120);
  /** The camera that is drawn. @type {PerspectiveCamera | OrthographicCamera} */
  camera = this.perspective;
  controls;
  #renderer;
  /** @type {(() => void)[]} */
  #jobs = [];
  #ground = new Ground();
  #fill = new HemisphereLight();
  #key = new DirectionalLight();
  #rim = new DirectionalLight('#dfe8ff', 0.9); // from behind, so that a dark body has an edge

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.#renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.#renderer.debug.checkShaderErrors = false; // waits for the graphics card at each new shader
    this.#renderer.shadowMap.enabled = true;
    this.#renderer.shadowMap.type = PCFShadowMap;
    this.#rim.position.set(-4, 5, -6);
    const { shadow } = this.#key;
    this.#key.castShadow = true;
    shadow.mapSize.set(1024, 1024);
    Object.assign(shadow.camera, { left: -4, right: 4, top: 4, bottom: -4, near: 1, far: 22 });
    shadow.radius = 3;
    shadow.normalBias = 0.02;
    this.scene.add(this.#fill, this.#key, this.#key.target, this.#rim, this.#ground.object);
    this.controls = new OrbitControls(this.camera, canvas);
    this.camera.position.set(3, 1.9, 4.2);
    this.controls.target.set(0, 0.9, 0);
    this.controls.update();
    this.aim(0, 0);
    this.theme(false);
    new ResizeObserver(() => this.size()).observe(canvas);
    canvas.addEventListener('webglcontextrestored', () => this.draw()); // after three.js has heard of it
    this.size();
  }

  /** @param {Object3D} object */
  add(object) {
    this.scene.add(object);
  }

  /** @param {Object3D} object */
  remove(object) {
    this.scene.remove(object);
  }

  /** Height of the floor, in metres. */
  get floor() {
    return this.#ground.level;
  }

  set floor(level) {
    this.#ground.level = level;
  }

  /**
   * Moves the floor and the light to a place.
   *
   * @param {number} x
   * @param {number} z
   * @param {number} [wall] heading of the camera, if it sees the floor edge-on
   */
  aim(x, z, wall) {
    this.#ground.at(x, z);
    this.#ground.wall(wall);
    this.#key.target.position.set(x, this.floor + 0.5, z);
    this.#key.position.set(x + 3, this.floor + 8, z + 4);
  }

  /**
   * Makes the floor and its shadows reach far enough for a crowd.
   *
   * @param {number} width metres from one side to the other; 0: one character
   */
  reach(width) {
    this.#ground.reach(width);
    const { camera } = this.#key.shadow, half = 4 + 0.72 * width; // the light looks at the crowd from a corner
    Object.assign(camera, { left: -half, right: half, top: half, bottom: -half, near: Math.min(1, 8 - width), far: 22 + width });
    camera.updateProjectionMatrix();
  }

  /** Called when the canvas has another size, before it is drawn. */
  onsize = () => {};

  /** How many geometries and textures the graphics card holds. */
  get memory() {
    return this.#renderer.info.memory;
  }

  /** Draws a picture. */
  draw() {
    this.#renderer.render(this.scene, this.camera);
    for (const job of this.#jobs.splice(0)) job();
  }

  /**
   * Does something after the next picture. What was removed is disposed of then: three.js would else forget shaders that
   * the next picture needs, and compile them again.
   *
   * @param {() => void} job
   */
  later(job) {
    this.#jobs.push(job);
  }

  /** Fits the picture to the canvas, and draws it. */
  size() {
    const { clientWidth, clientHeight } = this.canvas;
    const width = Math.max(1, clientWidth), height = Math.max(1, clientHeight);
    this.#renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.#renderer.setSize(width, height, false);
    this.perspective.aspect = width / height;
    // A narrow canvas shows as much from left to right as a square one.
    this.perspective.fov = width < height ? (2 * Math.atan(Math.tan((16 * Math.PI) / 180) * (height / width)) * 180) / Math.PI : 32;
    this.perspective.updateProjectionMatrix();
    const tall = HALF_HEIGHT * Math.max(1, height / width), wide = (tall * width) / height;
    Object.assign(this.orthographic, { left: -wide, right: wide, top: tall, bottom: -tall });
    this.orthographic.updateProjectionMatrix();
    this.onsize();
    this.draw();
  }

  /** @param {boolean} isDark */
  theme(isDark) {
    const { back, line, shadow, strength, sky, floor, fill, key } = THEMES[isDark ? 'dark' : 'light'];
    this.scene.background = new Color(back);
    this.#ground.theme(line, shadow, strength);
    this.#fill.color.set(sky);
    this.#fill.groundColor.set(floor);
    this.#fill.intensity = fill;
    this.#key.intensity = key;
  }

  /**
   * Returns what is seen as a PNG.
   *
   * @returns {Promise<Blob>}
   */
  picture() {
    this.draw(); // in this task, because the browser clears the buffer after it shows a picture
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('the canvas has no picture'))), 'image/png');
    });
  }
}
