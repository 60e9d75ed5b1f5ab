// Calls every operation by the types that openapi-typescript has made: `schema.d.ts` beside this file.
// Arguments: the service's URL, its token, and a folder with `batch.msgpack`, `hero.glb` and `wave.bvh`.
// Writes binary answers there, and prints the operations called.

import { readFileSync, writeFileSync } from "node:fs";
import createClient from "openapi-fetch";
import type { components, paths } from "./schema.js";

const [url, token, folder] = process.argv.slice(2);
const headers = { Authorization: `Bearer ${token}` };
const called = new Set<string>();
const client = createClient<paths>({ baseUrl: url, headers });
const json = createClient<paths, "application/json" | "application/problem+json">({ baseUrl: url, headers });
for (const one of [client, json]) {
  one.use({
    onRequest({ request, schemaPath }) {
      called.add(`${request.method} ${schemaPath}`);
    },
  });
}

function check(holds: boolean, what: string): asserts holds {
  if (!holds) throw new Error(what);
}

function good<T>(answer: { data?: T; error?: components["schemas"]["Problem"] }): T {
  if (answer.error !== undefined) throw new Error(answer.error.detail);
  return answer.data as T;
}

function save(name: string, answer: { data?: ArrayBuffer; error?: components["schemas"]["Problem"] }): void {
  writeFileSync(`${folder}/${name}`, new Uint8Array(good(answer)));
}

const binary = { parseAs: "arrayBuffer" } as const;
const bytes = { bodySerializer: (body: unknown) => body as Uint8Array<ArrayBuffer> };
const splice = { locomotion: "walk", action: "wave", method: "splice", posture: "absolute" } as const;
const encoded = { axes: "unreal", parts: "both", encoding: "float32" } as const;
const part = { rate: 30, first: 15, count: 4 };

const server = good(await client.GET("/v1/server"));
const bank = good(await client.GET("/v1/bank"));
check(server.bank === bank.digest, "another bank");
const skeleton = good(await client.GET("/v1/skeleton", { params: { query: { axes: "unity" } } }));
const offsets: number[][] = skeleton.offsets;
check(offsets.length === bank.joints, "offsets");
const clips = good(await client.GET("/v1/clips"));
const walk = good(await client.GET("/v1/clips/{name}", { params: { path: { name: "walk" } } }));
check(clips.some((clip) => clip.source === walk.source), "clips");
const report = good(await client.GET("/v1/report"));
const values: number[] = report.pairs[0].over_time["splice"];
check(report.bank === bank.digest && values.length > 0, "report");
save("manifest.msgpack", await client.GET("/v1/manifest", binary));
save("lower.npy", await client.GET("/v1/tables/{name}", { params: { path: { name: "lower" } }, ...binary }));

const moment = { ...splice, ...encoded, time: 0.5 };
const pose = good(await json.GET("/v1/pose", { params: { query: moment } }));
const root: number[] = pose.root_positions;
const rotations: number[][] | undefined = pose.rotations;
check(root.length === 3 && rotations?.length === bank.joints, "pose");
writeFileSync(`${folder}/pose.json`, JSON.stringify(pose));
const hoped = good(await json.GET("/v1/expectation", { params: { query: { locomotion: "walk", action: "wave" } } }));
check(hoped.expected !== null && hoped.expected.error < hoped.expected.replaced, "expectation");
save("pose.msgpack", await client.GET("/v1/pose", { params: { query: { ...moment, format: "msgpack" } }, ...binary }));

const query = { params: { query: encoded } };
const body: components["schemas"]["Batch"] = {
  clips: ["walk", "wave"], locomotion: [0, 0], action: [1, -1], time: [0.5, 0.5], posture: "absolute",
};
const poses = good(await json.POST("/v1/poses", { ...query, body }));
const many: number[][][] | undefined = poses.rotations;
check(many?.length === 2, "poses");
writeFileSync(`${folder}/poses.json`, JSON.stringify(poses));
const packed = readFileSync(`${folder}/batch.msgpack`);
save("poses.msgpack", await client.POST("/v1/poses", {
  params: { query: { ...encoded, format: "msgpack" } },
  headers: { "Content-Type": "application/msgpack" },
  body: packed as unknown as string,
  ...bytes,
  ...binary,
}));

const order: components["schemas"]["TakeOrder"] = {
  rate: 60, frames: 60, commands: [{ do: "create", locomotion: "walk" }, { at: 1, do: "act", action: "wave", when: "foot" }],
};
const take = good(await json.POST("/v1/take", { ...query, body: order }));
const times: (number | null)[] = take.action_times;
check(times.length === 60 && times[0] === null, "times");
check(take.events.find((one) => one.event === "action_began")?.action === "wave", "events");
const rig = readFileSync(`${folder}/hero.glb`).toString("base64");
const onRig = good(await json.POST("/v1/take", { ...query, body: { ...order, rig } }));
const turns: number[][][] | undefined = onRig.node_rotations;
check(turns?.length === 60 && turns[0]?.length === onRig.rig?.turned.length, "nodes");

const frames = good(await json.GET("/v1/splice", { params: { query: { ...splice, ...encoded, ...part } } }));
const all: number[][][] | undefined = frames.rotations;
check(frames.count === 4 && all?.length === 4, "frames");
writeFileSync(`${folder}/splice.json`, JSON.stringify(frames));
const packedSplice = { ...splice, ...encoded, ...part, format: "msgpack" } as const;
save("splice.msgpack", await client.GET("/v1/splice", { params: { query: packedSplice }, ...binary }));
for (const format of ["bvh", "glb", "gltf", "vrma"] as const) {
  const asked = { params: { query: { ...splice, ...part, format } } };
  save(`splice.${format}`, await client.GET("/v1/splice", { ...asked, ...binary }));
}
const fast = { ...splice, ...encoded, ...part, pace: "fast", ahead: 2 } as const;
save("frames.stream", await client.GET("/v1/stream", { params: { query: fast }, ...binary }));

const unknown = await client.GET("/v1/clips/{name}", { params: { path: { name: "wlak" } } });
check(unknown.error?.status === 404 && unknown.error.detail.includes("Did you mean 'walk'"), "problem");
// @ts-expect-error: no such axes
await client.GET("/v1/skeleton", { params: { query: { axes: "maya" } } });

const wave = readFileSync(`${folder}/wave.bvh`);
const job = good(await client.POST("/v1/clips", {
  params: { query: { name: "wave.bvh", kind: "action" } },
  headers: { "Content-Type": "application/octet-stream" },
  body: wave as unknown as string,
  ...bytes,
}));
check(job.bank === bank.digest, "job");
good(await client.GET("/v1/job"));
const events = good(await client.GET("/v1/job/events", { parseAs: "stream" }));
const reader = events!.getReader();
const first = new TextDecoder().decode((await reader.read()).value);
check(first.startsWith("data: "), "events");
await reader.cancel();

for (const path of ["/healthz", "/readyz"] as const) {
  check((await client.GET(path)).response.status === 204, path);
}
check(good(await client.GET("/metrics", { parseAs: "text" }))!.includes("motionsplice_"), "metrics");
console.log(JSON.stringify([...called].sort()));
