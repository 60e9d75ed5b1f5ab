import { placeOf, widthOf } from './cast.js';
import { Company } from './company.js';
import { Figures } from './figures.js';
import { Load } from './load.js';
import { Panel } from './panel.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { Service } from '../service.js' */
/** @import { Stage } from '../scene/stage.js' */
/** @import { View } from '../scene/view.js' */

const MIDDLE = { x: 0, y: 0.9, z: 0 };
const BETWEEN = 500; // ms from one look at the figures to the next

/** Many characters, live from the service's WebSocket, instead of the splice. */
export class Crowd {
  load = new Load();
  count = 0; // of the characters that are wanted
  /** @type {Figures | undefined} */
  #figures;
  /** @type {[number, number][]} */
  #places = [];
  #coloured = 0;
  #told = 0;

  /**
   * @param {HTMLElement} element for the figures
   * @param {Stage} stage
   * @param {View} view
   * @param {Service} service
   * @param {() => Catalogue} catalogue
   * @param {() => void} onEnd called when the user ends it
   */
  constructor(element, stage, view, service, catalogue, onEnd) {
    this.stage = stage;
    this.view = view;
    this.panel = new Panel(element, onEnd);
    this.company = new Company(service, catalogue);
    this.company.onframes = (bytes) => this.load.message(performance.now(), bytes);
    this.company.onproblem = (problem) => this.panel.fault(problem);
  }

  get isOn() {
    return this.count > 0;
  }

  /** Number of characters that are shown. */
  get shown() {
    return this.#figures?.object.count ?? 0;
  }

  /**
   * Shows so many characters; 0 ends the crowd.
   *
   * @param {number} count
   */
  set(count) {
    if (count === this.count) return;
    if (!this.isOn || !count) this.panel.show(count > 0);
    this.count = count;
    this.#clear();
    this.#places = Array.from({ length: count }, (_, number) => placeOf(number, count));
    const width = widthOf(count);
    this.stage.reach(width);
    this.view.wide(width, width);
    this.load.begin(performance.now());
    this.company.set(count);
  }

  /** Draws a picture. */
  picture() {
    const began = performance.now();
    this.stage.floor = 0;
    this.view.at(MIDDLE, 0);
    this.#pose();
    this.stage.draw();
    const now = performance.now();
    this.load.picture(now, now - began);
    if (now - this.#told < BETWEEN) return;
    this.#told = now;
    this.panel.at({ ...this.load.at(now), characters: this.shown, delay: this.company.connection?.delay });
  }

  #pose() {
    const { connection, members } = this.company;
    let shown = 0;
    for (; shown < Math.min(members.length, this.count); shown++) {
      const pose = connection?.characters.get(shown)?.pose();
      if (!pose) break; // its first frame is yet to come
      if (pose.rig !== this.#figures?.rig) this.#begin(new Figures(pose.rig, this.count));
      this.#figures?.set(shown, pose, members[shown].heading, ...this.#places[shown]);
    }
    if (this.#coloured !== members.length && this.#figures) {
      this.#coloured = members.length;
      this.#figures.colour(members.slice(0, this.count));
    }
    this.#figures?.show(shown);
  }

  /** @param {Figures} figures */
  #begin(figures) {
    this.#clear();
    this.#figures = figures;
    this.stage.add(figures.object);
  }

  #clear() {
    this.#figures?.dispose();
    this.#figures = undefined;
    this.#coloured = 0;
  }
}
