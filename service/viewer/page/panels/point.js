import { pointOf } from '../takes.js';
import { make } from './dom.js';

/** @import { State } from '../state.js' */
/** @import { Field } from './fields.js' */

/**
 * Returns the three numbers of the point that characters look and aim at.
 *
 * @param {State} state
 * @returns {Field}
 */
export function pointField(state) {
  const inputs = ['X', 'Y', 'Z'].map((axis) => make('input', { type: 'number', step: 0.1, 'aria-label': `Point, ${axis}`, title: `${axis}, metres` }));
  for (const input of inputs) {
    input.addEventListener('input', () => {
      const numbers = inputs.map(({ valueAsNumber }) => valueAsNumber);
      if (numbers.every(Number.isFinite)) state.set({ point: numbers.join(' ') });
    });
  }
  return {
    element: make('div', { class: 'field point', role: 'group', 'aria-label': 'Point' }, make('span', { class: 'label' }, 'Point'), ...inputs),
    sync: () => {
      const point = pointOf(state.values.point);
      inputs.forEach((input, axis) => {
        const text = point ? String(point[axis]) : '';
        if (document.activeElement !== input && input.value !== text) input.value = text;
      });
    },
  };
}
