import { toggleSide, SIDE_NAMES } from './compared.js';

/** @import { Player } from '../player.js' */
/** @import { State } from '../state.js' */
/** @import { Lists } from './lists.js' */
/** @import { TakeAway } from './take_away.js' */

/**
 * What the keys act on.
 *
 * @typedef {{ state: State, player: Player, lists: Lists, takeAway: TakeAway, help: { toggle(): void } }} Parts
 */

/**
 * @typedef {object} Binding
 * @property {string} group
 * @property {string[]} keys as `KeyboardEvent.key` names them, with `Shift+` before names that are longer than one letter
 * @property {string} does
 * @property {(parts: Parts, key: string) => void} [run] without it, the key belongs to a part of the page and is only listed
 */

const CROWDS = [0, 1, 10, 100, 1000];
const VIEWS = ['free', 'front', 'side', 'top'];

/** @type {Binding[]} */
export const BINDINGS = [
  { group: 'Play', keys: ['Space'], does: 'Play or pause', run: ({ player }) => player.toggle() },
  { group: 'Play', keys: ['ArrowLeft', 'ArrowRight'], does: 'One frame back or ahead', run: ({ player }, key) => player.step(key === 'ArrowLeft' ? -1 : 1) },
  {
    group: 'Play', keys: ['Shift+ArrowLeft', 'Shift+ArrowRight'], does: 'Ten frames back or ahead',
    run: ({ player }, key) => player.step(key.endsWith('Left') ? -10 : 10),
  },
  { group: 'Play', keys: ['Home', 'End'], does: 'First or last frame of the range', run: ({ player }, key) => player.seek(player.range[key === 'Home' ? 0 : 1]) },
  { group: 'Play', keys: ['j'], does: 'Play backwards; again: faster', run: (parts) => shuttle(parts, -1) },
  { group: 'Play', keys: ['k'], does: 'Pause', run: ({ player, state }) => { if (state.values.playing) player.toggle(); } },
  { group: 'Play', keys: ['l'], does: 'Play; again: faster', run: (parts) => shuttle(parts, 1) },
  { group: 'Play', keys: ['[', ']'], does: 'Repeat from here, or to here', run: ({ player, state }, key) => range(player, state, key) },
  { group: 'Play', keys: ['\\'], does: 'Repeat everything', run: ({ state }) => state.set({ from: 0, to: 0 }) },
  { group: 'Clips', keys: ['ArrowUp', 'ArrowDown'], does: 'Previous or next clip of the list used last', run: ({ lists }, key) => lists.step(key === 'ArrowUp' ? -1 : 1) },
  { group: 'Clips', keys: ['/'], does: 'Search', run: ({ lists }) => lists.find() },
  { group: 'Clips', keys: ['Escape'], does: 'No action; end of a crowd', run: ({ state }) => state.set(state.values.crowd ? { crowd: 0 } : { action: '' }) },
  { group: 'Clips', keys: ['ContextMenu', 'Shift+F10'], does: 'Menu of a clip: mix in, compare as truth' },
  { group: 'Compare', keys: ['1', '2', '3', '4', '5'], does: 'Splice, naive, locomotion, action, truth', run: ({ state }, key) => toggleSide(state, SIDE_NAMES[Number(key) - 1]) },
  { group: 'Compare', keys: ['b'], does: 'Beside or over each other', run: ({ state }) => state.set({ layout: state.values.layout === 'over' ? 'beside' : 'over' }) },
  { group: 'View', keys: ['v'], does: 'Next view: free, front, side, top', run: ({ state }) => state.set({ view: VIEWS[(VIEWS.indexOf(state.values.view) + 1) % VIEWS.length] }) },
  { group: 'View', keys: ['f'], does: 'Follow the character', run: ({ state }) => state.set({ follow: !state.values.follow }) },
  { group: 'View', keys: ['m'], does: 'Mannequin or stick figure', run: ({ state }) => state.set({ body: state.values.body === 'stick' ? 'mannequin' : 'stick' }) },
  { group: 'View', keys: ['t'], does: 'Trails of feet and hands', run: ({ state }) => state.set({ trails: !state.values.trails }) },
  { group: 'View', keys: ['p'], does: 'Path of the root', run: ({ state }) => state.set({ path: !state.values.path }) },
  { group: 'View', keys: ['c'], does: 'Contacts of the feet', run: ({ state }) => state.set({ contacts: !state.values.contacts }) },
  { group: 'View', keys: ['n'], does: 'Crowd: none, 1, 10, 100, 1,000', run: ({ state }) => state.set({ crowd: CROWDS[(CROWDS.indexOf(state.values.crowd) + 1) % CROWDS.length] }) },
  { group: 'Export', keys: ['s'], does: 'Save a picture', run: ({ takeAway }) => takeAway.savePicture() },
  { group: 'Export', keys: ['u'], does: 'Copy the link', run: ({ takeAway }) => takeAway.copyLink() },
  { group: 'Export', keys: ['?'], does: 'These keys', run: ({ help }) => help.toggle() },
];

