import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test, { afterEach } from 'node:test';
import { connect, ConnectionLostError, FormatError, MotionSpliceError, RefusedError } from '../motionsplice.js';

const FILES = new URL('../../../tests/golden/files/', import.meta.url);
const RIG = JSON.parse(readFileSync(new URL('rig.gltf.json', FILES)));
const FRAMES = new Uint8Array(readFileSync(new URL('characters.gltf.float32.msgpack', FILES))).slice().buffer; // of 7 and 2^32 - 1
const WELCOME = { event: 'welcome', protocol: 3, ...RIG };

/** A WebSocket without a network. */
class Socket {
  static made = [];

  constructor(url, protocols) {
    Object.assign(this, { url: new URL(url), protocols, sent: [], isClosed: false });
    Socket.made.push(this);
  }

  send(text) {
    this.sent.push(JSON.parse(text));
  }

  close() {
    this.isClosed = true;
  }

  hear(event) {
    this.onmessage({ data: event instanceof ArrayBuffer || typeof event === 'string' ? event : JSON.stringify(event) });
  }

  lose(code, reason = '') {
    this.onclose({ code, reason });
  }

  /** Replies to the message that waits longest. */
  done(frame) {
    const sent = this.sent.shift();
    this.hear({ event: 'done', ref: (sent[0] ?? sent).ref, frame });
    return sent;
  }
}

const services = [];
afterEach(() => services.splice(0).forEach((service) => service.close()));

async function opened(options = {}) {
  Socket.made = [];
  const connecting = connect('http://host:8000/base', { WebSocket: Socket, ...options });
  Socket.made[0].hear(WELCOME);
  const service = await connecting;
  services.push(service);
  return { service, socket: Socket.made[0] };
}

async function withCharacters() {
  const { service, socket } = await opened({ ahead: 2 });
  for (const id of [7, 4294967295]) {
    const made = service.create('curve', { id, position: [1, 2, 3], heading: 0.5, inPlace: false });
    await Promise.resolve();
    socket.done(120);
    await made;
  }
  return { service, socket, hero: service.characters.get(7) };
}

test('it asks for what it is given', async () => {
  const { service, socket } = await opened({ token: 'abc', rate: 30, ahead: 4, encoding: 'int16', parts: 'both' });
  assert.equal(socket.url.href, 'ws://host:8000/base/v1/characters?axes=gltf&parts=both&encoding=int16&deltas=true&rate=30&ahead=4');
  assert.deepEqual(socket.protocols, ['motionsplice', 'bearer.abc']);
  assert.equal(service.rig.joints.length, RIG.joints.length);
  assert.equal(service.clips.walk.rate, 60);
  service.close();
  assert.ok(socket.isClosed);
});

test('the delay is known once there are frames', async () => {
  const { service, socket } = await withCharacters();
  assert.equal(service.delay, undefined);
  socket.hear(FRAMES);
  assert.ok(service.delay > 0 && service.delay < 1);
});

test('a promise resolves to the frame of its own reply, or is rejected with the reason', async () => {
  const { socket, hero } = await withCharacters();
  const acts = [hero.act('wave', { blendOut: 0.2, ownClock: [0, 1], when: undefined }), hero.speed(2), hero.wear(null)];
  await Promise.resolve();
  assert.deepEqual(socket.sent[0], { do: 'act', id: 7, action: 'wave', blend_out: 0.2, own_clock: [0, 1], ref: 3 });
  socket.hear({ event: 'refused', ref: 4, type: 'urn:motionsplice:request', detail: 'no' });
  socket.hear({ event: 'done', ref: 3, frame: 9 });
  assert.equal(await acts[0], 9);
  await assert.rejects(acts[1], (error) => error instanceof RefusedError && error.type === 'request' && error.message === 'no');
  socket.lose(1006);
  await assert.rejects(acts[2], (error) => error instanceof ConnectionLostError && error.code === 1006);
  await assert.rejects(hero.stop(), ConnectionLostError);
});

