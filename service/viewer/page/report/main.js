import { Catalogue } from '../catalogue.js';
import { isRefused, messageOf } from '../errors.js';
import { button, byId, make } from '../panels/dom.js';
import { withToken } from '../panels/entry.js';
import { describeBank } from '../panels/title.js';
import { Service } from '../service.js';
import { PairTable } from './table.js';

/** @import { Report, Target } from './pairs.js' */

const service = new Service();
const main = byId('report');
void show();

/** Shows the report, or why there is none. */
async function show() {
  try {
    const catalogue = await withToken(service, () => Catalogue.load(service));
    describeBank(byId('bank'), catalogue);
    const report = /** @type {Report} */ (await withToken(service, () => service.json('/v1/report')));
    const table = new PairTable(report, catalogue.clips);
    main.replaceChildren(
      make('h2', { class: 'title' }, 'How close splices are to the true motion'),
      ...warningOf(report, catalogue.server.bank),
      targets(report.targets), table.element,
      make('p', { class: 'hint' }, 'A click on a pair opens the viewer at its worst moment, and a click on a curve at the moment under the pointer. '
        + 'Point at a column\'s name to see what it measures.'),
    );
  } catch (error) {
    if (isRefused(error, 'report')) main.replaceChildren(...missing(error.message));
    else main.replaceChildren(make('p', { class: 'warning' }, messageOf(error)), button('Try again', show));
  }
}

/**
 * @param {Report} report
 * @param {string} served digest
 */
function warningOf({ bank, version }, served) {
  if (bank === served) return [make('p', { class: 'hint' }, `Measured by motionsplice ${version} on this bank.`)];
  return [make('p', { class: 'warning', role: 'alert' }, `⚠ These numbers are of another bank, ${bank}. Here ${served} is served, whose splices may differ.`)];
}

/** @param {Target[]} all */
function targets(all) {
  const met = all.filter((one) => one.met).length;
  const rows = all.map(({ what, found, wanted, met: isMet }) => make('tr', {}, make('th', { scope: 'row' }, what), make('td', {}, found),
    make('td', {}, wanted.replace('<=', '≤').replace('>=', '≥')), make('td', { class: isMet ? 'good' : 'bad' }, isMet ? '✓ met' : '✗ missed')));
  const head = make('tr', {}, ...['Measure', 'Measured', 'Target', ''].map((one) => make('th', { scope: 'col' }, one || make('span', { class: 'unseen' }, 'Result'))));
  return make('section', { hidden: !all.length }, make('h2', {}, `Targets: ${met} of ${all.length} met`),
    make('div', { class: 'scroll' }, make('table', { class: 'targets' }, make('thead', {}, head), make('tbody', {}, ...rows))));
}

/**
 * Says how to make a report.
 *
 * @param {string} reason
 */
function missing(reason) {
  const lines = 'python -m bench.quality --bank BANK --out quality\nmotionsplice serve BANK --report quality/scores.json';
  return [
    make('h2', { class: 'title' }, 'No report'),
    ...(reason.startsWith('this service has no report') ? [] : [make('p', { class: 'warning' }, `⚠ ${reason}.`)]), // the text below says it
    make('p', {}, 'This service was started without a report, or cannot read it. Measure the bank with the benchmark, then serve it with the numbers:'),
    make('pre', { tabindex: 0 }, lines),
    make('p', {}, 'The benchmark is in the source of motionsplice, not in the installed package. '
      + 'By default it judges every action on every locomotion. With --pairs PAIRS.csv it judges the pairs of a file with the columns '
      + 'locomotion, action and truth: a clip that shows what the splice should be.'),
  ];
}
