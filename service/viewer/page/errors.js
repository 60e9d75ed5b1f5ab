import { RefusedError } from './vendor/motionsplice.js';

/**
 * Returns whether the service refused a request for a reason.
 *
 * @param {unknown} error
 * @param {string} type of the reason, as the service names it
 * @returns {error is RefusedError}
 */
export function isRefused(error, type) {
  return error instanceof RefusedError && error.type === type;
}

/** @param {unknown} error */
export function messageOf(error) {
  return error instanceof Error ? error.message : String(error);
}
