// A session over points of a made camera, served as docs/reference/workbench_api.md says: the workbench's tests and its development
// need no engine. `node tests/mock_workbench.mjs SHARE [rows]` prints its address.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { generator } from "./report_fixtures.mjs";

const noise = 0.15;
const image = { width_px: 178, height_px: 144 };
const perGroup = 20;

/** What each effect of this small world takes from the residuals: rows' share of the shutter's shift that remains. */
const effects = {
  rolling_shutter: { left: () => 0, parameters: { line_delay_s: { value: 2.401e-4, sigma: 6.1e-7 } } },
  frame_latency: { left: (row) => (row - 72) / row, parameters: { latency_s: { value: 0.01712, sigma: 1.1e-4 } } },
  exposure: { left: (row) => (row - 72) / row, parameters: { exposure_s: { value: 0.03424, sigma: 2.2e-4 } } },
  clock_drift: { left: (row, time) => 1 - 0.02 * time, parameters: { drift_ppm: { value: 928.8, sigma: 13 } } },
};
const weak = ["encoder_scale", "radial_distortion", "tangential_distortion", "mount_offset", "thin_prism"];

function world(n) {
  const { uniform, normal } = generator(11);
  const names = ["line", "group", "held_out", "u_px", "v_px", "row", "column", "time", "pan_rate", "tilt", "range"];
  const columns = Object.fromEntries(names.map((name) => [name, new Float32Array(n)]));
  const own = [new Float32Array(n), new Float32Array(n)], shift = new Float32Array(n);
  for (let i = 0; i < n; ++i) {
    const group = Math.floor(i / perGroup), time = 0.2 * group;
    const u = 177 * uniform(), v = 143 * uniform(), rate = 2.6 * Math.sin(1.7 * time);
    const values = [i + 2, group + 1, group % 5 === 2 ? 1 : 0, u, v, v, u, time, rate, 0.3 * Math.sin(time), 1 + 2 * uniform()];
    names.forEach((name, k) => (columns[name][i] = values[k]));
    shift[i] = 2.4e-4 * v * rate * 30;
    [own[0][i], own[1][i]] = [noise * normal(), noise * normal()];
  }
  return { n, columns, own, shift };
}

/** Residuals of a model with these effects; NaN where a row is left out. */
function residuals(world, model, leftOut) {
  const { n, columns, own, shift } = world;
  const r = [new Float32Array(n), new Float32Array(n)];
  let squares = 0, count = 0;
  for (let i = 0; i < n; ++i) {
    const share = model.reduce((left, name) => left * (effects[name]?.left(columns.row[i], columns.time[i]) ?? 1), 1);
    r[0][i] = own[0][i] + shift[i] * share;
    r[1][i] = own[1][i] + 0.1 * shift[i] * share;
    if (leftOut.some(({ ranges }) => ranges.some(([from, to]) => i >= from && i <= to))) r[0][i] = r[1][i] = NaN;
    else if (columns.held_out[i]) {
      squares += (r[0][i] ** 2 + r[1][i] ** 2) / noise ** 2;
      count += 2;
    }
  }
  return { r, error: Math.sqrt(squares / count) };
}

function table(n, head, columns) {
  let text = JSON.stringify({ n, columns: Object.keys(columns), channels: ["u_px", "v_px", "radial_px"], ...head });
  text += " ".repeat((4 - (Buffer.byteLength(text) % 4)) % 4);
  const length = Buffer.alloc(4);
  length.writeUInt32LE(Buffer.byteLength(text));
  return Buffer.concat([length, Buffer.from(text), ...Object.values(columns).map((c) => Buffer.from(c.buffer))]);
}

/** Columns of residuals and their errors; here the radial part stands for that along the image's row. */
const residualColumns = (n, r) => ({ "r:u_px": r[0], "r:v_px": r[1], "r:radial_px": r[0],
  ...Object.fromEntries(["u_px", "v_px", "radial_px"].map((name) => [`s:${name}`, new Float32Array(n).fill(noise)])) });

function structureOf(model) {
  if (model.includes("rolling_shutter")) return [];
  return [["u_px", "mean", "row*pan_rate", 0.798], ["u_px", "mean", "pan_rate", 0.61], ["v_px", "mean", "row*pan_rate", 0.081],
    ["u_px", "spread", "row", 0.33], ["radial_px", "mean", "column", 0.21], ["u_px", "mean", "sign(pan_rate)", 0.4],
    ["u_px", "mean", "time", 0.12]].map(([residual, moment, covariate, strength]) =>
    ({ residual, moment, covariate, strength, p_value: 1e-300 }));
}

