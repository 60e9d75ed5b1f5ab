import { contactsOf } from './facts.js';
import { Body } from './scene/body.js';
import { distances, mean, shares, upperBody, worst } from './scene/differences.js';
import { Path } from './scene/path.js';
import { Traces } from './scene/traces.js';
import { clipOf, isLayered } from './takes.js';
import { Quaternion, Vector3 } from './vendor/three.js';

/** @import { Figure } from './figure/figure.js' */
/** @import { Stage } from './scene/stage.js' */
/** @import { View } from './scene/view.js' */
/** @import { Pose } from './vendor/motionsplice.js' */
/** @import { Side, Sides } from './sides.js' */
/** @import { Values } from './state.js' */

const APART = 1.3; // metres between characters that stand beside each other
const AHEAD = [0.5, 1]; // metres to the left and ahead, where a point is put
const EYES = 0.6; // metres above the hips
const UP = new Vector3(0, 1, 0);

/** One side as it is shown: its body, its traces, and where its joints are. */
class Shown {
  moment = 0;
  /** Its place beside the others. */
  offset = [0, 0, 0];

  /**
   * @param {Side} side
   * @param {Body} body
   * @param {Traces} traces
   */
  constructor(side, body, traces) {
    this.side = side;
    this.body = body;
    this.traces = traces;
    /** The user's character in place of the body. */
    this.figure = side.nodes && side.character?.figure(side.nodes);
    this.ring = this.figure && side.character?.ring(side.colour);
    this.path = new Path(side.motion);
    this.beginning = this.path.at(0);
    this.upperBody = upperBody(side.motion.rig);
    this.pose = side.motion.pose(0);
  }
}

/** The characters on the stage. */
export class Show {
  /** @type {Shown[]} */
  #shown = [];
  #turn = new Quaternion();

  /**
   * @param {Stage} stage
   * @param {View} view
   * @param {Sides} sides
   */
  constructor(stage, view, sides) {
    this.stage = stage;
    this.view = view;
    this.catalogue = () => sides.catalogue;
  }

  /**
   * Shows other sides.
   *
   * @param {Side[]} sides
   * @param {Values} values
   */
  sides(sides, values) {
    const before = this.#shown;
    this.#shown = sides.map((side) => before.find((one) => one.side === side) ?? this.#begin(side, values));
    for (const one of before) {
      if (sides.includes(one.side)) continue;
      this.stage.remove(one.body.object);
      this.stage.remove(one.traces.object);
      for (const own of [one.figure, one.ring]) if (own) this.stage.remove(own.object);
      this.stage.later(() => {
        one.body.dispose();
        one.traces.dispose();
        one.figure?.dispose();
        one.ring?.dispose();
      });
    }
  }

