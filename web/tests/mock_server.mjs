// A match of twenty minutes made of sines, served as docs/reference/viewer_api.md says: the viewer's tests and its
// development need no log. `node tests/mock_server.mjs SHARE [logs]` prints its address.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { basename, dirname, extname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { policy, types } from "./mock_workbench.mjs";
import { png } from "./png.mjs";

const width = 178;
const height = 144;
const step_s = 0.008;
const period_s = 0.04;
const truth_s = 0.032;
const robots = ["red", "blue"].flatMap((team) =>
  [0, 1, 2, 3].map((number) => ({ id: `${team}${number + 1}`, team, number, camera: { width_px: width, height_px: height } })));

function scenery() {
  const items = [];
  const add = (label, [x, y], [length, width], top_m, rgb) =>
    items.push({ label, top_m, rgb, footprint_m: [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(
      ([i, j]) => [x + i * length / 2, y + j * width / 2]) });
  add("carpet", [0, 0], [4.4, 2.9], 0, [46, 112, 66]);
  for (const y of [-1.35, 1.35]) add("line", [0, y], [4.2, 0.025], 0.001, [240, 240, 240]);
  for (const x of [-2.1, 0, 2.1]) add("line", [x, 0], [0.025, 2.7], 0.001, [240, 240, 240]);
  add("sky-blue goal", [2.25, 0], [0.3, 0.6], 0.3, [90, 180, 235]);
  add("yellow goal", [-2.25, 0], [0.3, 0.6], 0.3, [235, 200, 40]);
  for (const x of [-2.2, 0, 2.2]) for (const y of [-1.45, 1.45]) add("beacon", [x, y], [0.1, 0.1], 0.4, [240, 120, 170]);
  return items;
}

function info(id, length_s, seed) {
  return { id, file: `match_${id}.mcap`, bytes: 41234567, scenario: "match_4v4", scenario_text: "", seed,
    start_s: 0, end_s: length_s, step_s, complete: id === "a", losses: id === "a" ? [] : ["the last chunk is cut"],
    end_reason: "finished", fingerprint: "0123456789abcdef", versions: { seam: "0.1.0", format: "seam-log/1" },
    robots, joints: ["tilt", "pan", "roll"], sections: ["ball", ...robots.map((r) => `robot/${r.id}`)],
    has_frames: true, stages: ["rgb", "ycrcb", "labels", "depth"], field: { length_m: 4.2, width_m: 2.7 },
    scenery: scenery() };
}

/** Log b goes its own way after 100 s. */
function pose(log, i, t) {
  const bend = log === "b" && t > 100 ? 0.02 * Math.min(t - 100, 10) : 0;
  const phase = i * 0.8;
  const x = 1.5 * Math.sin(0.11 * t + phase) + bend;
  const y = 1.0 * Math.sin(0.17 * t + 2 * phase) - bend;
  const heading = Math.atan2(0.17 * Math.cos(0.17 * t + 2 * phase), 0.165 * Math.cos(0.11 * t + phase));
  return [x, y, heading, 0.2 * Math.sin(1.3 * t + i), 0.9 * Math.sin(2.1 * t + i), 0];
}

const ball = (t) => [1.7 * Math.sin(0.23 * t), 1.1 * Math.cos(0.31 * t), 0.042];

function truth(log, from, to, every, end) {
  const t = [];
  for (let k = Math.ceil(from / truth_s - 1e-9); k * truth_s < to && k * truth_s <= end; k += every) t.push(k * truth_s);
  return { t, ball: t.map(ball),
    robots: Object.fromEntries(robots.map((r, i) => [r.id, t.map((at) => pose(log, i, at))])) };
}

function events(length_s) {
  const all = [];
  for (let t = 0; t < length_s; t += 0.5) all.push({ t, kind: "radio", robot: robots[Math.round(2 * t) % 8].id, name: "message", detail: "" });
  all.push({ t: 0, kind: "referee", robot: "", name: "kick-off", detail: "red" });
  for (let t = 0.2; t < length_s; t += 10) all.push({ t, kind: "printed", robot: "red2", name: "printed", detail: `ball at ${t}` });
  const world = (t, robot, name, detail = "") => all.push({ t, kind: "world", robot, name, detail });
  for (let t = 21; t < length_s - 2; t += 60) {
    world(t, "red2", "ball_contact");
    world(t + 1.5, "red2", "kick", "leg_forward");
    world(t + 1.6, "red2", "ball_contact_end");
  }
  for (let t = 47; t < length_s; t += 94) all.push({ t, kind: "referee", robot: "", name: "goal", detail: t % 188 === 47 ? "red" : "blue" });
  for (let t = 80; t < length_s; t += 131) all.push({ t, kind: "referee", robot: "blue2", name: "pushing", detail: "taken out for 30 s" });
  if (length_s > 312) {
    all.push({ t: 312.4, kind: "fault", robot: "red3", name: "client silent", detail: "no decision for 500 ms" });
    all.push({ t: 312.9, kind: "policy", robot: "red3", name: "freeze", detail: "until it reconnects" });
  }
  return { events: all.sort((a, b) => a.t - b.t) };
}

function debug(log, robot, from, to) {
  const items = [];
  const i = robots.findIndex((r) => r.id === robot);
  for (let k = Math.ceil(from / 0.2); k * 0.2 < to; ++k) {
    const t = k * 0.2;
    const [x, y] = ball(t);
    const [rx, ry] = pose(log, i, t);
    const u = 60 + 40 * Math.sin(t);
    const frame = seenBy(t);
    items.push({ t, name: "ball distance", value: Math.hypot(x - rx, y - ry) });
    items.push({ t, name: "role", text: i % 4 === 0 ? "keeper" : "striker" });
    items.push({ t, name: "ball", frame, in_image: true, points: [[u, 70], [u + 24, 70], [u + 24, 94], [u, 94], [u, 70]] });
    items.push({ t, name: "beacon", frame, in_image: true, points: [[140, 30]] });
    items.push({ t, name: "ball estimate", in_image: false, points: [[x + 0.03, y]] });
  }
  return { items };
}

function decisions(from, to) {
  const made = [];
  for (let k = Math.max(0, Math.ceil(from / 0.2)); k * 0.2 < to; ++k) made.push({ t: k * 0.2, frame: seenBy(k * 0.2) });
  return { decisions: made };
}

/** Marks of a strip, at most so many. */
function lanes(from, to, points) {
  const every = (period, first) => {
    const apart = Math.max(period, (to - from) / points);
    const times = [];
    for (let t = first + Math.ceil(Math.max(0, from - first) / period) * period; t <= to; t += Math.ceil(apart / period) * period) times.push(t);
    return times;
  };
  return { decisions: every(0.2, 0), frames: every(period_s, stamp(0)), texts: every(0.2, 0) };
}

/** Holds from second 100 on for 2 s each minute, for whatever is asked; "=" alone is no condition. */
function find(when, end) {
  if (!when) return { names: ["event.goal", "red2.event.kick", "truth.red2.x_m"] };
  if (/[^=<>!]=[^=]/.test(when)) return { status: 400, error: `condition: '${when}' at column 12; expected an expression such as 'event.goal'` };
  const hits = [];
  for (let t = 100; t < end; t += when.includes("goal") ? 60 : 2000) hits.push({ begin_s: t, end_s: Math.min(t + 2, end), until_end_of_log: t + 2 > end });
  return { format: "seam-find/1", when, count: hits.length, more: false, robot: when.startsWith("red2") ? "red2" : "", hits };
}

const makers = {
  x_m: (p) => p[0], y_m: (p) => p[1], heading_rad: (p) => p[2], tilt_rad: (p) => p[3], pan_rad: (p) => p[4],
  roll_rad: (p) => p[5], "command.tilt_rad": (_p, t, i) => 0.22 * Math.sin(1.3 * t + i + 0.1),
  "command.pan_rad": (_p, t, i) => 0.95 * Math.sin(2.1 * t + i + 0.1),
  "command.vx_m_s": (_p, t) => 0.2 * Math.sign(Math.sin(0.4 * t)), "command.omega_rad_s": (_p, t) => 0.5 * Math.cos(0.3 * t),
  "debug.effort": (_p, t, _i, log) => Math.sin(t) + (log === "b" ? 0.5 : 0),
  "debug.seen": (_p, t) => Math.sign(Math.sin(t)), "debug.age": (_p, t) => t % 3, "debug.score": (_p, t) => Math.cos(t),
  "debug.ball distance": (p, t) => Math.hypot(ball(t)[0] - p[0], ball(t)[1] - p[1]),
};

function series(log, robot, names, from, to, points) {
  if (!names) return { names: Object.keys(makers) };
  const i = robots.findIndex((r) => r.id === robot);
  const n = Math.max(2, Math.min(points, Math.floor((to - from) / truth_s)));
  const t = Array.from({ length: n }, (_, k) => from + ((to - from) * k) / (n - 1));
  return { series: Object.fromEntries(names.split(",").map((name) =>
    [name, { t, values: t.map((at) => makers[name](pose(log, i, at), at, i, log)) }])) };
}

const stamp = (index) => 0.003 + index * period_s;
/** The newest frame whose rows have all been read at `t`: its stamp lies one period or more before. */
const seenBy = (t) => Math.max(0, Math.floor((t - 0.003) / period_s + 1e-9) - 1);
const frameAt = (query) => query.has("index") ? Number(query.get("index"))
  : Math.max(0, Math.floor((Number(query.get("t")) - 0.003) / period_s + 1e-9));

function picture(index, stage) {
  const t = stamp(index);
  const u0 = 72 + 40 * Math.sin(t);
  return png(width, height, (u, v) => {
    const near = Math.hypot(u - u0, v - 82) < 12;
    if (stage === "labels") return near ? [255, 140, 30] : v > 60 ? [40, 120, 60] : [120, 120, 130];
    if (stage === "depth") return Array(3).fill(near ? 90 : Math.min(255, 40 + Math.abs(144 - v)));
    const gain = 1 - 0.3 * ((u - 88.5) ** 2 + (v - 71.5) ** 2) / 12900;
    const base = near ? [236, 128, 30] : v > 60 ? [52, 128, 70] : [150, 155, 165];
    const noise = ((u * 7919 + v * 104729 + index * 31) % 13) - 6;
    return base.map((c) => Math.max(0, Math.min(255, Math.round(c * gain + noise))));
  });
}

function rows(index) {
  const start = BigInt(Math.round(stamp(index) * 1e9));
  return { index, stamp_ns: String(start), fingerprint: "00ff00ff00ff00ff", rows: Array.from({ length: height }, (_, v) => {
    const from = start + BigInt(v) * 241000n;
    return { start_ns: String(from), end_ns: String(from + 5000000n), x_m: 0, y_m: 0, z_m: 0.2, yaw_rad: 0.001 * v, pitch_rad: 0, roll_rad: 0 };
  }) };
}

function frames(from, to, end) {
  const list = [];
  for (let i = Math.max(0, Math.ceil((from - 0.003) / period_s)); stamp(i) < to && stamp(i) <= end && list.length < 5000; ++i) {
    list.push({ index: i, t: stamp(i), stamp_ns: String(Math.round(stamp(i) * 1e9)), recorded: i % 2 === 0, fingerprint: "00ff00ff00ff00ff" });
  }
  return { frames: list, more: false, period_s };
}

function state(log, t) {
  const step = Math.floor(t / step_s + 1e-9);
  return { time_ns: String(step * 8000000), step, fingerprint: "89abcdef01234567", sections: [
    { name: "ball", hash: "1111222233334444", fields: [["x_m", ball(t)[0]], ["y_m", ball(t)[1]]] },
    ...robots.map((r, i) => ({ name: `robot/${r.id}`, hash: "aaaabbbbccccdddd",
      fields: [["x_m", pose(log, i, t)[0]], ["y_m", pose(log, i, t)[1]], ["walk.count", step]] }))] };
}

function answer(path, query, logs) {
  const log = query.get("log") ?? "a";
  const own = logs.find((l) => l.id === log);
  const get = (name, other) => (query.has(name) ? Number(query.get(name)) : other);
  const [from, to] = [get("from", 0), get("to", own?.end_s ?? 0)];
  switch (path) {
    case "info": return { format: "seam-view/1", logs };
    case "truth": return truth(log, from, to, get("every", 1), own.end_s);
    case "state": return state(log, get("t", 0));
    case "events": return events(own.end_s);
    case "steps": {
      const t = [];
      for (let k = Math.ceil(from / step_s - 1e-9); k * step_s < to; ++k) t.push(Number((k * step_s).toFixed(6)));
      return { t };
    }
    case "decisions": return decisions(from, Math.min(to, own.end_s));
    case "lanes": return lanes(from, Math.min(to, own.end_s), get("points", 1000));
    case "find": return find(query.get("when"), own.end_s);
    case "debug": return debug(log, query.get("robot"), from, to);
    case "series": return series(log, query.get("robot"), query.get("names"), from, to, get("points", 1000));
    case "frames": return frames(from, to, own.end_s);
    case "frame_rows": return rows(frameAt(query));
    case "diff": return logs.length < 2 ? undefined : { equal: false, header: ["client of red1: striker and keeper"],
      compared_until_s: Math.min(...logs.map((l) => l.end_s)),
      first: { t: 100.008, time_ns: "100008000000", section: "robot/red1", field: "x_m", a: 0.1, b: 0.2 },
      first_decision: { t: 100, time_ns: "100000000000", robot: "red1", frame: { a: 2498, b: 2498, same: true },
        fields: [{ field: "pan_rad", a: "-0.889", b: "0.59" }, { field: "kick", a: "", b: "leg_forward" }] },
      spread: [{ t: 100.008, section: "robot/red1" }, { t: 104.2, section: "ball" }, { t: 131.6, section: "robot/blue2" }] };
  }
  return undefined;
}

/** Serves the folder of `page` and the interface on loopback, under the real server's content policy; resolves to {url, close}. */
export function serve(page, logCount = 1) {
  const logs = [info("a", 1200, "7"), info("b", 900, "8")].slice(0, logCount);
  const server = createServer((request, response) => {
    const url = new URL(request.url, "http://127.0.0.1");
    response.setHeader("Content-Security-Policy", policy);
    if (!url.pathname.startsWith("/api/")) {
      const file = url.pathname === "/" ? page : join(dirname(page), "assets", basename(url.pathname));
      response.setHeader("Content-Type", types[extname(file)] ?? "text/plain");
      return response.end(readFileSync(file));
    }
    const path = url.pathname.replace("/api/", "");
    if (path === "frame") {
      const index = frameAt(url.searchParams);
      response.setHeader("Content-Type", "image/png");
      response.setHeader("X-Seam-Index", index);
      response.setHeader("X-Seam-Stamp-Ns", Math.round(stamp(index) * 1e9));
      response.setHeader("X-Seam-Recorded", index % 2 === 0 ? "1" : "0");
      response.setHeader("X-Seam-Matches", index % 2 === 0 ? "-" : "1");
      return response.end(picture(index, url.searchParams.get("stage")));
    }
    const found = answer(path, url.searchParams, logs);
    response.statusCode = found ? found.status ?? 200 : 404;
    response.setHeader("Content-Type", "application/json");
    response.end(JSON.stringify(found ?? { error: `no ${path} here` }));
  });
  return new Promise((resolve) => server.listen(0, "127.0.0.1", () =>
    resolve({ url: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() })));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { url } = await serve(join(process.argv[2], "index.html"), Number(process.argv[3] ?? 1));
  console.log(url);
}
