import { messageOf } from '../errors.js';
import { SIDES, SIDE_NAMES, takeOf } from '../takes.js';
import { button, byId, labelled, make, optionsOf } from './dom.js';
import { curlLine, fileName, pythonLines } from './recipes.js';
import { Recorder } from './recorder.js';

/** @import { Player } from '../player.js' */
/** @import { Sides } from '../sides.js' */
/** @import { Service } from '../service.js' */
/** @import { State } from '../state.js' */
/** @import { SideName, Take } from '../takes.js' */

const NOTICE = 3000; // ms for which a report stays over the stage
const FORMATS = { bvh: 'BVH', glb: 'GLB', gltf: 'glTF', vrma: 'VRMA' };

/** The export panel: motion files, pictures, a link, and code that gives the same motion. */
export class TakeAway {
  /** @type {Recorder | undefined} */
  #recorder;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {HTMLElement} element
   * @param {Service} service
   * @param {State} state
   * @param {Sides} sides
   * @param {{ picture(): Promise<Blob>, canvas: HTMLCanvasElement }} stage
   * @param {Player} player
   */
  constructor(element, service, state, sides, stage, player) {
    this.element = element;
    this.service = service;
    this.state = state;
    this.sides = sides;
    this.stage = stage;
    this.player = player;
    this.side = make('select');
    this.status = make('p', { role: 'status', class: 'status' });
    this.text = make('textarea', { readonly: true, rows: 6, 'aria-label': 'Text to copy', hidden: true, spellcheck: 'false' });
    this.own = button('GLB of your character', () => this.#saveCharacter());
    this.video = button('WebM of the range', () => this.#record());
    this.video.hidden = !Recorder.isPossible;
    element.replaceChildren(
      make('h2', {}, 'Motion'),
      labelled('Of', this.side),
      make('div', { class: 'buttons' }, ...Object.entries(FORMATS).map(([format, label]) => button(label, () => this.#saveMotion(format))), this.own),
      make('h2', {}, 'Picture'),
      make('div', { class: 'buttons' }, button('PNG', () => this.savePicture()), this.video),
      make('h2', {}, 'Copy'),
      make('div', { class: 'buttons' }, button('Link', () => this.copyLink()),
        button('curl', () => this.#copyRecipe('curl')), button('Python', () => this.#copyRecipe('Python'))),
      this.text, this.status,
    );
    state.on(() => this.#offer());
    element.addEventListener('toggle', (event) => {
      if (/** @type {ToggleEvent} */ (event).newState === 'closed') return;
      this.#offer();
      this.status.textContent = '';
      this.text.hidden = true;
    });
    this.#offer();
  }

  /** Saves what is seen as a PNG. */
  async savePicture() {
    await this.#trying('Drawing ...', async () => this.#save(await this.stage.picture(), 'png'));
  }

  /** Copies a link that shows the same. */
  async copyLink() {
    const link = new URL(location.href);
    link.search = this.state.query.toString();
    link.searchParams.set('time', this.player.time.toFixed(4));
    link.searchParams.set('playing', 'false'); // the link opens at this moment
    await this.#copy('The link', link.href);
  }

  /** @param {string} format */
  async #saveMotion(format) {
    const take = this.#take;
    if (!take) return;
    await this.#trying('Waiting for the service ...', async () => {
      const answer = await this.service.request(`/v1/take?format=${format}`, {
        method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(take),
      });
      this.#save(await answer.blob(), format);
    });
  }

  /** Saves the user's own file with the motion. */
  async #saveCharacter() {
    const { character } = this.sides;
    if (!character) return;
    await this.#trying('Waiting for the service ...', async () => {
      const side = await this.sides.side(/** @type {SideName} */ (this.side.value), this.state.values, character);
      if (!side?.nodes) return;
      const suffix = character.name.toLowerCase().endsWith('.vrm') ? 'vrm' : 'glb';
      this.#save(new Blob([character.animated(side.nodes, fileName(side.take))]), suffix);
    });
  }

  /** @param {'curl' | 'Python'} kind */
  async #copyRecipe(kind) {
    const take = this.#take;
    if (!take) return;
    const { service, sides } = this;
    const text = kind === 'curl'
      ? curlLine(service.url, take, 'bvh', service.token !== undefined)
      : pythonLines(take, sides.catalogue.server.bank);
    await this.#copy(kind === 'curl' ? 'The curl line' : 'The Python lines', text);
  }

  async #record() {
    if (this.#recorder) {
      this.#recorder.stop();
      return;
    }
    this.#recorder = new Recorder(this.stage.canvas, this.player, this.state);
    this.video.textContent = 'Stop recording';
    await this.#trying('Recording ...', async () => {
      const video = await this.#recorder?.record((share) => this.#say(`Recording ... ${Math.round(100 * share)} %`));
      if (video) this.#save(video, 'webm');
    });
    this.#recorder = undefined;
    this.video.textContent = 'WebM of the range';
  }

  /** The take of the chosen side. @returns {Take | undefined} */
  get #take() {
    return takeOf(/** @type {SideName} */ (this.side.value), this.state.values, this.sides.catalogue);
  }

  #offer() {
    this.own.hidden = !this.sides.character;
    const before = this.side.value;
    const names = SIDE_NAMES.filter((name) => takeOf(name, this.state.values, this.sides.catalogue));
    if ([...this.side.options].map((one) => one.value).join() === names.join()) return;
    this.side.replaceChildren(...optionsOf(names.map((name) => [name, SIDES[name].label])));
    if (names.some((name) => name === before) && before !== 'locomotion') this.side.value = before;
  }

  /**
   * @param {Blob} data
   * @param {string} suffix
   */
  #save(data, suffix) {
    const take = this.#take;
    const name = `${take ? fileName(take) : 'motionsplice'}.${suffix}`;
    const url = URL.createObjectURL(data);
    make('a', { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
    this.#say(`Saved ${name}, ${size(data.size)}.`);
  }

  /**
   * Copies a text and shows it, in case the browser does not let the page copy.
   *
   * @param {string} what
   * @param {string} text
   */
  async #copy(what, text) {
    this.text.value = text;
    this.text.hidden = false;
    const isCopied = await navigator.clipboard?.writeText(text).then(() => true, () => false) ?? this.#copyOldWay();
    this.#say(isCopied ? `${what} ${what.endsWith('s') ? 'are' : 'is'} on the clipboard.` : 'Copy the text that Export shows.');
  }

  /** Copies the visible text without the clipboard API, which browsers offer only over HTTPS and on localhost. */
  #copyOldWay() {
    this.text.select();
    return document.execCommand('copy');
  }

  /**
   * Reports in the panel if it is open, else for a moment over the stage.
   *
   * @param {string} text
   */
  #say(text) {
    this.status.textContent = text;
    if (this.element.matches(':popover-open')) return;
    const notice = byId('notice');
    notice.textContent = text;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => notice.replaceChildren(), NOTICE);
  }

  /**
   * @param {string} meanwhile
   * @param {() => Promise<void>} work
   */
  async #trying(meanwhile, work) {
    this.#say(meanwhile);
    try {
      await work();
    } catch (error) {
      this.#say(messageOf(error));
    }
  }
}

/** @param {number} bytes */
function size(bytes) {
  return bytes < 1e6 ? `${Math.ceil(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}
