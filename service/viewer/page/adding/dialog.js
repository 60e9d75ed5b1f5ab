import { button, labelled, make, optionsOf } from '../panels/dom.js';
import { faultOf, NAME, nameFor, ordered, parts, SKELETON } from './files.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { Wanted } from './queue.js' */

const KINDS = { locomotion: 'Locomotion', action: 'Action' };

/** @typedef {{ element: HTMLElement, wanted: () => Wanted, name?: HTMLInputElement, kind?: HTMLSelectElement }} Row */

/** Asks for the name, kind and tags of each file. */
export class AddDialog {
  #kind = 'locomotion'; // as chosen the last time

  /** @param {HTMLDialogElement} dialog */
  constructor(dialog) {
    this.dialog = dialog;
  }

  /**
   * @param {File[]} files
   * @param {Catalogue} catalogue
   * @param {(wanted: Wanted[]) => void} onAdd
   */
  open(files, catalogue, onAdd) {
    const limit = catalogue.server.limits.max_upload;
    const all = ordered(files).map((file) => ({ file, fault: faultOf(file, limit) }));
    const rows = all.filter(({ fault }) => !fault).map(({ file }) => this.#row(file, catalogue));
    const refused = all.filter(({ fault }) => fault);
    const motions = rows.filter((row) => row.kind);
    const form = make('form', { method: 'dialog' },
      make('h2', { id: 'adding-title' }, 'Add clips'),
      ...(motions.length > 1 ? [this.#forAll(motions)] : []),
      make('div', { class: 'files' }, ...rows.map(({ element }) => element), ...refused.map(({ file, fault }) => make('div', { class: 'file' },
        make('strong', { class: 'name' }, file.name), make('p', { class: 'warning' }, `⚠ ${fault}`)))),
      make('p', { class: 'hint' }, 'The service checks each file, aligns it to the bank, and serves the new bank to everyone.'),
      make('div', { class: 'buttons' }, button(rows.length ? 'Cancel' : 'Close', () => this.dialog.close()),
        ...(rows.length ? [make('button', { class: 'primary' }, motions.length > 1 ? `Add ${motions.length} clips` : 'Add')] : [])));
    form.addEventListener('submit', () => {
      onAdd(rows.map((row) => row.wanted()));
      this.#kind = motions[0]?.kind?.value ?? this.#kind;
    });
    const check = () => unique(rows);
    form.addEventListener('input', check);
    check();
    this.dialog.replaceChildren(form);
    this.dialog.showModal();
    (motions[0]?.kind ?? form.querySelector('button'))?.focus();
  }

  /**
   * @param {File} file
   * @param {Catalogue} catalogue
   * @returns {Row}
   */
  #row(file, { clips }) {
    const { stem, suffix } = parts(file.name);
    if (suffix === SKELETON) {
      const name = NAME.test(stem) ? stem : nameFor(file.name);
      return {
        element: make('div', { class: 'file' }, make('strong', { class: 'name' }, name + suffix), make('p', { class: 'hint' }, 'Skeleton of .amc files')),
        wanted: () => ({ file, name, suffix, kind: 'locomotion', tags: '' }),
      };
    }
    const name = make('input', { value: nameFor(file.name), required: true, maxlength: 100, pattern: NAME.source.slice(1, -1), title: 'Letters, digits, _, + and -' });
    const kind = select(KINDS);
    const tags = make('input', { placeholder: 'comma-separated' });
    const note = make('p', { class: 'hint' });
    const known = () => {
      const clip = clips.get(name.value);
      note.textContent = clip ? `Replaces the clip ${name.value}, for everyone.` : '';
      return clip;
    };
    const before = known();
    kind.value = before?.kind ?? this.#kind;
    tags.value = before?.tags.join(', ') ?? '';
    name.addEventListener('input', known);
    return {
      element: make('div', { class: 'file' }, make('p', { class: 'hint' }, file.name), labelled('Name', name), labelled('Kind', kind), labelled('Tags', tags), note),
      name, kind,
      wanted: () => ({ file, name: name.value, suffix, kind: kind.value === 'action' ? 'action' : 'locomotion', tags: tags.value.trim() }),
    };
  }

  /** @param {Row[]} rows */
  #forAll(rows) {
    const all = select({ '': 'Each its own', ...KINDS });
    all.addEventListener('change', () => {
      for (const { kind } of rows) if (kind && all.value) kind.value = all.value;
    });
    return labelled('Kind of all', all);
  }
}

/** @param {Row[]} rows */
function unique(rows) {
  const names = rows.map(({ name }) => name?.value);
  rows.forEach(({ name }, index) => name?.setCustomValidity(names.indexOf(name.value) < index ? 'Another file has this name.' : ''));
}

/** @param {Record<string, string>} choices */
function select(choices) {
  return make('select', {}, ...optionsOf(Object.entries(choices)));
}