/** One session; `change` is called after each write. */
export class MockSession {
  constructor(n = 2400) {
    this.world = world(n);
    this.sets = { open: true };
    this.folder = "/data/points-a";
    this.seen = 0; // Frames that were asked for.
    this.revision = 1;
    this.versions = [];
    this.past = [];
    this.future = [];
    this.leftOut = [];
    this.selection = [];
    this.fits = new Map();
    this.add(null, "nominal", "seam compare --model versions/001.yaml --data points-a");
    this.current = "1";
  }

  add(parent, name, command) {
    const model = [...(parent ? this.find(parent).model : []), ...(parent ? [name] : [])];
    const { error } = residuals(this.world, model, this.leftOut);
    const id = String(this.versions.length + 1);
    const structure = structureOf(model);
    this.versions.push({ id, parent, name, command, note: "", error, model, structure, doubts: [],
      verdict: structure.length ? "missing_effect" : "adequate", noise: { u_px: noise, v_px: noise },
      headline: structure.length ? "What matters: rolling_shutter is missing; it moves predictions by 26 x noise"
        : "Adequate: no structure is left in the residuals", left_out: this.leftOut.reduce((sum, one) => sum + one.count, 0),
      effects: { pinhole: { fx_px: 161.9, fy_px: 162.5 }, ...Object.fromEntries(model.map((one) => [one, effects[one]?.parameters ?? {}])) } });
    return id;
  }

  find(id) {
    return this.versions.find((one) => one.id === String(id));
  }

  get command() {
    return this.find(this.current).command;
  }

  state() {
    const columns = Object.entries(this.world.columns).map(([name, values]) => ({ name, file: "points.csv", missing: 0,
      low: Math.min(...values.slice(0, 2000)), high: Math.max(...values.slice(0, 2000)),
      unit: { u_px: "px", v_px: "px", row: "px", column: "px", time: "s", pan_rate: "rad/s", tilt: "rad", range: "m" }[name] ?? "" }));
    return { revision: this.revision, current: this.current, can_undo: this.past.length > 0, can_redo: this.future.length > 0,
      command: this.sets.open ? this.command : "", job: null, selection: this.selection, left_out: this.leftOut,
      versions: this.sets.open ? this.versions.map(({ model: _, ...one }) => one) : [],
      named: ["/data"],
      recent: [{ name: "points-a", path: "/data/points-a", kind: "points", title: "Calibration room" }],
      samples: ["points", "joints", "photometry"].map((kind) => ({ name: kind, path: `sample:${kind}`, title: `A sample of ${kind}`, kind })),
      set: this.sets.open ? { title: "Calibration room seen from a swinging head <img src=x>", kind: "points", folder: this.folder,
        file: "points.csv", rows: this.world.n, groups: this.world.n / perGroup, group: "frame", image, columns,
        noise: { u_px: noise, v_px: noise }, noise_estimated: false,
        doubts: [{ text: "Frame 7 has 20 points within 30 px of the edge: few views constrain the corners.", rows: [[120, 139]] }] } : null };
  }

  move(to) {
    this.past.push({ current: this.current, leftOut: this.leftOut });
    this.future = [];
    this.current = to;
  }

  candidate(effect, rank) {
    const now = this.find(this.current);
    const { error } = residuals(this.world, [...now.model, effect], this.leftOut);
    const gain = (now.error - error) / Math.max(1e-9, now.error - 1);
    const significant = effect in effects && gain > 0.01 && now.error > 1.1;
    return { effect, rank, error, gain, p_value: significant ? 1e-300 : 0.4, significant, indistinguishable_from: [],
      parameters: effects[effect]?.parameters ?? { scale: { value: 0.001, sigma: 0.01 } }, why: "",
      ...(effect === "frame_latency" ? { stands_in_for: ["rolling_shutter"] } : {}) };
  }

  search(done = Infinity) {
    const has = this.find(this.current).model;
    const all = [...Object.keys(effects), ...weak].filter((name) => !has.includes(name));
    const candidates = all.slice(0, done).map((name, i) => this.candidate(name, i + 1));
    const tied = ["frame_latency", "exposure"].every((name) => candidates.some((c) => c.effect === name && c.significant));
    const prospects = all.slice(candidates.length).map((name) => ({ ...this.candidate(name), log_likelihood_gain: 10 }));
    return { version: this.current, candidates, prospects, suggestion: this.suggestion, advice: "Swing the head at two more rates: latency and exposure then part.",
      ties: tied ? [{ effects: ["frame_latency", "exposure"], advice: "Swing the head at two more rates." }] : [],
      not_testable: [{ effect: "clock_offset", parameter: "offset_s", why: "the recording lasts 8 s only" }],
      progress: done < all.length ? { done, of: all.length } : null };
  }
}

