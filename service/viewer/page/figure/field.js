import { button, make } from '../panels/dom.js';
import { takeFiles } from '../panels/drops.js';

/** @import { Field } from '../panels/fields.js' */
/** @import { Own } from './own.js' */

const PLACE = 'A GLB or VRM, here or dropped on the picture. It stays on this machine: only its skeleton is sent.';
const SUFFIX = /\.(glb|vrm)$/i;

/**
 * The button that chooses the user's character, and what is said of it.
 *
 * @param {Own} own
 * @returns {Field}
 */
export function characterField(own) {
  const input = make('input', { type: 'file', accept: '.glb,.vrm,model/gltf-binary', hidden: true, 'aria-label': 'File of your character' });
  const choose = button('Choose a file…', () => input.click(), { class: 'choose' });
  const remove = button('Remove', () => {
    own.remove();
    choose.focus();
  });
  const status = make('p', { class: 'hint', role: 'status' });
  input.addEventListener('change', () => {
    const [file] = input.files ?? [];
    input.value = ''; // so that the same file can be chosen again
    if (file) void own.choose(file);
  });
  const sync = () => {
    const { character } = own;
    choose.textContent = character ? character.name : 'Choose a file…';
    choose.title = character ? `${character.name}. Choose another GLB or VRM file` : '';
    remove.hidden = !character;
    const text = own.status || (character ? '' : PLACE);
    if (status.textContent !== text) status.textContent = text;
    status.hidden = !text;
    status.classList.toggle('warning', own.isFault);
  };
  own.onchange = sync;
  const element = make('div', { class: 'character', role: 'group', 'aria-label': 'Your character' },
    make('span', { class: 'label' }, 'Your own'), choose, remove, input, status);
  return { element, sync };
}

/**
 * Lets a character be dropped on an element. Of another file it is said that it is none.
 *
 * @param {HTMLElement} element
 * @param {Own} own
 */
export function takeDrops(element, own) {
  takeFiles(element, (files) => {
    const file = files.find(({ name }) => SUFFIX.test(name)) ?? files[0];
    if (file) void own.choose(file);
  });
}
