import { button, make } from './dom.js';
import { BINDINGS } from './keys.js';

/** @type {Record<string, string>} */
const SYMBOLS = { ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓', ContextMenu: 'Menu', Escape: 'Esc' };
const MOUSE = [
  ['Drag', 'Orbit'],
  ['Right drag, or Shift and drag', 'Pan'],
  ['Wheel', 'Zoom'],
  ['Drag on the timeline', 'Seek'],
  ['Shift and drag on the ruler', 'Range that repeats'],
  ['Right click on a clip', 'Mix in, compare as truth'],
];

/** The dialog that lists all keys. It uses the same table as the key handler. */
export class Help {
  /** @param {HTMLDialogElement} dialog */
  constructor(dialog) {
    this.dialog = dialog;
    const groups = [...new Set(BINDINGS.map((one) => one.group))];
    dialog.replaceChildren(
      make('header', {}, make('h2', { id: 'help-title' }, 'Keys'), button('Close', () => dialog.close())),
      make('div', { class: 'keys' },
        ...groups.map((group) => section(group, BINDINGS.filter((one) => one.group === group)
          .map(({ keys, does }) => line(keys.map((key) => make('kbd', {}, shown(key))), does)))),
        section('Mouse', MOUSE.map(([what, does]) => line([what], does)))),
    );
    dialog.addEventListener('click', (event) => {
      if (event.target === dialog) dialog.close(); // the backdrop
    });
  }

  toggle() {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }
}

/**
 * @param {string} title
 * @param {HTMLElement[]} lines
 */
function section(title, lines) {
  return make('section', { class: title.toLowerCase() }, make('h3', {}, title), make('dl', {}, ...lines));
}

/**
 * @param {(Node | string)[]} keys
 * @param {string} does
 */
function line(keys, does) {
  return make('div', {}, make('dt', {}, ...keys), make('dd', {}, does));
}

/** @param {string} key */
function shown(key) {
  const parts = key.split('+').map((part) => SYMBOLS[part] ?? (part.length === 1 ? part.toUpperCase() : part));
  return parts.join(' ');
}
