import { contactsOf, differencesOf, mismatchesOf } from './facts.js';
import { byId } from './panels/dom.js';
import { VIEWS } from './panels/choices.js';
import { Readout } from './readout.js';
import { Show } from './show.js';
import { Stage } from './scene/stage.js';
import { View } from './scene/view.js';
import { PARTS, pointOf } from './takes.js';
import { Curves } from './timeline/curves.js';
import { Grid } from './timeline/grid.js';
import { Timeline } from './timeline/timeline.js';
import { Transport } from './timeline/transport.js';

/** @import { Crowd } from './crowd/crowd.js' */
/** @import { Player } from './player.js' */
/** @import { ViewName } from './scene/view.js' */
/** @import { Target } from './target/target.js' */
/** @import { Side, Sides } from './sides.js' */
/** @import { Key, State } from './state.js' */

const DRAWN = 250; // ms after which the address follows the state
/** Values that change what the service is asked for. @type {Key[]} */
const ASKED = ['locomotion', 'second', 'share', 'action', 'hands', 'at', 'when', 'start', 'blend', 'weight', 'mask', 'posture', 'mirror', 'mirror_locomotion', 'lock_feet', 'look', 'chest', 'left_arm', 'right_arm', 'steady', 'turned', 'point', 'own', 'once', 'length', 'show', 'truth', 'against', 'body', 'crowd'];
/** Clips: choosing another one ends a crowd. @type {Key[]} */
const CHOSEN = ['locomotion', 'second', 'action', 'hands', 'truth'];

/** The middle of the page: the stage and what lies below it. It shows what the state says. */
export class Viewer {
  /** @type {Side[]} */
  #sides = [];
  #asked = 0; // number of the newest request
  #answered = 0; // of the newest request that was answered
  #before = 0;
  #camera = ''; // of the splice, while there is a crowd
  #chosen = ''; // clips when the crowd began
  #isStale = true; // whether the picture is to be drawn again
  #replaced = ''; // a locomotion that the bank does not have: the baseline is shown instead
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #address;

