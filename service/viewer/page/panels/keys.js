import { SIDE_NAMES } from '../takes.js';
import { BODIES, CROWDS, LAYOUTS, VIEWS } from './choices.js';
import { toggleSide } from './compared.js';

/** @import { Own } from '../figure/own.js' */
/** @import { Player } from '../player.js' */
/** @import { State, Values } from '../state.js' */
/** @import { PARTS } from '../takes.js' */
/** @import { Lists } from './lists.js' */
/** @import { TakeAway } from './take_away.js' */

/**
 * What the keys act on.
 *
 * @typedef {{ state: State, player: Player, lists: Lists, takeAway: TakeAway, help: { toggle(): void }, own: Own }} Parts
 */

/**
 * @typedef {object} Binding
 * @property {string} group
 * @property {string[]} keys as `KeyboardEvent.key` names them, with `Shift+` before names longer than one character
 * @property {string} does
 * @property {(parts: Parts, key: string) => void} [run] without it, the page handles the key elsewhere, and the table only lists it
 */

/** @type {Binding[]} */
export const BINDINGS = [
  bind('Play', ['Space'], 'Play or pause', ({ player }) => player.toggle()),
  bind('Play', ['ArrowLeft', 'ArrowRight'], 'One frame back or ahead', ({ player }, key) => player.step(key === 'ArrowLeft' ? -1 : 1)),
  bind('Play', ['Shift+ArrowLeft', 'Shift+ArrowRight'], 'Ten frames back or ahead',
    ({ player }, key) => player.step(key.endsWith('Left') ? -10 : 10)),
  bind('Play', ['Home', 'End'], 'First or last frame of the range', ({ player }, key) => player.seek(player.range[key === 'Home' ? 0 : 1])),
  bind('Play', ['j'], 'Play backwards; again: faster', (parts) => shuttle(parts, -1)),
  bind('Play', ['k'], 'Pause', ({ player, state }) => { if (state.values.playing) player.toggle(); }),
  bind('Play', ['l'], 'Play; again: faster', (parts) => shuttle(parts, 1)),
  bind('Play', ['[', ']'], 'Repeat from here, or to here', ({ player, state }, key) => range(player, state, key)),
  bind('Play', ['\\'], 'Repeat everything', ({ state }) => state.set({ from: 0, to: 0 })),
  bind('Clips', ['ArrowUp', 'ArrowDown'], 'Previous or next clip of the list used last',
    ({ lists }, key) => lists.step(key === 'ArrowUp' ? -1 : 1)),
  bind('Clips', ['/'], 'Search', ({ lists }) => lists.find()),
  bind('Clips', ['Escape'], 'No action; end of a crowd', ({ state }) => state.set(state.values.crowd ? { crowd: 0 } : { action: '' })),
  bind('Clips', ['x'], 'Mirror the action', (parts) => flip(parts, 'mirror')),
  bind('Clips', ['y'], 'Mirror the locomotion', (parts) => flip(parts, 'mirror_locomotion')),
  bind('Clips', ['g'], 'Lock feet', (parts) => flip(parts, 'lock_feet')),
  bind('Clips', ['ContextMenu', 'Shift+F10'], 'Menu of a clip: mix in, compare as truth'),
  bind('Look and aim', ['h'], 'Head', (parts) => flip(parts, 'look')),
  bind('Look and aim', ['a'], 'Chest', (parts) => flip(parts, 'chest')),
  bind('Look and aim', ['q', 'e'], 'Left arm, right arm', (parts, key) => flip(parts, key === 'q' ? 'left_arm' : 'right_arm')),
  bind('Look and aim', ['d'], 'Bring the point to the character', ({ state }) => state.set({ point: '' })),
  bind('Compare', ['1', '2', '3', '4', '5'], 'Splice, naive, locomotion, action, truth',
    ({ state }, key) => toggleSide(state, SIDE_NAMES[Number(key) - 1])),
  bind('Compare', ['b'], 'Beside or over each other', (parts) => next(parts, 'layout', Object.keys(LAYOUTS))),
  bind('View', ['v'], 'Next view: free, front, side, top', (parts) => next(parts, 'view', Object.keys(VIEWS))),
  bind('View', ['f'], 'Follow the character', (parts) => flip(parts, 'follow')),
  bind('View', ['m'], 'Mannequin, stick figure, or your character',
    (parts) => next(parts, 'body', Object.keys(BODIES).filter((body) => body !== 'own' || parts.own.character))),
  bind('View', ['t'], 'Trails of feet and hands', (parts) => flip(parts, 'trails')),
  bind('View', ['p'], 'Path of the root', (parts) => flip(parts, 'path')),
  bind('View', ['c'], 'Contacts of the feet', (parts) => flip(parts, 'contacts')),
  bind('View', ['n'], 'Crowd: none, 1, 10, 100, 1,000', (parts) => next(parts, 'crowd', CROWDS)),
  bind('Export', ['s'], 'Save a picture', ({ takeAway }) => takeAway.savePicture()),
  bind('Export', ['u'], 'Copy the link', ({ takeAway }) => takeAway.copyLink()),
  bind('Export', ['?'], 'These keys', ({ help }) => help.toggle()),
];

/** Runs the bindings, except for keys that the focused element uses itself. */
export class Keys {
  #byPointer = false; // whether the focus was last set by a click

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
    const isAltGr = event.getModifierState('AltGraph'); // types [ on many keyboards
    const isCommand = (event.ctrlKey || event.metaKey || event.altKey) && !isAltGr;
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
 * Returns whether an element uses a key itself. After a click on a button the space bar still plays and pauses, as in other tools
 * with a timeline. After Tab it presses the button.
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
  if (target.matches('input, select, textarea')) return true;
  return target.matches('button, a') && key === 'Space' && !byPointer;
}

/**
 * @param {string} group
 * @param {string[]} keys
 * @param {string} does
 * @param {Binding['run']} [run]
 * @returns {Binding}
 */
function bind(group, keys, does, run) {
  return { group, keys, does, run };
}

/**
 * @param {Parts} parts
 * @param {'follow' | 'trails' | 'path' | 'contacts' | 'mirror' | 'mirror_locomotion' | 'lock_feet' | typeof PARTS[number]} key
 */
function flip({ state }, key) {
  state.set({ [key]: !state.values[key] });
}

/**
 * Sets the value after the current one.
 *
 * @param {Parts} parts
 * @param {keyof Values} key
 * @param {(string | number)[]} values
 */
function next({ state }, key, values) {
  state.set({ [key]: values[(values.findIndex((one) => one === state.values[key]) + 1) % values.length] });
}

/**
 * Plays in a direction. Doubles the speed if it already plays in that direction.
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
