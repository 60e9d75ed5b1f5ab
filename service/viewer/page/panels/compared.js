import { SIDES, takeOf } from '../takes.js';
import { make } from './dom.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { State } from '../state.js' */
/** @import { SideName } from '../takes.js' */
/** @import { Field } from './fields.js' */

export const SIDE_NAMES = /** @type {SideName[]} */ (Object.keys(SIDES));

const MISSING = { splice: 'no action', naive: 'no action', locomotion: '', action: 'no action', truth: 'no clip' };

/**
 * Shows a side, or hides it. The order of the sides stays.
 *
 * @param {State} state
 * @param {SideName} side
 */
export function toggleSide(state, side) {
  const shown = new Set(state.values.show.split(','));
  if (!shown.delete(side)) shown.add(side);
  state.set({ show: SIDE_NAMES.filter((name) => shown.has(name)).join(',') });
}

/**
 * Returns the checkboxes of all sides, each with its colour, its key, and the reason if it has nothing to show.
 *
 * @param {State} state
 * @param {() => Catalogue} catalogue
 * @returns {Field}
 */
export function sidesField(state, catalogue) {
  const rows = SIDE_NAMES.map((side, number) => {
    const input = make('input', { type: 'checkbox' });
    input.addEventListener('change', () => toggleSide(state, side));
    const swatch = make('span', { class: 'swatch', 'aria-hidden': 'true' });
    swatch.style.background = SIDES[side].colour;
    const why = make('span', { class: 'why' });
    const key = make('kbd', { 'aria-hidden': 'true' }, String(number + 1));
    const label = make('span', {}, SIDES[side].label);
    return { side, input, why, element: make('label', { class: 'toggle side' }, input, swatch, label, why, key) };
  });
  return {
    element: make('div', { class: 'sides', role: 'group', 'aria-label': 'Motions that are shown' }, ...rows.map((one) => one.element)),
    sync: () => {
      const shown = state.values.show.split(',');
      for (const { side, input, why } of rows) {
        input.checked = shown.includes(side);
        why.textContent = takeOf(side, state.values, catalogue()) ? '' : MISSING[side];
      }
    },
  };
}
