import { Catalogue } from '../catalogue.js';
import { isRefused } from '../errors.js';
import { ConnectionLostError } from '../vendor/motionsplice.js';
import { button, make } from './dom.js';
import { withToken } from './entry.js';

/** @import { Service } from '../service.js' */

const BETWEEN = 5000; // ms between checks of the service
const PAUSES = [500, 1000, 2000, 4000, 8000, 15_000]; // ms before each retry
const GOOD_NEWS = 4000; // ms for which the banner reports that the service is back

/** A banner that reports when the service is gone and when it is back. It also reloads the catalogue when the bank has changed. */
export class Connection {
  #isGone = false;
  #tries = 0;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {HTMLElement} banner a live region
   * @param {Service} service
   * @param {Catalogue} catalogue
   * @param {(catalogue: Catalogue) => void} onReload called with the new catalogue, after the service came back or its bank changed
   */
  constructor(banner, service, catalogue, onReload) {
    this.banner = banner;
    this.service = service;
    this.bank = catalogue.server.bank;
    this.onReload = onReload;
    addEventListener('online', () => this.look());
    document.addEventListener('visibilitychange', () => document.hidden || this.look());
    this.#wait(BETWEEN);
  }

  /**
   * Handles a failed request. Returns whether it failed because the service did not answer.
   *
   * @param {unknown} error
   */
  notice(error) {
    if (isRefused(error, 'unknown-bank')) this.look();
    if (!(error instanceof ConnectionLostError)) return false;
    if (!this.#isGone) this.#lose();
    return true;
  }

  #lose() {
    this.#isGone = true;
    this.#tries = 0;
    this.#wait(PAUSES[0]);
    this.#show('gone', 'The service does not answer. What was loaded still plays.', button('Try now', () => this.look()));
  }

  /** @param {number} pause */
  #wait(pause) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.look(), pause);
  }

  /**
   * Looks at once whether the service is there, and which bank it has.
   *
   * @returns {Promise<void>}
   */
  async look() {
    clearTimeout(this.#timer);
    if (document.hidden && !this.#isGone) return this.#wait(BETWEEN);
    try {
      await withToken(this.service, async () => {
        const { bank } = await this.service.json('/v1/server');
        if (this.#isGone || bank !== this.bank) await this.#reload();
      });
      this.#wait(BETWEEN);
    } catch (error) {
      if (this.#isGone) this.#wait(PAUSES[Math.min(++this.#tries, PAUSES.length - 1)]);
      else if (!this.notice(error)) this.#wait(BETWEEN);
    }
  }

  async #reload() {
    const catalogue = await Catalogue.load(this.service);
    const news = this.#isGone ? 'The service is back.' : 'The service has another bank.';
    this.#isGone = false;
    this.bank = catalogue.server.bank;
    this.#show('back', news);
    setTimeout(() => this.#isGone || this.#show(''), GOOD_NEWS);
    this.onReload(catalogue);
  }

  /**
   * @param {'' | 'gone' | 'back'} kind
   * @param {...(string | Node)} content
   */
  #show(kind, ...content) {
    this.banner.className = kind;
    this.banner.replaceChildren(...content.map((one) => (typeof one === 'string' ? make('span', {}, one) : one)));
  }
}
