// See it: the image that the camera of a version would show, beside that of another version or of changed parameters.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { number, splitUnit, words } from "../shared/format";
import { Rich } from "../shared/rich";
import * as api from "./api";
import { FrameCanvas } from "./frame_canvas";
import { seen, unseen, want, type Changes } from "./see_frames";
import { searched, session, version } from "./store";

const sliders = signal<api.Slider[] | null>(null);
const before = signal("");
const changes = signal<Changes>({});
const headRate = signal(120);
const mostRate = 300; // deg/s
const pictures = ["before", "after", "difference"];
/** Where the page has the width of one alone. */
const picture = signal("after");

/** The version to compare with: that which a person chose, else the first. */
const other = () => (session.value!.versions.some((one) => one.id === before.value) ? before.value
  : session.value!.versions[0]?.id ?? "");

async function readSliders(id: string): Promise<void> {
  try {
    sliders.value = (await api.sliders(id)).effects;
  } catch (error) {
    unseen.value = (error as Error).message;
  }
}

/** The set, and which of its versions were fitted: others are drawn as they stand. */
const known = () => [session.value!.set!.folder, ...session.value!.versions.map((one) => Number(one.error !== null))].join(" ");

function show(): void {
  const id = version.value?.id;
  if (id) want({ set: known(), before: other(), after: id, changes: changes.value, headRate_radps: headRate.value * Math.PI / 180 });
}

export function SeeScreen() {
  const id = version.value?.id ?? "", folder = session.value!.set?.folder;
  useEffect(() => {
    changes.value = {};
    seen.value = null;
    void readSliders(id);
  }, [id, folder]);
  useEffect(show, [id, known(), before.value, changes.value, headRate.value]);
  return (
    <div class="page see-screen">
      <h1>See it</h1>
      <p class="lead">A chessboard between two posts, as the camera of a model shows it while the head turns. Left the model without
        your changes, then with them, then what differs. What is free in a model has its fitted values.</p>
      {unseen.value && <p class="trouble" role="alert">{unseen.value}</p>}
      <Frames />
      <div class="see-controls">
        <Head />
        <Effects />
      </div>
    </div>
  );
}

function Frames() {
  const now = seen.value;
  const name = (id: string) => session.value!.versions.find((one) => one.id === id)?.name ?? id;
  const changed = Object.keys(changes.value);
  const from = other(), to = version.value?.id ?? "";
  return (
    <div class="frames" data-quality={now ? (now.coarse ? "coarse" : "fine") : "none"} data-took-ms={now ? Math.round(now.took_ms) : ""}>
      <div class="frames-choice" role="group" aria-label="Picture">
        {pictures.map((name) => <button key={name} type="button" aria-pressed={picture.value === name} onClick={() => (picture.value = name)}>{name}</button>)}
      </div>
      <Frame of="before" title={<>before: version {from}, {name(from)}</>}>{now && <FrameCanvas now={now.before} label="rendered: before" />}</Frame>
      <Frame of="after" title={<>after: version {to}, {name(to)}{changed.length > 0 && <> with <b>{changed.join(", ")}</b> changed</>}</>}>
        {now && <FrameCanvas now={now.after} label="rendered: after" />}</Frame>
      <Frame of="difference" title="difference">{now && <FrameCanvas now={now.after} less={now.before} label="rendered: difference" />}</Frame>
    </div>
  );
}

function Frame({ of, title, children }: { of: string; title: preact.ComponentChildren; children: preact.ComponentChildren }) {
  return (
    <figure class={`figure frame${picture.value === of ? " chosen" : ""}`}>
      <h3>{title}</h3>
      {seen.value ? children : <p class="empty" role="status">{unseen.value ? "no image" : "rendering …"}</p>}
    </figure>
  );
}

function Head() {
  const versions = session.value!.versions;
  return (
    <section class="see-group">
      <h2>Compare</h2>
      <label class="slider"><span>before</span>
        <select aria-label="Version before" value={other()} onChange={(e) => (before.value = e.currentTarget.value)}>
          {versions.map((one) => <option key={one.id} value={one.id}>{one.id}: {one.name}</option>)}
        </select></label>
      <label class="slider"><span>head speed</span>
        <input type="range" min={-mostRate} max={mostRate} step={5} value={headRate.value} aria-valuetext={`${headRate.value} degrees a second`}
          onInput={(e) => (headRate.value = Number(e.currentTarget.value))} />
        <output class="num">{headRate.value} °/s</output></label>
    </section>
  );
}

function setValue(effect: string, parameter: string, value: number): void {
  changes.value = { ...changes.value, [effect]: { ...changes.value[effect], [parameter]: value } };
}

/** An effect with its fitted values, where the search has them. */
function addEffect(name: string): void {
  const found = searched.value?.candidates.find((one) => one.effect === name)?.parameters ?? {};
  const values = Object.entries(found).map(([key, value]) => [key, typeof value === "number" ? value : value.value] as const)
    .filter(([, value]) => value !== null);
  changes.value = { ...changes.value, [name]: Object.fromEntries(values) as Record<string, number> };
}

function Effects() {
  const all = sliders.value;
  if (!all) return null;
  const shown = all.filter((one) => one.parameters.length > 0 && (one.in_model || one.name in changes.value));
  const absent = all.filter((one) => !one.in_model && !(one.name in changes.value));
  const fitted = (searched.value?.candidates ?? []).map((one) => one.effect).filter((name) => absent.some((one) => one.name === name));
  const rest = absent.map((one) => one.name).filter((name) => !fitted.includes(name));
  return (
    <section class="see-group effects-shown">
      <header class="side-head"><h2>Parameters</h2>
        {Object.keys(changes.value).length > 0 && <button type="button" class="link" onClick={() => (changes.value = {})}>undo the changes</button>}
      </header>
      <label class="slider"><span>add an effect</span>
        <select value="" onChange={(e) => { addEffect(e.currentTarget.value); e.currentTarget.value = ""; }}>
          <option value="" disabled>choose …</option>
          {fitted.length > 0 && <optgroup label="as the search fitted it">{fitted.map((name) => <option key={name}>{name}</option>)}</optgroup>}
          <optgroup label="absent, to be moved by its sliders">{rest.map((name) => <option key={name}>{name}</option>)}</optgroup>
        </select></label>
      {shown.map((one) => (
        <fieldset key={one.name}>
          <legend><code class="effect">{one.name}</code> {one.name in changes.value && <span class="quiet">{one.in_model ? "changed" : "added"}</span>}</legend>
          {one.parameters.map((parameter) => <Slider key={parameter.name} effect={one.name} {...parameter} />)}
        </fieldset>
      ))}
    </section>
  );
}

function Slider({ effect, name, value, low, high, help }: { effect: string } & api.Slider["parameters"][0]) {
  const now = changes.value[effect]?.[name] ?? value;
  const { name: short, unit } = splitUnit(name);
  const [from, to] = [Math.min(low, now), Math.max(high, now)];
  return (
    <label class="slider" title={help}><span>{words(short)}</span>
      <input type="range" min={from} max={to} step={(to - from) / 200 || "any"} value={now} aria-label={`${effect} ${words(short)}`}
        onInput={(e) => setValue(effect, name, Number(e.currentTarget.value))} />
      <output class="num"><Rich text={`${number(now)} ${unit}`} /></output></label>
  );
}