/** A striped frame, which the line delay shears. */
function seen({ changes, head_rate_radps, coarse }) {
  const [width_px, height_px] = coarse ? [89, 72] : [image.width_px, image.height_px];
  const shear = 400 * (changes.rolling_shutter?.line_delay_s ?? 0) * head_rate_radps;
  const head = JSON.stringify({ width_px, height_px }).padEnd(40), bytes = Buffer.alloc(4 + 40 + 3 * width_px * height_px);
  bytes.writeUInt32LE(40);
  bytes.write(head, 4);
  for (let i = 0; i < width_px * height_px; ++i) {
    const stripe = Math.sin((i % width_px) / 5 + shear * Math.floor(i / width_px)) > 0 ? 220 : 30;
    bytes.fill(stripe, 44 + 3 * i, 47 + 3 * i);
  }
  return bytes;
}

const refuse = (status, error, more = {}) => ({ status, body: { error, ...more } });

function write(session, path, body) {
  if ("revision" in body && body.revision !== session.revision) {
    return refuse(409, `The session is at revision ${session.revision}, the page at ${body.revision}: read it again.`,
      { revision: session.revision });
  }
  switch (path) {
    case "add":
      session.move(session.add(session.current, body.effect,
        `seam add ${body.effect} --model versions/00${session.current}.yaml --data points-a --out versions/00${session.versions.length + 1}.yaml`));
      break;
    case "undo": case "redo": {
      const [from, to] = path === "undo" ? [session.past, session.future] : [session.future, session.past];
      const next = from.pop();
      if (!next) return refuse(400, `There is nothing to ${path}.`);
      to.push({ current: session.current, leftOut: session.leftOut });
      Object.assign(session, next);
      break;
    }
    case "goto": session.move(String(body.version)); break;
    case "note": session.find(body.version).note = body.note; break;
    case "fit":
      session.move(session.add(session.current, "refitted", `seam fit --model versions/00${session.current}.yaml --data points-a`));
      break;
    case "leave-out": {
      const count = body.ranges.reduce((sum, [from, to]) => sum + to - from + 1, 0);
      session.move(session.current);
      session.leftOut = [...session.leftOut, { ranges: body.ranges, count, reason: body.reason }];
      break;
    }
    case "take-back":
      session.move(session.current);
      session.leftOut = session.leftOut.filter((one) => JSON.stringify(one.ranges) !== JSON.stringify(body.ranges));
      break;
    case "open":
      if (body.path.includes("nothing")) return refuse(400, "nothing: there is no such folder; give the folder of a measurement set");
      session.sets.open = true;
      if (body.path.includes("other")) [session.folder, session.world] = ["/data/other", world(3000)];
      break;
    case "upload":
      return { status: 200, body: { import: { dropped: "dropped", kind: "kalibr" } } };
    case "import":
      if (!body.options.map) return refuse(400, "points.csv:17: column u_px: found 'x', expected a number");
      session.sets.open = true;
      break;
    case "export":
      if (body.format === "opencv" && !body.drop)
        return refuse(400, "opencv cannot hold effect 'rolling_shutter': export with --drop rolling_shutter to leave it out, or --drop all");
      return { status: 200, body: { name: `points-a-${body.version}-${body.format}.yaml`, text: "camera_matrix: 1\n",
        notes: body.drop ? ["note: without rolling_shutter: up to 6 px"] : [] } };
    case "see":
      ++session.seen;
      return { status: 200, body: seen(body) };
    case "formula/check": {
      if (!/^[a-z][a-z0-9_]*$/.test(body.name)) return { status: 200, body: { ok: false, error: "name: expected a letter first" } };
      const at = body.text.indexOf("?");
      return { status: 200, body: at >= 0 ? { ok: false, error: `'?' is no operator`, line: 1, column: at + 1 } : { ok: true, parameters: ["k"] } };
    }
    case "formula/fit":
      session.move(session.add(session.current, body.name, `seam add formulas/${body.name}.yaml --model versions/00${session.current}.yaml --data points-a`));
      break;
    case "suggest": return { status: 200, body: { searched: true, proposals: [{ stage: "geometry", name: "proposed", text: "u: k * row * pan_rate", error: 1.01 }] } };
    case "plan": return { status: 200, body: { format: "seam-plan/1", effects: ["rolling_shutter", "exposure"].map((effect) => ({ effect,
      parameters: { line_delay_s: { sigma: 6e-7 } }, smallest_found: { line_delay_s: 2.1e-6 },
      ties: effect === "exposure" ? [{ effect: "frame_latency", apart_from: null }] : [] })) } };
    default: return { status: 200, body: {} };
  }
  ++session.revision;
  return { status: 200, body: session.state() };
}

