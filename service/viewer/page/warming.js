import { isRefused, messageOf } from './errors.js';

/** @import { Service } from './service.js' */

/** Waits for a service that is not ready yet, and says for how long. A first start compiles kernels, on a slow machine for minutes. */
export class Warming {
  #since = 0; // ms; 0: it does not wait

  /**
   * @param {Service} service
   * @param {{ say: (text: string) => void, ready: () => void, failed: (error: unknown) => void }} then
   * @param {number} [pause] ms until the service is asked again
   */
  constructor(service, then, pause = 1000) {
    this.service = service;
    this.then = then;
    this.pause = pause;
  }

  /**
   * Waits, unless it does already.
   *
   * @param {unknown} reason the service's refusal
   */
  async wait(reason) {
    if (this.#since) return this.#say(reason);
    this.#since = Date.now();
    this.#say(reason);
    let problem;
    do {
      await new Promise((resolve) => setTimeout(resolve, this.pause));
      problem = await this.service.request('/readyz').then(() => undefined, (error) => error);
      if (isRefused(problem, 'not-ready')) this.#say(problem);
    } while (isRefused(problem, 'not-ready'));
    this.#since = 0;
    if (problem) this.then.failed(problem);
    else this.then.ready();
  }

  /** @param {unknown} reason */
  #say(reason) {
    const seconds = Math.round((Date.now() - this.#since) / 1000);
    const waited = seconds < 60 ? `${seconds} s` : `${Math.floor(seconds / 60)} min ${seconds % 60} s`;
    this.then.say(`The service is not ready: ${messageOf(reason)}. The first start may take minutes. Waited ${waited} so far.`);
  }
}
