import { Catalogue } from './catalogue.js';
import { isRefused, messageOf } from './errors.js';
import { takeDrops } from './figure/field.js';
import { Own } from './figure/own.js';
import { Aim } from './panels/aim.js';
import { Columns } from './panels/columns.js';
import { Connection } from './panels/connection.js';
import { Controls } from './panels/controls.js';
import { byId } from './panels/dom.js';
import { askForToken, withToken } from './panels/entry.js';
import { Help } from './panels/help.js';
import { Keys } from './panels/keys.js';
import { Lists } from './panels/lists.js';
import { TakeAway } from './panels/take_away.js';
import { Title } from './panels/title.js';
import { Player } from './player.js';
import { Service } from './service.js';
import { Sides } from './sides.js';
import { State } from './state.js';
import { Viewer } from './viewer.js';

/** @import { Adding } from './adding/panel.js' */
/** @import { Warming } from './warming.js' */

const service = new Service();
const state = new State(new URLSearchParams(location.search));
if (matchMedia('(prefers-reduced-motion: reduce)').matches) state.set({ playing: false });
const player = new Player(state);
const catalogue = await withToken(service, () => Catalogue.load(service))
  .catch((error) => giveUp(`${error.message}. Load the page again when the service runs.`, error));
if (!location.search) state.set({ action: [...catalogue.clips.values()].find(({ kind }) => kind === 'action')?.name ?? '' });

const sides = new Sides(service, catalogue);
const lists = new Lists(byId('lists'), catalogue, state);
const own = new Own(service, state, sides);
const controls = new Controls(byId('controls'), catalogue, state, own);
const title = new Title(byId('bank'), catalogue, state);
const help = new Help(/** @type {HTMLDialogElement} */ (byId('help')));
byId('show-help').addEventListener('click', () => help.toggle());
new Columns();
new Aim(byId('lists'), (key, name) => {
  if (!state.values.crowd) sides.of({ ...state.values, [key]: name }).catch(() => {}); // a click tries again, and says why
});

const viewer = begin();
own.refresh = () => void viewer.refresh();
own.onfault = (/** @type {string} */ problem) => viewer.readout.fault(problem); // the controls may be folded away
takeDrops(byId('view'), own);
const takeAway = new TakeAway(byId('take-away'), service, state, sides, viewer.stage, player);
new Keys({ state, player, lists, takeAway, help, own });
const connection = new Connection(byId('banner'), service, catalogue, reload);
/** @type {Promise<Adding> | undefined} */
let adding;
/** @type {Promise<Warming> | undefined} */
let warming;
void viewer.refresh().then(offerUploads); // after the first picture
for (const event of ['dragover', 'drop']) addEventListener(event, (one) => one.preventDefault()); // else the browser opens the file

function begin() {
  try {
    return new Viewer(state, player, sides, failed, (joints) => controls.joints(joints));
  } catch (error) {
    return giveUp('This browser does not offer WebGL 2, so it cannot draw. Turn on its hardware acceleration, or use another browser.', error);
  }
}

/**
 * Says why the page cannot go on.
 *
 * @param {string} problem
 * @param {unknown} error
 * @returns {never}
 */
function giveUp(problem, error) {
  byId('banner').className = 'gone';
  byId('banner').textContent = problem;
  throw error;
}

async function beginAdding() {
  const { Adding } = await import('./adding/panel.js');
  const places = { element: byId('adding'), column: byId('lists-column'), dialog: /** @type {HTMLDialogElement} */ (byId('adding-dialog')) };
  return new Adding(places, service, sides.catalogue, { reload: () => connection.look(), play });
}

/** Loads what adds clips, where the service allows it. */
function offerUploads() {
  if (sides.catalogue.server.uploads) adding ??= beginAdding();
  void adding?.then((part) => part.reload(sides.catalogue));
}

export { own, player, sides, state, viewer };

/** @param {Catalogue} found */
function reload(found) {
  sides.reload(found);
  for (const part of [lists, controls, title]) part.reload(found);
  offerUploads();
  void viewer.refresh();
}

/**
 * Plays a clip that was just added.
 *
 * @param {'locomotion' | 'action'} kind
 * @param {string} name
 */
function play(kind, name) {
  player.seek(0);
  state.set({ [kind]: name, playing: true, from: 0, to: 0 });
}

/** @param {unknown} error */
function failed(error) {
  if (connection.notice(error)) return;
  if (isRefused(error, 'token')) void askForToken(service).then(() => viewer.refresh());
  else if (isRefused(error, 'not-ready')) {
    const then = { say: (/** @type {string} */ text) => viewer.readout.fault(text), ready: () => void viewer.refresh(), failed };
    warming ??= import('./warming.js').then(({ Warming }) => new Warming(service, then));
    void warming.then((one) => one.wait(error));
  }
  else viewer.readout.fault(messageOf(error));
}
