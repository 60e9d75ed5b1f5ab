import { ConnectionLostError, RefusedError } from './vendor/motionsplice.js';

/** Requests to the service that has sent the page. The token, if it needs one, is kept for as long as the tab is open. */
export class Service {
  /** @type {string | undefined} */
  token = sessionStorage.getItem('motionsplice-token') ?? undefined;
  /** Address of the service. */
  url = new URL('..', location.href.replace(/[?#].*/, '')).href.replace(/\/$/, '');

  /** @param {string} token */
  remember(token) {
    this.token = token;
    sessionStorage.setItem('motionsplice-token', token);
  }

  /**
   * @param {string} path
   * @param {RequestInit} [options]
   * @throws {RefusedError | ConnectionLostError}
   */
  async request(path, options = {}) {
    const headers = new Headers(options.headers);
    if (this.token) headers.set('Authorization', `Bearer ${this.token}`);
    const response = await fetch(this.url + path, { ...options, headers }).catch((error) => {
      if (error.name === 'AbortError') throw error;
      throw new ConnectionLostError(`no answer from ${this.url}`);
    });
    if (response.ok) return response;
    const { type = 'http', detail = response.statusText } = await response.json().catch(() => ({}));
    throw new RefusedError(type, detail);
  }

  /** @param {string} path */
  async json(path) {
    return (await this.request(path)).json();
  }
}
