import { button, make, newId, swatch } from '../panels/dom.js';
import { SIDES } from '../takes.js';
import { COLUMNS, filtered, grade, linkTo, meanOf, sorted } from './pairs.js';
import { painter, strip } from './strip.js';

/** @import { Column, Pair, Report } from './pairs.js' */

const HIGHEST = 20; // cm at the upper edge of the curves
const NAMES = { locomotion: 'Locomotion', action: 'Action' };

/** The pairs as a table that can be sorted and filtered. The address holds both, so that Back in the viewer restores them. */
export class PairTable {
  /** @type {Map<Pair, HTMLTableRowElement>} */
  #rows = new Map();
  /** @type {Map<string, HTMLTableCellElement>} */
  #heads = new Map();

  /**
   * @param {Report} report
   * @param {{ has(name: string): boolean }} clips of the bank that is served
   */
  constructor(report, clips) {
    this.pairs = report.pairs;
    const query = new URLSearchParams(location.search);
    this.key = query.get('sort') ?? (meanOf(report.pairs, 'ratio') === undefined ? 'legs' : 'ratio');
    this.isDown = query.get('order') !== 'up';
    this.columns = COLUMNS.filter((column) => meanOf(report.pairs, column.key) !== undefined);
    const highest = report.pairs.flatMap(({ over_time: found }) => [...found.naive ?? [], ...found.splice ?? []]).reduce((a, b) => Math.max(a, b), 0);
    this.top = Math.min(HIGHEST, Math.max(5, 5 * Math.ceil(highest / 5)));
    const names = newId();
    this.search = make('input', { type: 'search', placeholder: 'Filter by clip', 'aria-label': 'Filter by clip', list: names });
    this.search.value = query.get('clip') ?? '';
    const clipNames = [...new Set(report.pairs.flatMap(({ locomotion, action }) => [locomotion, action]))].sort();
    this.summary = make('p', { class: 'hint', role: 'status' });
    this.body = make('tbody');
    const table = make('table', { class: 'pairs' }, make('caption', { class: 'unseen' }, 'Pairs'), make('thead', {}, this.#head()), this.body);
    this.element = make('section', {}, make('div', { class: 'bar' }, make('h2', {}, 'Pairs'), this.search, this.summary, this.#legend()),
      make('datalist', { id: names }, ...clipNames.map((name) => make('option', { value: name }))),
      make('div', { class: 'scroll', tabindex: 0, role: 'group', 'aria-label': 'Table of pairs' }, table));
    const paint = painter();
    for (const pair of report.pairs) {
      const one = strip(pair, report.rate, this.top, (time) => linkTo(pair, clips, time));
      this.#rows.set(pair, this.#row(pair, linkTo(pair, clips), one.element));
      paint(one);
    }
    this.search.addEventListener('input', () => this.#show());
    this.#show();
  }

  #head() {
    const row = make('tr');
    /** @param {string} key @param {string} label @param {string} [help] */
    const sortable = (key, label, help) => {
      const cell = make('th', { scope: 'col', title: help }, button(label, () => this.#sort(key)));
      this.#heads.set(key, cell);
      return cell;
    };
    row.append(sortable('locomotion', NAMES.locomotion), sortable('action', NAMES.action), make('th', { scope: 'col' }, `Over time\n0 to ${this.top} cm`),
      ...this.columns.map(({ key, label, help }) => sortable(key, label, help)));
    return row;
  }

  #legend() {
    return make('p', { class: 'legend' }, ...[SIDES.naive, SIDES.splice].map(({ label, colour }) => make('span', {}, swatch(colour), label)));
  }

  /**
   * @param {Pair} pair
   * @param {string | undefined} href
   * @param {HTMLElement} over
   */
  #row(pair, href, over) {
    const { locomotion, action, worst, example, truth } = pair;
    const label = `${locomotion} + ${action}: worst at ${worst.time.toFixed(2)} s`;
    const name = href ? make('a', { href, 'aria-label': label, title: `Show the worst moment, ${worst.time.toFixed(2)} s` }, locomotion) : locomotion;
    const note = [example, truth && `truth: ${truth}`].filter(Boolean).join('; ');
    const row = make('tr', { class: href ? 'linked' : '' }, make('th', { scope: 'row', title: note || undefined }, name), make('td', { class: 'text' }, action),
      make('td', { class: 'over' }, over), ...this.columns.map((column) => cell(column, pair)));
    row.addEventListener('click', (event) => {
      const isLink = event.target instanceof Element && event.target.closest('a');
      if (href && !isLink && !getSelection()?.toString()) location.assign(href);
    });
    return row;
  }

  /** @param {string} key */
  #sort(key) {
    this.isDown = key === this.key ? !this.isDown : !(key in NAMES);
    this.key = key;
    this.#show();
  }

  #show() {
    const shown = filtered(sorted(this.pairs, this.key, this.isDown), this.search.value);
    this.body.replaceChildren(...shown.map((pair) => /** @type {HTMLTableRowElement} */ (this.#rows.get(pair))));
    for (const [key, head] of this.#heads) {
      if (key === this.key) head.setAttribute('aria-sort', this.isDown ? 'descending' : 'ascending');
      else head.removeAttribute('aria-sort');
    }
    const [naive, splice, ratio] = ['naive', 'splice', 'ratio'].map((key) => meanOf(shown, key));
    const means = naive === undefined || splice === undefined || ratio === undefined ? ''
      : `; mean error ${naive.toFixed(1)} cm naive, ${splice.toFixed(1)} cm spliced, ratio ${ratio.toFixed(2)}`;
    this.summary.textContent = `${shown.length} of ${this.pairs.length} pairs${means}`;
    const query = new URLSearchParams({ sort: this.key, order: this.isDown ? 'down' : 'up' });
    if (this.search.value) query.set('clip', this.search.value);
    history.replaceState(null, '', `?${query}`);
  }
}

/**
 * @param {Column} column
 * @param {Pair} pair
 */
function cell(column, pair) {
  const value = column.value(pair);
  if (value === null || value === undefined) return make('td', {}, make('span', { class: 'unseen' }, 'unknown'));
  return make('td', { class: grade(column, value) }, value.toFixed(column.digits));
}
