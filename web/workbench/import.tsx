// Files of other programs: which import reads them, with what options, and what it says is wrong with them.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import * as api from "./api";
import type { Named } from "./dropped";
import { begin, busy, openImport, problem, take } from "./store";

const kinds = signal<api.ImportKind[]>([]);
const files = signal<Named[]>([]);
const dropped = signal("");
const kind = signal("");
const options = signal<Record<string, string>>({});
const trouble = signal("");
const isImporting = signal(false);
export const importing = () => isImporting.value;

/** What it is, an example, and how it is counted where that is often mistaken. */
const fields: Record<string, [string, string, string?]> = {
  board: ["Inner corners, columns x rows", "9x6", "A board of 10 x 7 squares has 9x6 inner corners."],
  spacing: ["Side of a square, m", "0.025", "Between two corners: 25 mm is 0.025."],
  target: ["What is on the target", "chessboard", "chessboard, circles or asymmetric_circles"],
  size: ["Size of the images, px", "640x480"],
  camera: ["Camera, where there are several", "left"],
  part: ["Part of a log", "joints", "joints, odometry or frames"],
  unit: ["Unit of angles", "deg"],
  "time-unit": ["Unit of times", "ms"],
  "length-unit": ["Unit of lengths", "mm"],
  map: ["Names of columns", ""],
  reverse: ["Joints that count the other way", "pan,tilt"],
  "off-where": ["Rows without drive", "command=0"],
  base: ["Between the wheels, m", "0.3"],
  radius: ["Radius of the wheels, m", "0.035"],
  "metres-per-tick": ["Metres a tick, in place of the radius", "0.0001"],
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
      begin();
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
  trouble.value = "";
  isImporting.value = true;
  trouble.value = await openImport(dropped.value, kind.value, given);
  isImporting.value = false;
  if (trouble.value) return;
  dropped.value = "";
  begin();
}

const chosen = () => kinds.value.find((one) => one.name === kind.value);

/** The options that the import's words ask for. */
const askedFor = (name: string) => new RegExp(`--${name}\\b`).test(trouble.value);

/** What the files lack, in the form's words. */
const plainly = (text: string) => text.replace(/--([a-z-]+)( [A-Z][A-Zx]+)?/g,
  (word, name: string) => (fields[name] ? `“${fields[name][0]}”` : word));

export function ImportForm() {
  const form = useRef<HTMLFormElement>(null);
  useEffect(() => {
    if (trouble.value) (form.current?.querySelector<HTMLElement>("[aria-required=true]") ?? form.current?.querySelector<HTMLElement>("select"))?.focus();
  }, [trouble.value]);
  if (!dropped.value) return null;
  const now = chosen();
  const names = files.value.map(({ path }) => path);
  const place = (name: string) => Object.keys(fields).indexOf(name);
  const options = [...(now?.options ?? [])].sort((a, b) => place(a) - place(b));
  return (
    <form class="import" aria-label="Import" ref={form} onSubmit={(e) => { e.preventDefault(); void tryImport(); }}>
      <h2>Import {names.length === 1 ? <code>{names[0]}</code> : <>{names.length} files: <code>{names[0]}</code>, …</>}</h2>
      {trouble.value && <p class="message trouble" role="alert">{plainly(trouble.value)}</p>}
      {!now && <p class="message trouble" role="alert">Nothing that SEAM imports looks like {names.length === 1 ? "this file" : "these files"}.
        If you know what {names.length === 1 ? "it is" : "they are"}, choose it below.</p>}
      <div class="fields">
        <label class="wide">These files are
          <select value={kind.value} required onChange={(e) => { kind.value = e.currentTarget.value; trouble.value = ""; }}>
            <option value="" disabled>choose …</option>
            {kinds.value.map((one) => <option key={one.name} value={one.name}>{nameOf(one)}</option>)}
          </select></label>
        {options.map((name) => <Option key={name} name={name} quantities={now!.quantities} />)}
      </div>
      {now && <p class="quiet small">SEAM reads {now.help}. Leave empty what the files say themselves.
        {now.quantities.length > 0 && <> Columns are named like <code>{now.quantities[0]}=THEIRS</code>; ours are{" "}
          <code>{now.quantities.join(", ")}</code>.</>}</p>}
      <div class="actions">
        <button type="submit" class="primary" disabled={busy.value !== "" || !now}>{isImporting.value ? "Importing …" : "Import"}</button>
        <button type="button" disabled={busy.value !== ""} onClick={() => (dropped.value = "")}>Cancel</button>
      </div>
    </form>
  );
}

/** A kind of files without what is the command's. */
function nameOf({ what, name, help }: api.ImportKind): string {
  const text = (what || help).replace(/ \(with .*\)$/, "");
  return `${text[0].toUpperCase()}${text.slice(1)} (${name})`;
}

function Option({ name, quantities }: { name: string; quantities: string[] }) {
  const [meaning, example, hint] = fields[name] ?? [name, ""];
  const asked = askedFor(name);
  return (
    <label class={asked ? "asked" : undefined}>
      <span>{meaning} {asked && <b>needed</b>} <code class="quiet">--{name}</code></span>
      <input value={options.value[name] ?? ""} placeholder={name === "map" ? `like ${quantities[0]}=THEIRS` : example && `like ${example}`}
        autocomplete="off" aria-required={asked} aria-label={`${meaning} --${name}`}
        onInput={(e) => (options.value = { ...options.value, [name]: e.currentTarget.value })} />
      {hint && <span class="quiet small">{hint}</span>}
    </label>
  );
}
