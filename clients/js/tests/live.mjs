// Plays characters of a live service in both encodings and two look-aheads, through an exchange of the bank and a lost
// connection, and compares the joints with the service's world positions in every frame.
// Usage: node live.mjs URL. Prints {ready}, and waits for the exchange; prints {exchanged}, and waits for the loss;
// prints {results}.
import WebSocket from 'ws';
import { connect, Pose } from '../motionsplice.js';

const RATE = 120;
const FASTEST = 2; // metres per second
const ENOUGH = 350; // frames in each of the three parts
const SAMPLES = 5; // messages that are printed, of each part
const say = (line) => console.log(JSON.stringify(line));
const far = (one, other) => Math.hypot(...one.map((value, axis) => value - other[axis]));

class Player {
  constructor(encoding, ahead) {
    Object.assign(this, { encoding, ahead, worst: 0, frames: 0, banks: [], samples: [], before: 0 });
  }

  async start(url) {
    this.service = await connect(url, { WebSocket, parts: 'both', encoding: this.encoding, ahead: this.ahead, rate: RATE });
    this.service.on('frames', (frames) => this.check(frames));
    this.service.on('error', (error) => { throw error; });
    const at = { position: [3, 0, 5], heading: 2.5 }; // near the origin: at 40 m the service's own float32 is 1.1e-5 m off
    this.hero = await this.service.create('walk', at);
    await this.service.create({ walk: 0.5, run: 0.5 }, { ...at, id: 4_000_000_000, speed: 0.4 });
    const third = await this.service.create('turn_180', { ...at, speed: 0.7 });
    await Promise.all([this.hero.act('carry_box', { when: 'left_foot' }), third.act('wave', { mask: 'right_arm', blendOut: 0.2 })]);
    return this.more();
  }

  check(frames) {
    const pose = Pose.for(frames);
    const positions = [];
    for (let number = 0; number < frames.count; number++) {
      for (let row = 0; row < frames.characters; row++) {
        pose.read(frames, number, row);
        const places = pose.worldPositions();
        for (let at = 0; at < places.length; at++) this.worst = Math.max(this.worst, Math.abs(places[at] - pose.positions[at]));
        positions.push(...places);
      }
    }
    this.shown = Array.from(this.hero?.pose()?.root ?? []);
    this.frames += frames.count;
    this.root = Array.from(frames.rootPositions.subarray(-3 * frames.characters).subarray(0, 3));
    if (this.banks.at(-1) !== frames.rig.bank) this.banks.push(frames.rig.bank);
    if (this.samples.length < SAMPLES * this.banks.length) {
      const message = Buffer.from(frames.rootPositions.buffer).toString('base64');
      this.samples.push({ message, positions, offsets: Array.from(frames.rig.offsets), parents: Array.from(frames.rig.parents) });
    }
  }

  event(name) {
    return new Promise((resolve) => this.service.on(name, resolve));
  }

  async more() {
    const end = this.frames + ENOUGH;
    while (this.frames < end) await this.event('frames');
  }
}

const url = process.argv[2];
const players = ['float32', 'int16'].flatMap((encoding) => [1, 8].map((ahead) => new Player(encoding, ahead)));
await Promise.all(players.map((player) => player.start(url)));
const banks = players.map((player) => player.event('bank'));
say({ ready: true });
await Promise.all(banks);
await Promise.all(players.map((player) => player.more()));
const reconnected = players.map(async (player) => {
  const { retry } = await player.event('disconnected');
  const root = player.root;
  player.isHeld = String(Array.from(player.hero.pose().root)) === String(player.shown); // while there is no connection
  const { failed } = await player.event('reconnected');
  const since = performance.now();
  await player.event('frames');
  player.jump = far(root, player.root) - FASTEST * 1e-3 * (performance.now() - since); // it goes on while events wait
  player.again = { retry, failed: failed.length, characters: player.service.characters.size };
});
say({ exchanged: true });
await Promise.all(reconnected);
await Promise.all(players.map((player) => player.more()));
say({ results: players.map(({ encoding, ahead, worst, frames, banks: seen, samples, jump, isHeld, again }) =>
  ({ encoding, ahead, worst, frames, banks: seen, samples, jump, isHeld, ...again })) });
for (const { service } of players) service.close();
