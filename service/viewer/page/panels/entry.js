import { isRefused, messageOf } from '../errors.js';
import { byId, make } from './dom.js';

/** @import { Service } from '../service.js' */

/**
 * Asks for the token until the service accepts it. The token goes into the tab's storage, never into the address.
 *
 * @param {Service} service
 * @returns {Promise<void>} when the service accepts the token
 */
export function askForToken(service) {
  asking ??= ask(service).finally(() => { asking = undefined; }); // several refused requests open one dialog
  return asking;
}

/** @type {Promise<void> | undefined} */
let asking;

/**
 * Runs requests, and asks for the token and runs them again while the service refuses them without it.
 *
 * @template Result
 * @param {Service} service
 * @param {() => Promise<Result>} requests
 * @returns {Promise<Result>}
 */
export async function withToken(service, requests) {
  for (;;) {
    try {
      return await requests();
    } catch (error) {
      if (!isRefused(error, 'token')) throw error;
      await askForToken(service);
    }
  }
}

/** @param {Service} service */
async function ask(service) {
  const dialog = /** @type {HTMLDialogElement} */ (byId('entry'));
  const field = make('input', {
    type: 'password', id: 'entry-token', autocomplete: 'current-password', required: true, 'aria-describedby': 'entry-fault',
  });
  const fault = make('p', { id: 'entry-fault', role: 'alert', class: 'warning' });
  const submit = make('button', { class: 'primary' }, 'Enter');
  const form = make('form', { method: 'dialog' },
    make('h2', { id: 'entry-title' }, 'This service needs a token'),
    make('p', { class: 'hint' }, 'Enter the token that the service was started with. This tab keeps it until you close it.'),
    make('label', { for: 'entry-token', class: 'label' }, 'Token'), field, fault, submit);
  dialog.replaceChildren(form);
  const reopen = () => dialog.showModal(); // browsers close a dialog at the second Escape even if the page cancels it
  dialog.addEventListener('cancel', keepOpen);
  dialog.addEventListener('close', reopen);
  dialog.showModal();
  await new Promise((resolve) => {
    form.addEventListener('submit', async (event) => {
      event.preventDefault();
      submit.disabled = true;
      fault.textContent = await faultOf(service, field.value.trim());
      submit.disabled = false;
      if (!fault.textContent) return resolve(undefined);
      field.setAttribute('aria-invalid', 'true');
      field.select();
    });
  });
  dialog.removeEventListener('cancel', keepOpen);
  dialog.removeEventListener('close', reopen);
  dialog.close();
  dialog.replaceChildren();
}

/**
 * Tries a token and keeps it if the service accepts it. Returns the fault, or an empty text.
 *
 * @param {Service} service
 * @param {string} token
 */
async function faultOf(service, token) {
  const before = service.token;
  service.token = token;
  try {
    await service.json('/v1/server');
    service.remember(token);
    return '';
  } catch (error) {
    service.token = before;
    if (isRefused(error, 'token')) return 'The service does not accept this token.';
    return messageOf(error);
  }
}

/** @param {Event} event */
function keepOpen(event) {
  event.preventDefault();
}