function read(session, path, query) {
  const { n, columns } = session.world;
  const version = session.find(query.get("version") ?? session.current);
  switch (path) {
    case "state": return session.state();
    case "rows": {
      const { r } = residuals(session.world, version.model, session.leftOut);
      return table(n, {}, { ...columns, ...residualColumns(n, r) });
    }
    case "preview": {
      const effect = query.get("effect");
      const { r, error } = residuals(session.world, [...version.model, effect], session.leftOut);
      return table(n, { error, parameters: session.candidate(effect, 1).parameters, how: "linear" }, // Stated errors are those of the rows.
        Object.fromEntries(Object.entries(residualColumns(n, r)).filter(([name]) => name.startsWith("r:"))));
    }
    case "search": return session.search(session.slow ? 2 : Infinity);
    case "see": return { effects: [{ name: "rolling_shutter", in_model: false, help: "rows one after the other", parameters: [
      { name: "line_delay_s", value: 0, low: -4e-4, high: 4e-4, help: "s a row" }] },
    { name: "pinhole", in_model: true, help: "a lens", parameters: [{ name: "fx_px", value: 161.9, low: 113, high: 210, help: "px" }] }] };
    case "formats": return { formats: [{ name: "opencv", what: "YAML" }, { name: "ros", what: "camera_info YAML" }] };
    case "imports": return { most_bytes: 5000, kinds: [
      { name: "kalibr", what: "corners as CSV", help: "corners as CSV", options: ["board", "map"], quantities: ["u", "v"] },
      { name: "servo", what: "logs of a servo", help: "logs", options: ["unit", "map"], quantities: ["command", "measured"] }] };
    case "script": return `#!/bin/sh\nset -e\n${session.versions.map((one) => one.command).join("\n")}\n`;
    case "formula": return { stages: [{ name: "geometry", form: "", variables: [{ name: "row", unit: "px", meaning: "row of the image" },
      { name: "pan_rate", unit: "rad/s", meaning: "rate of the pan joint" }] }, { name: "timing", form: "", variables: [] }] };
  }
  return undefined;
}

export const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".woff2": "font/woff2" };
export const policy = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self'; " +
  "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/** Serves the page in `share`/workbench and a session on loopback; resolves to {url, session, emit, close}. */
export function serve(share, session = new MockSession()) {
  const listeners = new Set();
  let number = 0;
  const emit = (name, data) => listeners.forEach((one) => one.write(`id: ${++number}\nevent: ${name}\ndata: ${JSON.stringify(data)}\n\n`));
  const server = createServer(async (request, response) => {
    const { pathname, searchParams } = new URL(request.url, "http://localhost");
    const send = (status, body, type = "application/json") => {
      response.writeHead(status, { "Content-Type": type, "Content-Security-Policy": policy });
      response.end(body instanceof Buffer || typeof body === "string" ? body : JSON.stringify(body));
    };
    if (!pathname.startsWith("/api/")) {
      const file = normalize(pathname === "/" ? "/index.html" : pathname);
      try {
        return send(200, readFileSync(join(share, "workbench", file)), types[extname(file)] ?? "text/plain");
      } catch {
        return send(404, "not found", "text/plain");
      }
    }
    const path = pathname.slice(5);
    if (path === "events") {
      response.writeHead(200, { "Content-Type": "text/event-stream", "Cache-Control": "no-store" });
      response.write("retry: 500\n\n");
      listeners.add(response);
      request.on("close", () => listeners.delete(response));
      return undefined;
    }
    if (request.method === "GET") {
      const answer = read(session, path, searchParams);
      return answer === undefined ? send(404, { error: `there is no ${path}` })
        : send(200, answer, answer instanceof Buffer ? "application/octet-stream" : typeof answer === "string" ? "text/plain" : undefined);
    }
    const chunks = [];
    for await (const chunk of request) chunks.push(chunk);
    const text = Buffer.concat(chunks).toString();
    const body = request.headers["content-type"]?.startsWith("application/json") ? JSON.parse(text) : {};
    if (path === "selection") session.selection = body.ranges;
    const { status, body: answer } = write(session, path, body);
    return send(status, answer, answer instanceof Buffer ? "application/octet-stream" : undefined);
  });
  return new Promise((resolve) => server.listen(0, "127.0.0.1", () => resolve({
    url: `http://127.0.0.1:${server.address().port}/`, session, emit,
    close: () => { listeners.forEach((one) => one.end()); server.closeAllConnections(); server.close(); } })));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { url } = await serve(process.argv[2], new MockSession(Number(process.argv[3] ?? 2400)));
  console.log(url);
}
