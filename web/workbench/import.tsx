// Files of other programs: which import reads them, with what options, and what it says is wrong with them.
import { signal } from "@preact/signals";
import * as api from "./api";
import type { Named } from "./dropped";
import { busy, openImport, problem, screen, take } from "./store";

const kinds = signal<api.ImportKind[]>([]);
const files = signal<Named[]>([]);
const dropped = signal("");
const kind = signal("");
const options = signal<Record<string, string>>({});
const trouble = signal("");

/** What a person would type, and which quantity it is, where the name alone does not say so. */
const examples: Record<string, [string, string]> = {
  board: ["inner corners, columns x rows", "9x6"],
  spacing: ["between corners, m", "0.025"],
  target: ["on the target", "chessboard, circles or asymmetric_circles"],
  size: ["of the images, px", "640x480"],
  camera: ["where there are several", "left"],
  part: ["of a log", "joints, odometry or frames"],
  unit: ["of angles", "deg"],
  "time-unit": ["of times", "ms"],
  "length-unit": ["of lengths", "mm"],
  map: ["names of columns", ""],
  reverse: ["joints that count the other way", "pan,tilt"],
  "off-where": ["rows without drive", "command=0"],
  base: ["between the wheels", "0.3"],
  radius: ["of the wheels", "0.035"],
  "metres-per-tick": ["in place of the radius", "0.0001"],
};

/** Sends the files; a set is opened, others are imported at once or with the options that a person gives. */
export async function receive(list: Named[]): Promise<void> {
  if (list.length === 0) return;
  problem.value = "";
  busy.value = "reading the files";
  try {
    const known = await api.imports();
    const bytes = list.reduce((sum, { file }) => sum + file.size, 0);
    if (bytes >= known.most_bytes) {
      throw new Error(`These files have ${Math.ceil(bytes / 1e6)} MB; at most ${Math.floor(known.most_bytes / 1e6)} MB can be ` +
        "dropped. Use seam import in a terminal, then open its folder.");
    }
    const answer = await api.upload(list);
    if (!("dropped" in answer)) {
      take(answer);
      screen.value = "work";
      return;
    }
    [kinds.value, files.value, dropped.value, kind.value] = [known.kinds, list, answer.dropped, answer.kind];
    [options.value, trouble.value] = [{}, ""];
  } catch (error) {
    problem.value = (error as Error).message;
    return;
  } finally {
    busy.value = "";
  }
  if (kind.value) await tryImport();
}

async function tryImport(): Promise<void> {
  const given = Object.fromEntries(Object.entries(options.value).filter(([name, value]) => value && chosen()?.options.includes(name)));
  trouble.value = await openImport(dropped.value, kind.value, given);
  if (trouble.value) return;
  dropped.value = "";
  screen.value = "work";
}

const chosen = () => kinds.value.find((one) => one.name === kind.value);

export function ImportForm() {
  if (!dropped.value) return null;
  const now = chosen();
  const names = files.value.map(({ path }) => path);
  return (
    <form class="import" aria-label="Import" onSubmit={(e) => { e.preventDefault(); void tryImport(); }}>
      <h2>Import {names.length === 1 ? <code>{names[0]}</code> : <>{names.length} files: <code>{names[0]}</code>, …</>}</h2>
      {trouble.value && <p class="message trouble" role="alert">{trouble.value}</p>}
      <div class="fields">
        <label class="wide">These files are
          <select value={kind.value} required onChange={(e) => { kind.value = e.currentTarget.value; trouble.value = ""; }}>
            <option value="" disabled>choose …</option>
            {kinds.value.map((one) => <option key={one.name} value={one.name}>{one.what} ({one.name})</option>)}
          </select></label>
        {(now?.options ?? []).map((name) => <Option key={name} name={name} quantities={now!.quantities} />)}
      </div>
      {now && <p class="quiet small">{now.name} reads {now.help}. Leave empty what the files say themselves.
        {now.quantities.length > 0 && <> Names for <code>--map</code>: <code>{now.quantities.join(", ")}</code>.</>}</p>}
      <div class="actions">
        <button type="submit" class="primary" disabled={busy.value !== "" || !now}>Import</button>
        <button type="button" disabled={busy.value !== ""} onClick={() => (dropped.value = "")}>Cancel</button>
      </div>
    </form>
  );
}

function Option({ name, quantities }: { name: string; quantities: string[] }) {
  const [meaning, example] = examples[name] ?? ["", ""];
  return (
    <label><span><code>--{name}</code> <span class="quiet">{meaning}</span></span>
      <input value={options.value[name] ?? ""} placeholder={name === "map" ? `${quantities[0]}=THEIRS` : example} autocomplete="off"
        onInput={(e) => (options.value = { ...options.value, [name]: e.currentTarget.value })} /></label>
  );
}
