// The session: the tree of versions with notes, two of them side by side, the script that repeats it.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { number } from "../shared/format";
import { ParameterList } from "../shared/parts";
import { DataTable } from "../shared/table";
import * as api from "./api";
import { Exports } from "./exports";
import type { Version } from "./model";
import { goTo, say, session, setNote } from "./store";

const script = signal<string | null>(null);
const beside = signal<string | null>(null);

/** A version and what was made of it, one by one; where several were made of one, each is a branch. */
function Branch({ from, all, current }: { from: Version; all: Version[]; current: string }) {
  const chain = [from];
  const childrenOf = (version: Version) => all.filter((one) => one.parent === version.id);
  let children = childrenOf(from);
  for (; children.length === 1; children = childrenOf(children[0])) chain.push(children[0]);
  return (
    <ol>
      {chain.map((version, i) => (
        <li key={version.id} aria-current={version.id === current ? "true" : undefined}>
          <Node version={version} current={current} />
          {i === chain.length - 1 && children.length > 0 &&
            <div class="forks">{children.map((child) => <Branch key={child.id} from={child} all={all} current={current} />)}</div>}
        </li>
      ))}
    </ol>
  );
}

export function SessionScreen() {
  const now = session.value!;
  return (
    <div class="page session-screen">
      <h1>Session</h1>
      <p class="lead">Each version is an ordinary model in a file. Undo moves a pointer; what is made from an older version becomes
        a branch. All of it is in the session's folder.</p>
      <section aria-label="Versions">
        <div class="tree">
          {now.versions.filter((one) => one.parent === null).map((one) => <Branch key={one.id} from={one} all={now.versions} current={now.current} />)}
        </div>
      </section>
      <SideBySide />
      <Script />
      <Exports />
    </div>
  );
}

function Node({ version, current }: { version: Version; current: string }) {
  return (
    <article class="node">
      <header>
        <span class="num quiet">{version.id}</span>
        <b>{version.name}</b>
        <span class="num">error {number(version.error, 4)}</span>
        {version.leftOut > 0 && <span class="tag">{version.leftOut} rows left out</span>}
        {version.id === current ? <span class="tag here">shown</span>
          : <button type="button" onClick={() => void goTo(version.id)}>Go there</button>}
        {version.id !== current && (
          <button type="button" class="link" aria-pressed={beside.value === version.id}
            onClick={() => (beside.value = beside.value === version.id ? null : version.id)}>compare with the shown</button>
        )}
      </header>
      {version.command && <code class="quiet made-by">{version.command}</code>}
      {/* Not `value`: a state that arrives while one types would put back the saved note. */}
      <textarea key={version.note} rows={1} placeholder="Note" aria-label={`Note on version ${version.id}`}
        defaultValue={version.note} onChange={(e) => void setNote(version.id, e.currentTarget.value)} />
    </article>
  );
}

function SideBySide() {
  const now = session.value!;
  const [one, other] = [now.current, beside.value].map((id) => now.versions.find((v) => v.id === id));
  if (!one || !other) return null;
  const names = [...new Set([...Object.keys(one.effects), ...Object.keys(other.effects)])];
  return (
    <section aria-label="Two versions">
      <h2>Versions {one.id} and {other.id}</h2>
      <DataTable columns={[{ label: "Effect" }, { label: `Version ${one.id}` }, { label: `Version ${other.id}` }]}
        rows={[{ cells: ["error", <span class="num">{number(one.error, 4)}</span>, <span class="num">{number(other.error, 4)}</span>] },
          ...names.map((name) => ({ cells: [<code>{name}</code>, ...[one, other].map((v) =>
            (v.effects[name] ? <ParameterList parameters={v.effects[name]} /> : <span class="quiet">absent</span>))] }))]} />
    </section>
  );
}

function Script() {
  const { revision } = session.value!;
  useEffect(() => {
    api.script().then((text) => (script.value = text), (error: Error) => (script.value = `# ${error.message}`));
  }, [revision]);
  const copy = () => navigator.clipboard.writeText(script.value ?? "").then(() => say("The script is in the clipboard."),
    () => say("The browser gave no access to the clipboard."));
  return (
    <section aria-label="Script">
      <header class="side-head"><h2>As a script</h2><button type="button" onClick={copy}>Copy as script</button></header>
      <p class="quiet">A shell script that ends in the same files.</p>
      {script.value === null ? <p class="empty" role="status">Reading …</p> : <pre class="script" tabIndex={0}>{script.value}</pre>}
    </section>
  );
}
