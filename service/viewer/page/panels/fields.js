import { labelled, make, newId, optionsOf } from './dom.js';

/** @import { Key, State, Values } from '../state.js' */

/**
 * A control for one value of the state. `sync` shows the value of the state.
 *
 * @typedef {{ element: HTMLElement, sync(): void }} Field
 */

/**
 * Returns radio buttons that look like one bar, for few choices.
 *
 * @param {State} state
 * @param {Key} key
 * @param {string} label
 * @param {Record<string, string>} choices label of each value
 * @returns {Field}
 */
export function segments(state, key, label, choices) {
  const name = newId();
  const inputs = Object.entries(choices).map(([value, text]) => {
    const input = make('input', { type: 'radio', name, value });
    input.addEventListener('change', () => state.set({ [key]: typeof state.values[key] === 'number' ? Number(value) : value }));
    return { input, element: make('label', {}, input, make('span', {}, text)) };
  });
  const element = make('div', { class: 'field', role: 'radiogroup', 'aria-label': label },
    make('span', { class: 'label' }, label), make('div', { class: 'segments' }, ...inputs.map((one) => one.element)));
  return { element, sync: () => inputs.forEach(({ input }) => { input.checked = input.value === String(state.values[key]); }) };
}

/**
 * Returns a menu, for many choices.
 *
 * @param {State} state
 * @param {Key} key
 * @param {string} label
 * @param {Record<string, string> | (() => Record<string, string>)} choices label of each value; a function, if they change
 * @param {string} [title]
 * @returns {Field}
 */
export function select(state, key, label, choices, title) {
  const input = make('select', { title });
  let shown = '';
  input.addEventListener('change', () => state.set({ [key]: input.value }));
  const sync = () => {
    const offered = Object.entries(typeof choices === 'function' ? choices() : choices);
    const value = String(state.values[key]);
    if (!offered.some(([one]) => one === value)) offered.push([value, `${value} (unknown)`]);
    const text = JSON.stringify(offered);
    if (text !== shown) input.replaceChildren(...optionsOf(offered));
    shown = text;
    input.value = value;
  };
  return { element: labelled(label, input), sync };
}

/**
 * Returns a slider and a number field. The field takes exact values, also beyond the slider's end.
 *
 * @param {State} state
 * @param {Key} key
 * @param {string} label
 * @param {{ unit: string, step: number, most: number | (() => number), limit?: number, scale?: number, title?: string }} how
 *   `scale`: the number shown for a value of 1
 * @returns {Field}
 */
export function number(state, key, label, { unit, step, most, limit, scale = 1, title }) {
  const id = newId();
  const slider = make('input', { type: 'range', min: 0, step, 'aria-label': `${label}, slider`, title });
  const field = make('input', { type: 'number', min: 0, step, max: limit, id, title });
  /** @param {HTMLInputElement} input */
  const put = (input) => {
    const value = input.valueAsNumber;
    if (Number.isFinite(value) && value >= 0) state.set({ [key]: Math.min(value, limit ?? Infinity) / scale });
  };
  slider.addEventListener('input', () => put(slider));
  field.addEventListener('input', () => put(field));
  const sync = () => {
    const value = Number((Number(state.values[key]) * scale).toFixed(4));
    slider.max = String(typeof most === 'function' ? most() : most);
    slider.value = String(value);
    slider.ariaValueText = `${value} ${unit}`;
    if (document.activeElement !== field || field.valueAsNumber !== value) field.value = String(value);
  };
  field.addEventListener('blur', sync); // replaces invalid text by the value
  return {
    element: make('div', { class: 'field number' }, make('label', { for: id, class: 'label' }, label), slider,
      make('span', { class: 'value' }, field, make('span', { class: 'unit', 'aria-hidden': 'true' }, unit))),
    sync,
  };
}

/**
 * Returns a checkbox.
 *
 * @param {State} state
 * @param {Key} key
 * @param {string} label
 * @param {string} [title]
 * @returns {Field}
 */
export function toggle(state, key, label, title) {
  const input = make('input', { type: 'checkbox' });
  input.addEventListener('change', () => state.set({ [key]: input.checked }));
  return {
    element: make('label', { class: 'toggle', title }, input, make('span', {}, label)),
    sync: () => { input.checked = Boolean(state.values[key]); },
  };
}

/**
 * Returns fields side by side.
 *
 * @param {...Field} fields
 * @returns {Field}
 */
export function row(...fields) {
  return {
    element: make('div', { class: 'row' }, ...fields.map((field) => field.element)),
    sync: () => fields.forEach((field) => field.sync()),
  };
}

/**
 * Returns a field that is hidden while it has no effect.
 *
 * @param {Field} field
 * @param {() => boolean} isShown
 * @returns {Field}
 */
export function shownIf(field, isShown) {
  return {
    element: field.element,
    sync: () => {
      field.element.hidden = !isShown();
      field.sync();
    },
  };
}

/**
 * Returns a line of text that depends on the state and is hidden while it is empty.
 *
 * @param {State} state
 * @param {(values: Values) => string} text
 * @returns {Field}
 */
export function hint(state, text) {
  const element = make('p', { class: 'hint' });
  return {
    element,
    sync: () => {
      const line = text(state.values);
      if (element.textContent !== line) element.textContent = line;
      element.hidden = !line;
    },
  };
}
