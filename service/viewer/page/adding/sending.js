import { ConnectionLostError, RefusedError } from '../vendor/motionsplice.js';

/** @import { Service } from '../service.js' */

/**
 * The state of the offline job, as `/v1/job` returns it.
 *
 * @typedef {object} Job
 * @property {'idle' | 'waiting' | 'running' | 'failed'} state
 * @property {string} stage
 * @property {number} done
 * @property {number} total
 * @property {string[]} clips that are not in the bank yet
 * @property {Record<string, string>} failed reasons
 * @property {string} error
 * @property {string} bank digest of the bank on disk
 */

const PAUSES = [500, 1000, 2000, 4000, 8000]; // ms before the job is followed again
const SILENCE = 40_000; // ms; the service writes at least a comment every 15 s

/**
 * Sends a file as a new clip. XMLHttpRequest, as fetch does not say how much is sent.
 *
 * @param {Service} service
 * @param {Record<string, string>} query
 * @param {Blob} file
 * @param {(share: number) => void} onProgress 0 to 1
 * @returns {Promise<Job>}
 * @throws {RefusedError | ConnectionLostError}
 */
export function send(service, query, file, onProgress) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', `${service.url}/v1/clips?${new URLSearchParams(query)}`);
    request.responseType = 'json';
    request.setRequestHeader('Content-Type', 'application/octet-stream');
    if (service.token) request.setRequestHeader('Authorization', `Bearer ${service.token}`);
    request.upload.addEventListener('progress', ({ loaded, total }) => onProgress(total ? loaded / total : 1));
    request.upload.addEventListener('load', () => onProgress(1));
    request.addEventListener('error', () => reject(new ConnectionLostError('The connection was lost while the file was sent.')));
    request.addEventListener('load', () => {
      const { status, statusText, response } = request;
      if (status < 300 && response) resolve(response);
      else reject(new RefusedError(response?.type ?? 'http', response?.detail ?? statusText));
    });
    request.send(file);
  });
}

/**
 * Yields the state of the job now and at each change, until the caller stops. Yields undefined each time that the connection is
 * lost, and connects again.
 *
 * @param {Service} service
 * @returns {AsyncGenerator<Job | undefined, void>}
 * @throws {RefusedError}
 */
export async function* follow(service) {
  for (let tries = 0; ; tries++) {
    try {
      for await (const job of events(service)) {
        tries = 0;
        yield job;
      }
    } catch (error) {
      if (error instanceof RefusedError) throw error;
    }
    yield undefined;
    await pause(PAUSES[Math.min(tries, PAUSES.length - 1)]);
  }
}

/**
 * Server-sent events by fetch: EventSource cannot send the token.
 *
 * @param {Service} service
 * @returns {AsyncGenerator<Job, void>}
 */
async function* events(service) {
  const control = new AbortController();
  const { body } = await service.request('/v1/job/events', { signal: control.signal });
  const reader = /** @type {ReadableStream<Uint8Array>} */ (body).getReader();
  const decoder = new TextDecoder();
  let text = '';
  try {
    for (;;) {
      const silence = setTimeout(() => control.abort(), SILENCE);
      const { value, done } = await reader.read().finally(() => clearTimeout(silence));
      if (done) return;
      text += decoder.decode(value, { stream: true });
      const found = text.split('\n\n');
      text = found.pop() ?? '';
      for (const event of found) if (event.startsWith('data: ')) yield JSON.parse(event.slice(6));
    }
  } finally {
    control.abort();
  }
}

/** @param {number} ms */
export function pause(ms) {
  return new Promise((resolve) => setTimeout(resolve, ms));
}
