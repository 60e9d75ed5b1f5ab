// Fetches a splice and streams it from a live service that wants a token. Usage: node http.mjs URL TOKEN
import WebSocket from 'ws';
import { connect, splice, stream, take } from '../motionsplice.js';

const [url, token] = process.argv.slice(2);
const what = { locomotion: 'walk', action: 'carry_box~mirror' };
const refused = [];
for (const doing of [
  () => splice(url, what),
  () => stream(url, { ...what, locomotion: 'wlak' }, { token }),
  () => splice(url.replace(/\d+$/, '9'), what, { token }),
  () => connect(url, { WebSocket, token: 'wrong' }),
]) await doing().catch((error) => refused.push(`${error.name} ${error.type ?? ''} ${error.message}`));

const worst = {};
const flat = ({ held }) => held.map(([frames, index]) => Array.from(frames.rotations).slice(index * 4 * frames.rig.joints.length).slice(0, 4 * frames.rig.joints.length));
for (const encoding of ['float32', 'int16']) {
  const motion = await splice(url, what, { token, encoding, parts: 'both' });
  worst[encoding] = 0;
  for (let number = 0; number < motion.held.length; number++) {
    const pose = motion.pose(number / motion.rate);
    pose.worldPositions().forEach((one, at) => { worst[encoding] = Math.max(worst[encoding], Math.abs(one - pose.positions[at])); });
  }
  const { motion: streamed, frames } = await stream(url, { ...what, ahead: 7 }, { token, encoding });
  for await (const message of frames) if (message.rig !== streamed.rig) throw new Error('another rig');
  if (JSON.stringify(flat(streamed)) !== JSON.stringify(flat(motion))) throw new Error('the stream differs from the splice');
}
const commands = [{ do: 'create', locomotion: 'walk', loop: false }, { do: 'act', action: 'carry_box~mirror', blend: 0 }];
const taken = await take(url, { frames: 60, commands }, { token });
const [pose, same] = [taken.motion.pose(0.5), (await splice(url, what, { token, rate: 60 })).pose(0.5)];
worst.take = Math.max(...pose.rotations.slice(4).map((one, at) => Math.abs(one - same.rotations[4 + at]))); // the root may head elsewhere
if (taken.phases.length !== 60 || !(taken.actionTimes[59] > taken.actionTimes[0]) || !taken.events.some(({ event }) => event === 'left_down')) throw new Error('a take has no moments');
if ((await splice(url, what, { token })).rig !== taken.motion.rig) throw new Error('motions of one bank have two rigs');
let seen = 0;
const { frames } = await stream(url, { ...what, pace: 'realtime' }, { token });
for await (const message of frames) if ((seen += message.count) === 3) break; // which ends the request
const service = await connect(url, { WebSocket, token });
service.close();
console.log(JSON.stringify({ refused, worst, seen }));