test('all commands are those of the protocol', async () => {
  const { service, socket, hero } = await withCharacters();
  const sent = [];
  const record = async (doing) => {
    await Promise.resolve();
    sent.push(socket.done(5));
    await doing;
  };
  await record(hero.play({ walk: 1, run: 2 }, { blend: 1, curve: 'linear' }));
  await record(hero.mix({ walk: 3 }));
  await record(hero.weight(0.5));
  await record(hero.stop({ blend: 2 }));
  await record(hero.wear('gloves', { weight: 1 }));
  await record(hero.look({ point: [1, 2, 3] }, { maxYaw: 1 }));
  await record(hero.aim({ direction: [0, 0, 1] }, { part: 'left_arm', blend: 1 }));
  await record(hero.aim(null));
  await record(hero.place([1, 0, 1], { heading: 1 }));
  await record(hero.inPlace());
  await record(hero.lockFeet());
  await record(hero.sendTo('vmc', 'livelink'));
  await record(service.set({ events: ['stride'], rate: 30 }));
  await record(service.send([{ do: 'speed', id: [7], speed: 1 }, { do: 'remove', id: 7 }]));
  assert.deepEqual(sent.map((one) => { delete (one[0] ?? one).ref; return one; }), [
    { do: 'play', id: 7, locomotion: { walk: 1, run: 2 }, blend: 1, curve: 'linear' },
    { do: 'mix', id: 7, weights: { walk: 3 } },
    { do: 'weight', id: 7, weight: 0.5 },
    { do: 'stop', id: 7, blend: 2 },
    { do: 'wear', id: 7, hands: 'gloves', weight: 1 },
    { do: 'look', id: 7, point: [1, 2, 3], max_yaw: 1 },
    { do: 'aim', id: 7, direction: [0, 0, 1], part: 'left_arm', blend: 1 },
    { do: 'aim', id: 7, point: null },
    { do: 'place', id: 7, position: [1, 0, 1], heading: 1 },
    { do: 'in_place', id: 7, in_place: true },
    { do: 'lock_feet', id: 7, lock_feet: true },
    { do: 'send', id: 7, to: ['vmc', 'livelink'] },
    { do: 'set', events: ['stride'], rate: 30 },
    [{ do: 'speed', id: [7], speed: 1 }, { do: 'remove', id: 7 }],
  ]);
  assert.deepEqual([...service.characters.keys()], [4294967295]);
});

test('a lost connection is opened again, and its characters are made again where they were', async (context) => {
  context.mock.timers.enable({ apis: ['setTimeout', 'setInterval'] });
  const { service, socket, hero } = await withCharacters();
  const seen = [];
  for (const name of ['disconnected', 'reconnected', 'closed']) service.on(name, (event) => seen.push([name, event]));
  const commands = [hero.act('carry_box', { when: 'left_foot', mask: 'arms' }), hero.speed(0.5), hero.lockFeet(), service.set({ rate: 30, events: ['stride'] }),
    service.characters.get(4294967295).act('wave', { loop: false }), hero.mix({ curve: 2 }), hero.wear('gloves'),
    hero.look({ point: [1, 2, 3] }), hero.aim({ point: [1, 2, 3] }), hero.aim(null), hero.aim({ direction: [0, 0, 1] }, { part: 'left_arm' })];
  await Promise.resolve();
  commands.forEach(() => socket.done(121));
  await Promise.all(commands);
  socket.hear(FRAMES);
  socket.lose(1011, 'the service failed');
  assert.match(seen[0][1].error.message, /^disconnected: the service failed/);
  for (const [tries, longest] of [[1, 0.5], [2, 1], [3, 2], [4, 4]]) {
    const { retry } = seen.at(-1)[1];
    assert.ok(retry >= longest / 2 && retry <= longest);
    context.mock.timers.tick(1000 * retry + 1);
    assert.equal(Socket.made.length, 1 + tries);
    if (tries < 4) Socket.made.at(-1).lose(1006);
  }
  const again = Socket.made.at(-1);
  assert.equal(again.url.searchParams.get('rate'), '30');
  again.hear(WELCOME);
  assert.deepEqual(again.sent[0], { do: 'set', events: ['stride'], ref: again.sent[0].ref });
  const [create, wear, look, aim, act] = again.sent[1];
  const { position, heading, ref, ...others } = create;
  assert.deepEqual(others, { do: 'create', id: 7, locomotion: { curve: 2 }, speed: 0.5, lock_feet: true, in_place: false });
  assert.deepEqual([look, aim], [{ do: 'look', id: 7, point: [1, 2, 3] }, { do: 'aim', id: 7, direction: [0, 0, 1], part: 'left_arm' }]);
  assert.deepEqual([wear, act], [{ do: 'wear', id: 7, hands: 'gloves' }, { do: 'act', id: 7, action: 'carry_box', mask: 'arms' }]);
  // two steps of the golden file from [1, 2, 3], heading 0.5
  assert.ok(Math.hypot(position[0] - 1, position[1] - 2, position[2] - 3) < 0.1 && position[2] > 3);
  assert.ok(heading > 0.5 && heading < 0.53);
  assert.deepEqual(again.sent[2].locomotion, 'curve');
  again.done(0);
  again.done(0);
  again.hear({ event: 'refused', ref: again.sent[0].ref, type: 'urn:motionsplice:unknown-clip', detail: 'gone' });
  await new Promise((resolve) => setImmediate(resolve));
  assert.equal(seen.at(-1)[0], 'reconnected');
  assert.deepEqual(seen.at(-1)[1].failed.map(({ id, error }) => [id, error.type]), [[4294967295, 'unknown-clip']]);
  assert.deepEqual([...service.characters.keys()], [7]);
});

