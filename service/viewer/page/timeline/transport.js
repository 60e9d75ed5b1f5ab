import { make } from '../panels/dom.js';
import { icon } from './icons.js';
import { parseMoment } from './moment.js';

/** @import { Player } from '../player.js' */
/** @import { State } from '../state.js' */
/** @import { Icon } from './icons.js' */

const SPEEDS = { min: 0.1, max: 2, step: 0.05 };

/** Buttons and fields of playback. */
export class Transport {
  #shownTime = '';
  #shownFrame = '';
  #shownLast = '';

  /**
   * @param {HTMLElement} element
   * @param {Player} player
   * @param {State} state
   */
  constructor(element, player, state) {
    this.player = player;
    this.state = state;
    element.classList.add('transport');

    this.play = this.#button('play', 'Play', 'space', () => player.toggle());
    this.play.classList.add('transport-play');
    const buttons = make('div', { class: 'transport-group transport-buttons' },
      this.#button('first', 'First frame', 'Home', () => player.seek(player.range[0])),
      this.#button('back', 'One frame back', 'left arrow', () => player.step(-1)),
      this.play,
      this.#button('ahead', 'One frame ahead', 'right arrow', () => player.step(1)),
      this.#button('last', 'Last frame', 'End', () => player.seek(player.range[1])),
    );

    this.time = this.#field('Time', 'transport-time', (text) => parseMoment(text, player.rate));
    this.frame = this.#field('Frame', 'transport-frame', (text) => (/^\s*\d+\s*$/.test(text) ? Number(text) / player.rate : undefined));
    this.last = make('span', { class: 'transport-last' });
    const moment = make('div', { class: 'transport-group' },
      this.time, make('span', { class: 'transport-unit' }, 's'), make('span', { class: 'transport-word' }, 'frame'), this.frame, this.last);

    this.rangeText = make('span', { class: 'transport-range-text' });
    this.range = make('div', { class: 'transport-group transport-range' }, make('span', { class: 'transport-word' }, 'repeat'), this.rangeText,
      this.#button('clear', 'Repeat all', '', () => state.set({ from: 0, to: 0 })));

    this.slider = this.#slider();
    this.normal = this.#button('play', 'Normal speed', '', () => state.set({ speed: 1 }));
    this.normal.classList.add('transport-normal');
    const speed = make('div', { class: 'transport-group transport-speed' },
      make('span', { class: 'transport-word' }, 'speed'), this.slider, this.normal);
    element.append(buttons, moment, this.range, speed);
    state.on((changed) => {
      if (['playing', 'speed', 'from', 'to'].some((key) => changed.has(/** @type {any} */ (key)))) this.#update();
    });
    this.#update();
    this.at(player.time);
  }

  /** @param {number} time */
  at(time) {
    const { rate, duration } = this.player;
    const last = `/ ${Math.round(duration * rate)}`;
    if (last !== this.#shownLast) {
      this.last.textContent = this.#shownLast = last;
      this.#update(); // the range ends with the motion
    }
    const text = time.toFixed(2), frame = String(Math.round(time * rate));
    if (text !== this.#shownTime && document.activeElement !== this.time) this.time.value = this.#shownTime = text;
    if (frame !== this.#shownFrame && document.activeElement !== this.frame) this.frame.value = this.#shownFrame = frame;
  }

  #update() {
    const { playing, speed, from, to } = this.state.values;
    const name = playing ? 'Pause' : 'Play';
    this.play.replaceChildren(icon(playing ? 'pause' : 'play'));
    this.play.setAttribute('aria-label', name);
    this.play.title = `${name} (space)`;
    this.slider.value = String(speed);
    this.slider.setAttribute('aria-valuetext', `${speed.toFixed(2)} times`);
    this.normal.textContent = `${speed.toFixed(2)}×`;
    this.normal.setAttribute('aria-label', `${speed.toFixed(2)}×, set normal speed`);
    this.normal.title = 'Set normal speed';
    this.normal.disabled = speed === 1;
    const [start, end] = this.player.range;
    this.range.hidden = !from && !to;
    this.rangeText.textContent = `${start.toFixed(2)} to ${end.toFixed(2)} s`;
  }

  /**
   * @param {Icon} shape
   * @param {string} name
   * @param {string} key shortcut, for the tooltip
   * @param {() => void} act
   */
  #button(shape, name, key, act) {
    const title = key ? `${name} (${key})` : name;
    const button = make('button', { type: 'button', class: 'transport-button', 'aria-label': name, title }, icon(shape));
    button.addEventListener('click', act);
    return button;
  }

  /**
   * Returns a field that seeks. Invalid text is replaced by the current value.
   *
   * @param {string} name
   * @param {string} className
   * @param {(text: string) => number | undefined} read returns seconds
   */
  #field(name, className, read) {
    const field = make('input', { type: 'text', class: `transport-field ${className}`, inputmode: 'decimal', autocomplete: 'off', 'aria-label': name });
    field.addEventListener('focus', () => field.select());
    const leave = () => {
      this.#shownTime = this.#shownFrame = '';
      this.at(this.player.time);
    };
    field.addEventListener('change', () => {
      const time = read(field.value);
      if (time !== undefined) this.player.seek(time);
    });
    field.addEventListener('blur', leave);
    field.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') field.value = ''; // no time: the blur writes the current one
      if (event.key === 'Escape' || event.key === 'Enter') field.blur();
    });
    return field;
  }

  #slider() {
    const slider = make('input', { type: 'range', class: 'transport-slider', ...SPEEDS, 'aria-label': 'Speed', title: 'Speed' });
    slider.addEventListener('input', () => this.state.set({ speed: Number(slider.value) }));
    return slider;
  }
}