  /**
   * @param {Side} side
   * @param {Values} values
   */
  #begin(side, values) {
    const clip = this.catalogue().clips.get(clipOf(side.name, values));
    const shown = new Shown(side, new Body(side.motion.rig, side.colour), new Traces(side, clip && contactsOf(side, clip, values)));
    this.stage.add(shown.body.object);
    this.stage.add(shown.traces.object);
    for (const own of [shown.figure, shown.ring]) if (own) this.stage.add(own.object);
    return shown;
  }

  /** Where the joints of each side are [J][3], without the place beside the others. */
  positions() {
    return this.#shown.map(({ body }) => body.positions);
  }

  /** The user's character as each side shows it, if it does. */
  figures() {
    return this.#shown.flatMap(({ figure }) => figure ?? []);
  }

  /** What looks and aims. In one place, the first one only. @param {Values} values */
  aiming(values) {
    const found = this.#shown.filter(({ side }) => isLayered(side.name));
    return found.slice(0, values.layout === 'over' ? 1 : undefined).map((one) => ({ body: one.body, offset: one.offset, shrink: shrinkOf(one) }));
  }

  /** Returns a point a little ahead of the character, as a value of the state. @param {number} time */
  ahead(time) {
    const { x, y, z, heading } = this.#shown[0].path.at(time);
    const [left, ahead] = AHEAD, sine = Math.sin(heading), cosine = Math.cos(heading);
    return [x + left * cosine + ahead * sine, y + EYES, z - left * sine + ahead * cosine].map((metres) => metres.toFixed(2)).join(' ');
  }

  /**
   * Poses all characters at a time. Returns how far the first one is from the side that it is compared with.
   *
   * @param {number} time
   * @param {Values} values
   */
  at(time, values) {
    const leading = this.#shown.find(({ side }) => side.name !== 'action' && side.name !== 'truth') ?? this.#shown[0];
    if (!leading) return undefined;
    for (const one of this.#shown) this.#pose(one, momentOf(one.side, leading.side, time));
    this.#shown.forEach((one, index) => this.#place(one, leading, index, values));
    const place = leading.path.at(leading.moment);
    const shrink = shrinkOf(leading);
    for (const axis of /** @type {const} */ (['x', 'y', 'z'])) place[axis] *= shrink;
    this.stage.floor = leading.traces.floor * shrink;
    const apart = values.layout === 'over' ? 0 : (this.#shown.length - 1) * APART;
    this.view.wide(apart);
    this.view.at(place, apart ? leading.beginning.heading : place.heading); // in a turning view one would hide the other
    return this.#compare(values);
  }

  /**
   * @param {Shown} one
   * @param {number} moment
   */
  #pose(one, moment) {
    const pose = one.side.motion.pose(moment);
    if (!pose?.rotations) return;
    one.pose = pose;
    one.moment = moment;
  }

  /**
   * Puts a character beside the others or over them. An action as captured walks elsewhere: its hips are put where those
   * of the leading character are.
   *
   * @param {Shown} one
   * @param {Shown} leading
   * @param {number} index
   * @param {Values} values
   */
  #place(one, leading, index, values) {
    if (!one.pose || !leading.pose) return;
    const shift = values.layout === 'over' ? 0 : (index - (this.#shown.length - 1) / 2) * APART;
    const isSide = values.view === 'side'; // there they go one behind the other: else one would hide the other
    const across = leading.beginning.heading + (isSide ? Math.PI / 2 : 0);
    const offset = one.offset = [shift * Math.cos(across), 0, -shift * Math.sin(across)];
    const isCarried = one.side.name === 'action' && one !== leading;
    const turn = isCarried ? headingOf(leading) - headingOf(one) : 0;
    if (one.figure) this.#figure(one.figure, one, isCarried ? leading : one, turn, offset);
    if (isCarried) this.#carry(one.pose, turn, leading.pose.root);
    one.body.object.visible = !one.figure;
    one.body.style = values.body === 'stick' ? 'stick' : 'mannequin';
    one.body.opacity = values.layout === 'over' && index > 0 ? 0.45 : 1;
    if (one.figure) one.figure.opacity = one.body.opacity;
    one.body.set(one.pose, offset);
    const { trails, path, contacts } = values;
    const own = one.side.name !== 'action' || one === leading;
    one.traces.show({ trails: trails && own, path: path && own, contacts: contacts && own });
    one.traces.offset(offset);
    one.traces.object.scale.setScalar(shrinkOf(one));
    one.traces.at(one.moment);
  }

  /**
   * Shows the user's character as `#place` shows the body.
   *
   * @param {Figure} figure
   * @param {Shown} one
   * @param {Shown} at whose hips it gets
   * @param {number} turn radians
   * @param {number[]} offset
   */
  #figure(figure, one, at, turn, offset) {
    const hips = new Vector3().fromArray(/** @type {Pose} */ (one.pose).root).applyAxisAngle(UP, turn);
    const to = /** @type {Pose} */ (at.pose).root;
    figure.at(one.moment);
    const shrink = shrinkOf(one);
    figure.object.scale.setScalar(shrink);
    figure.place(offset.map((metres, axis) => shrink * (to[axis] - hips.getComponent(axis)) + metres), turn);
    one.ring?.place(shrink * to[0] + offset[0], shrink * one.traces.floor, shrink * to[2] + offset[2]);
  }

  /**
   * Turns a pose about the vertical, and puts its root at a place.
   *
   * @param {Pose} pose
   * @param {number} turn radians
   * @param {ArrayLike<number>} place [3]
   */
  #carry(pose, turn, place) {
    const rotations = /** @type {Float32Array} */ (pose.rotations);
    this.#turn.fromArray(rotations).premultiply(new Quaternion().setFromAxisAngle(UP, turn)).toArray(rotations);
    pose.root.set(place);
  }

  /** @param {Values} values */
  #compare(values) {
    const [first] = this.#shown;
    const other = this.#shown.find(({ side }) => side.name === values.against && side !== first.side);
    for (const one of this.#shown) if (one !== first || !other) one.body.colours(undefined);
    if (!other) return undefined;
    const { rig } = first.side.motion;
    const found = distances(first.body.positions, other.body.positions, rig, 'root');
    first.body.colours(shares(found));
    const { joint, metres } = worst(found, first.upperBody);
    const isColoured = !first.figure; // a character keeps its own colours
    return { label: other.side.label, mean: mean(found, first.upperBody), worst: metres, joint: rig.joints[joint], isColoured };
  }
}

/** @param {Shown} one */
function headingOf({ path, moment }) {
  return path.at(moment).heading;
}

/** @param {Shown} shown */
function shrinkOf({ side }) {
  return side.character?.shrink ?? 1;
}

/**
 * Returns the moment of a side's own motion that is shown at a time. The action as captured is shown at the moment that
 * the splice plays.
 *
 * @param {Side} side
 * @param {Side} leading
 * @param {number} time
 */
function momentOf(side, leading, time) {
  if (side.name !== 'action' || side === leading || !leading.actionTimes.length) return time;
  const place = Math.max(0, Math.min(leading.actionTimes.length - 1, time * leading.motion.rate));
  const before = leading.actionTimes[Math.floor(place)];
  const after = leading.actionTimes[Math.ceil(place)];
  if (Number.isNaN(before)) return 0;
  return after >= before ? before + (after - before) * (place % 1) : before; // a loop jumps back
}