test('a silent connection is lost, but not one without characters', async (context) => {
  context.mock.timers.enable({ apis: ['setTimeout', 'setInterval'] });
  let now = 0;
  context.mock.method(performance, 'now', () => now);
  const pass = (seconds) => { now += 1000 * seconds; context.mock.timers.tick(1000); };
  const { service, socket } = await withCharacters();
  let lost = 0;
  service.on('disconnected', () => lost++);
  pass(7.9);
  assert.equal(lost, 0);
  socket.hear(FRAMES);
  pass(7.9);
  pass(0.2);
  assert.equal(lost, 1);
  const { service: other } = await opened();
  other.on('disconnected', () => lost++);
  pass(1000);
  assert.equal(lost, 1);
});

test('an idle connection is opened again by the next command', async () => {
  const { service, socket } = await opened();
  let closed = 0;
  service.on('closed', () => closed++);
  socket.lose(4408, 'idle');
  assert.deepEqual([closed, Socket.made.length], [1, 1]);
  const made = service.create('walk');
  Socket.made[1].hear(WELCOME);
  await new Promise((resolve) => setImmediate(resolve));
  Socket.made[1].done(3);
  assert.equal((await made).id, 1);
});

test('who cannot connect says why', async () => {
  for (const [hear, expected] of [
    [(socket) => socket.lose(1006), (error) => error instanceof ConnectionLostError && error.code === 1006],
    [(socket) => { socket.onerror({ message: 'ECONNREFUSED' }); socket.lose(1006); }, /not connected: ECONNREFUSED/],
    [(socket) => { socket.hear({ event: 'refused', ref: null, type: 'urn:motionsplice:origin', detail: 'no' }); socket.lose(4403); },
      (error) => error instanceof RefusedError && error.type === 'origin'],
    [(socket) => socket.hear({ ...WELCOME, protocol: 4 }), (error) => error instanceof MotionSpliceError && /protocol 4.*3/.test(error.message)],
    [(socket) => socket.hear({ ...WELCOME, parents: [-1, 1] }), FormatError],
    [(socket) => socket.hear('<html>'), FormatError],
  ]) {
    Socket.made = [];
    const connecting = connect('ws://host', { WebSocket: Socket });
    hear(Socket.made[0]);
    await assert.rejects(connecting, expected);
    assert.equal(Socket.made.length, 1);
  }
  await assert.rejects(connect('ws://host', { WebSocket: null }), MotionSpliceError);
});

test('a malformed message is an event, and the next is played', async () => {
  const { service, socket, hero } = await withCharacters();
  const errors = [];
  service.on('error', (error) => errors.push(error));
  for (const bad of [FRAMES.slice(0, 99), new ArrayBuffer(0), '{', { event: 'bank', bank: 'x', joints: [] }]) socket.hear(bad);
  assert.equal(errors.length, 4);
  assert.ok(errors.every((error) => error instanceof FormatError));
  assert.equal(hero.pose(), undefined);
  socket.hear(FRAMES);
  assert.equal(hero.pose().rig, service.rig);
});