  /**
   * @param {State} state
   * @param {Player} player
   * @param {Sides} sides
   * @param {(error: unknown) => void} onError
   * @param {(joints: string[]) => void} onJoints
   */
  constructor(state, player, sides, onError, onJoints) {
    this.state = state;
    this.player = player;
    this.sides = sides;
    this.onError = onError;
    this.onJoints = onJoints;
    this.stage = new Stage(/** @type {HTMLCanvasElement} */ (byId('stage')));
    this.view = new View(this.stage);
    this.show = new Show(this.stage, this.view, sides);
    this.readout = new Readout(byId('readout'));
    this.transport = new Transport(byId('transport'), player, state);
    this.timeline = new Timeline(byId('timeline'), player);
    this.curves = new Curves(byId('curves'), player);
    this.grid = new Grid(byId('grid'), player);
    /** Loaded when it is asked for. @type {Crowd | undefined} */
    this.crowd = undefined;
    /** Likewise. @type {Target | undefined} */
    this.target = undefined;
    this.#look(new Set(['view', 'follow']));
    if (state.values.camera) this.view.text = state.values.camera;
    this.view.onchange = () => { this.#isStale = true; };
    this.view.onend = () => state.set({ camera: this.view.text });
    const dark = matchMedia('(prefers-color-scheme: dark)');
    const theme = () => { this.stage.theme(dark.matches); this.#isStale = true; };
    dark.addEventListener('change', theme);
    theme();
    state.on((changed) => this.#changed(changed));
    requestAnimationFrame((now) => this.#picture(now));
  }

  /** The sides that are shown. */
  get shown() {
    return this.#sides;
  }

  /** Whether the picture shows what the state says. */
  get isSettled() {
    return this.#answered === this.#asked && !this.#isStale && !this.target?.isMoved;
  }

  /** Asks for what the state says, and shows it. */
  async refresh() {
    const number = ++this.#asked;
    const { locomotion } = this.state.values;
    const { clips, baseline } = this.sides.catalogue;
    if (!clips.has(locomotion)) {
      this.#replaced = locomotion;
      this.state.set({ locomotion: baseline });
    }
    if (await this.#gather()) {
      this.#answered = number;
      return;
    }
    try {
      const found = await this.sides.of(this.state.values);
      if (number === this.#asked) {
        this.#take(found);
        await this.#point();
      }
      const mismatches = await this.#mismatches();
      if (mismatches && number === this.#asked) this.timeline.add({ mismatches });
      const { say } = await import('./expected.js');
      await say(this.readout.expected, this.sides, this.state.values, () => number === this.#asked);
    } catch (error) {
      if (number === this.#asked) this.onError(error);
    } finally {
      if (number === this.#asked) this.#answered = number;
    }
  }

  /** The clips that are chosen, as text. */
  get #choice() {
    return JSON.stringify(CHOSEN.map((key) => this.state.values[key]));
  }

  /** Shows the crowd if the state asks for one, and else ends it. Returns whether there is one. */
  async #gather() {
    const { state, view } = this;
    if (!(state.values.crowd > 0) && !this.crowd) return false;
    const crowd = this.crowd ?? await this.#crowd();
    const count = Math.max(0, Math.floor(state.values.crowd));
    const isNew = !crowd.isOn && count > 0, isOver = crowd.isOn && !count;
    document.body.classList.toggle('crowd', count > 0);
    crowd.set(count);
    if (isNew) this.show.sides([], state.values);
    if (isNew) this.target?.at([], state.values);
    if (isNew && this.#sides.length) { // else the camera of the address is the crowd's
      this.#camera = state.values.camera;
      state.set({ camera: '' });
      view.home();
    }
    if (isOver) {
      state.set({ camera: this.#camera });
      view.home();
      view.text = this.#camera;
    }
    if (isNew) [this.#sides, this.#chosen] = [[], this.#choice];
    return count > 0;
  }

  async #crowd() {
    const { Crowd } = await import('./crowd/crowd.js');
    const { stage, view, sides, state } = this;
    this.crowd ??= new Crowd(byId('crowd'), stage, view, sides.service, () => sides.catalogue, () => state.set({ crowd: 0 }));
    return this.crowd;
  }

  /** Shows the point that the characters look and aim at, if they do. One without a place is put ahead of them. */
  async #point() {
    const { state, stage, show, player } = this;
    if (!this.#sides.length || !PARTS.some((part) => state.values[part])) return;
    if (!pointOf(state.values.point)) state.set({ point: show.ahead(player.time) });
    const { Target } = await import('./target/target.js');
    this.target ??= new Target(stage, () => { this.#isStale = true; });
    this.target.onmove = (point) => state.set({ point });
    this.#isStale = true;
  }

  /** @param {Side[]} sides */
  #take(sides) {
    this.#sides = sides;
    const [first] = sides;
    const { state, player } = this;
    if (first) player.begin(first.motion.rate, first.motion.duration);
    this.show.sides(sides, state.values);
    this.readout.sides(sides, this.#problem);
    this.onJoints(first?.motion.rig.joints ?? []);
    this.curves.show(sides, state.values.joint);
    this.#describe();
    this.#isStale = true;
  }

  /** Why less is shown than the state asks for; empty if all of it is. */
  get #problem() {
    const { values: { second, action, truth } } = this.state;
    const { clips } = this.sides.catalogue;
    const missing = [this.#replaced, second, action, truth].filter((name) => name && !clips.has(name));
    if (missing.length) return `This bank has no clip ${[...new Set(missing)].map((name) => `"${name}"`).join(', ')}. Choose another.`;
    return this.#sides.length ? '' : 'There is nothing to show. Check a motion under Compare.';
  }

  /** Fills the timeline, but for the mismatches, whose sides come later. */
  #describe() {
    const { values } = this.state;
    const { clips } = this.sides.catalogue;
    const [clip, action] = [clips.get(values.locomotion), clips.get(values.action)];
    const side = this.#sides.find(({ name }) => name === 'splice') ?? this.#sides[0];
    if (!side || !clip) return;
    const other = this.#sides.find(({ name }) => name === values.against && name !== side.name);
    const hasAction = side.actionTimes.some((time) => !Number.isNaN(time));
    this.timeline.show({
      duration: side.motion.duration, rate: side.motion.rate, phases: side.phases, events: side.events, contacts: contactsOf(side, clip, values),
      actionTimes: hasAction ? side.actionTimes : undefined, actionDuration: action?.duration, stands: action?.stands,
      differences: other && differencesOf(side, other), colours: { action: side.colour, difference: other?.colour },
      names: { action: values.action, difference: other && `To ${other.label.toLowerCase()}` },
    });
  }

  /** Computes how well the legs fit at each frame, and fills the grid, if the splice is shown and its action follows the legs. */
  async #mismatches() {
    const { values } = this.state;
    const splice = this.#sides.find(({ name }) => name === 'splice');
    if (!splice) return undefined;
    if (this.sides.catalogue.clips.get(values.action)?.stands) {
      this.grid.clear('The action was captured standing: it plays at its own speed, whatever the legs do');
      return undefined;
    }
    const [locomotion, action] = await Promise.all([this.sides.side('locomotion', values), this.sides.side('action', values)]);
    if (!locomotion || !action) return undefined;
    this.grid.show(locomotion, action, splice.actionTimes);
    return mismatchesOf(locomotion, action, splice.actionTimes);
  }

  /** @param {Set<Key>} changed */
  #changed(changed) {
    this.#isStale = true;
    this.#look(changed);
    if (changed.has('locomotion') && this.state.values.locomotion !== this.sides.catalogue.baseline) this.#replaced = '';
    if (this.crowd?.isOn && !changed.has('crowd') && this.#chosen !== this.#choice) this.state.set({ crowd: 0 });
    else if (ASKED.some((key) => changed.has(key))) void this.refresh();
    if (changed.has('joint')) this.curves.show(this.#sides, this.state.values.joint);
    clearTimeout(this.#address);
    this.#address = setTimeout(() => history.replaceState(null, '', `?${this.state.query}`), DRAWN);
  }

  /** @param {Set<Key>} changed */
  #look(changed) {
    const { view, follow } = this.state.values;
    if (changed.has('view') && Object.hasOwn(VIEWS, view)) this.view.set(/** @type {ViewName} */ (view));
    if (changed.has('follow')) this.view.follow(follow);
    if (changed.has('camera') && !this.state.values.camera) this.view.home();
  }

  /** @param {number} now milliseconds */
  #picture(now) {
    requestAnimationFrame((next) => this.#picture(next));
    const passed = Math.min(0.25, (now - this.#before) / 1000); // a page that was hidden goes on where it was
    this.#before = now;
    const { state, player } = this;
    if (this.crowd?.isOn) {
      this.#isStale = false;
      this.crowd.picture();
      return;
    }
    if (this.#answered === this.#asked) this.target?.tell(); // so that one request waits, however fast it is dragged
    if (!state.values.playing && !this.#isStale) return;
    this.#isStale = false;
    const time = player.advance(passed);
    const apart = this.show.at(time, state.values);
    this.target?.at(this.show.aiming(state.values), state.values);
    this.stage.draw();
    for (const part of [this.transport, this.timeline, this.curves, this.grid]) part.at(time);
    this.readout.at(apart);
  }
}
