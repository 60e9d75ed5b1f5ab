import { button, make } from '../panels/dom.js';
import { takeFiles } from '../panels/drops.js';
import { AddDialog } from './dialog.js';
import { SKELETON, SUFFIXES } from './files.js';
import { Queue } from './queue.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { Service } from '../service.js' */
/** @import { Item } from './queue.js' */

const OPEN = 'Drop motion files here, or choose some';

/** Below the lists: adds files as clips of the bank, where the service allows it, and shows how far each of them is. */
export class Adding {
  /** Rows of items that are shown. @type {Map<Item, ReturnType<typeof line>>} */
  #lines = new Map();
  /** Items of which the first to be served is played. @type {Set<Item>} */
  #awaited = new Set();

  /**
   * @param {{ element: HTMLElement, column: HTMLElement, dialog: HTMLDialogElement }} places
   * @param {Service} service
   * @param {Catalogue} catalogue
   * @param {object} calls
   * @param {() => Promise<void>} calls.reload loads the bank that is served
   * @param {(kind: 'locomotion' | 'action', name: string) => void} calls.play
   */
  constructor({ element, column, dialog }, service, catalogue, { reload, play }) {
    this.catalogue = catalogue;
    this.play = play;
    this.dialog = new AddDialog(dialog);
    this.queue = new Queue(service, {
      onChange: () => this.#show(),
      onServed: (items) => void reload().then(() => this.#served(items)),
    });
    this.input = make('input', { type: 'file', multiple: true, accept: SUFFIXES.join(), hidden: true, 'aria-label': 'Motion files' });
    this.input.addEventListener('change', () => {
      this.#choose([...this.input.files ?? []]);
      this.input.value = '';
    });
    this.list = make('ul', { class: 'uploads', 'aria-label': 'Files on their way into the bank' });
    this.news = make('p', { class: 'unseen', role: 'status' });
    this.offer = make('div', { class: 'offer' }, button('Add clips', () => this.input.click(), { title: OPEN }), make('span', { class: 'hint' }, 'or drop files here'));
    this.instead = /** @type {HTMLElement} */ (element.querySelector('.hint')); // how to allow uploads
    element.prepend(this.list, this.offer, this.news, this.input);
    takeFiles(column, (files) => this.#choose(files), () => this.isAllowed);
    this.reload(catalogue);
  }

  /** @param {Catalogue} catalogue */
  reload(catalogue) {
    this.catalogue = catalogue;
    this.offer.hidden = !this.isAllowed;
    this.instead.hidden = this.isAllowed;
  }

  get isAllowed() {
    return this.catalogue.server.uploads;
  }

  /** @param {File[]} files */
  #choose(files) {
    if (!files.length) return;
    this.dialog.open(files, this.catalogue, (wanted) => {
      const before = new Set(this.queue.items);
      this.queue.add(wanted);
      this.#awaited = new Set(this.queue.items.filter((item) => !before.has(item)));
    });
  }

  /** @param {Item[]} items */
  #served(items) {
    this.news.textContent = `${items.map(({ name }) => name).join(', ')}: in the bank`;
    const first = items.find((item) => this.#awaited.has(item));
    if (!first) return;
    this.#awaited.clear();
    this.play(first.kind, first.name);
  }

  #show() {
    for (const [item, { element }] of this.#lines) {
      if (this.queue.items.includes(item)) continue;
      element.remove();
      this.#lines.delete(item);
    }
    for (const item of this.queue.items) {
      if (!this.#lines.has(item)) this.#lines.set(item, line(item, this.queue, () => this.play(item.kind, item.name)));
      const shown = /** @type {ReturnType<typeof line>} */ (this.#lines.get(item));
      if (!shown.element.isConnected) this.list.append(shown.element);
      if (shown.sync() && item.state === 'failed') this.news.textContent = `${item.name}: ${item.text}`;
    }
  }
}

/**
 * One file on its way. `sync` shows its state, and returns whether the state is another than before.
 *
 * @param {Item} item
 * @param {Queue} queue
 * @param {() => void} onPlay
 */
function line(item, queue, onPlay) {
  const text = make('span', { class: 'text' });
  const bar = make('progress', { max: 1, 'aria-label': `Progress of ${item.name}` });
  const play = button('Play', onPlay);
  const retry = button('Try again', () => queue.retry(item));
  const remove = button('✕', () => queue.remove(item), { 'aria-label': `Remove ${item.name} from this list`, title: 'Remove from this list' });
  const element = make('li', {}, make('span', { class: 'head' }, make('strong', { class: 'name', title: item.name + item.suffix }, item.name + item.suffix), play, retry, remove), bar, text);
  let before = '';
  return {
    element,
    sync: () => {
      const { state, share } = item;
      const isOver = state === 'done' || state === 'failed';
      text.textContent = state === 'failed' ? `⚠ ${item.text}` : item.text;
      text.classList.toggle('warning', state === 'failed');
      bar.hidden = isOver || state === 'queued';
      if (share === undefined) bar.removeAttribute('value');
      else bar.value = share;
      play.hidden = state !== 'done' || item.suffix === SKELETON;
      retry.hidden = state !== 'failed' || !item.isLost;
      remove.hidden = !isOver;
      const isNew = state !== before;
      before = state;
      return isNew;
    },
  };
}