/** Runs what the table says, unless the key belongs to the element that has the focus. */
export class Keys {
  #byPointer = false; // how the focus came to where it is

  /** @param {Parts} parts */
  constructor(parts) {
    this.parts = parts;
    addEventListener('pointerdown', () => { this.#byPointer = true; }, true);
    addEventListener('keydown', (event) => {
      if (event.key === 'Tab') this.#byPointer = false;
    }, true);
    addEventListener('keydown', (event) => this.#key(event));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const isCommand = (event.ctrlKey || event.metaKey || event.altKey) && !event.getModifierState('AltGraph'); // AltGr types [ on many keyboards
    if (event.defaultPrevented || isCommand) return;
    const key = nameOf(event);
    const target = event.target instanceof Element ? event.target : document.body;
    const open = document.querySelector('dialog[open], :popover-open');
    if ((open && key !== '?') || ownsKey(target, key, this.#byPointer)) return;
    const binding = BINDINGS.find((one) => one.run && one.keys.includes(key));
    if (!binding?.run) return;
    event.preventDefault();
    binding.run(this.parts, key);
  }
}

/** @param {KeyboardEvent} event */
function nameOf({ key, code, shiftKey }) {
  const isOther = !/^[ -~]+$/.test(key) || (/^Digit/.test(code) && !shiftKey); // other alphabets, and French digits: by their place
  const name = key === ' ' ? 'Space' : isOther ? code.replace(/^(Key|Digit)/, '') : key;
  return name.length === 1 ? name.toLowerCase() : `${shiftKey ? 'Shift+' : ''}${name}`;
}

/**
 * Whether an element uses a key itself. A button that was clicked leaves the space bar to the player, as in other tools
 * with a timeline; a button that was reached by Tab does not.
 *
 * @param {Element} target
 * @param {string} key
 * @param {boolean} byPointer
 */
function ownsKey(target, key, byPointer) {
  if (target.matches('input[type=range]')) return /Arrow|Home|End|Page/.test(key);
  if (target.matches('input[type=checkbox], input[type=radio]')) {
    const isRadio = /** @type {HTMLInputElement} */ (target).type === 'radio';
    return !byPointer && (key === 'Space' || (isRadio && key.includes('Arrow')));
  }
  if (target.matches('input, select, textarea, [contenteditable]')) return true;
  return target.matches('button, a, summary') && key === 'Space' && !byPointer;
}

/**
 * Plays in a direction; doubles the speed if it does so already.
 *
 * @param {Parts} parts
 * @param {1 | -1} direction
 */
function shuttle({ state }, direction) {
  const { playing, speed } = state.values;
  const isSame = playing && Math.sign(speed) === direction;
  state.set({ playing: true, speed: isSame ? direction * Math.min(2, 2 * Math.abs(speed)) : direction });
}

/**
 * @param {Player} player
 * @param {State} state
 * @param {string} key
 */
function range(player, state, key) {
  const { time } = player;
  const [from, to] = player.range;
  if (key === '[') state.set({ from: time, to: time < to ? to : 0 });
  else state.set({ from: from < time ? from : 0, to: time });
}
