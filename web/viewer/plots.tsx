// Numbers over the part of the match around the moment: joints and odometry, and what is chosen by name.
import { effect, signal, type Signal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { palette, series as colours } from "../shared/palette";
import { ask, type SeriesData } from "./api";
import type { Replay } from "./replay";
import { chosen, playing, plotFrom, plotTo, replays, robot, seek, time } from "./store";
import { clock } from "./timeline";

export interface PlotSpec {
  title: string;
  unit: string;
  /** Which of the server's series belong here. */
  wants: (name: string) => boolean;
}

export const specs: PlotSpec[] = [
  { title: "Joints", unit: "rad", wants: (n) => /^(?!heading_|debug\.|command\.(left|right)_(front|hind)_).+_rad$/.test(n) },
  { title: "Position", unit: "m", wants: (n) => n === "x_m" || n === "y_m" },
  { title: "Heading", unit: "rad", wants: (n) => n === "heading_rad" },
  { title: "Walk command", unit: "m/s, rad/s", wants: (n) => /^command\.(vx|vy|omega)_/.test(n) },
];

const lists = new Map<string, Promise<string[]>>();

function namesOf(replay: Replay, id: string): Promise<string[]> {
  const key = `${replay.info.id} ${id}`;
  let names = lists.get(key);
  if (!names) {
    names = ask<{ names: string[] }>("series", { log: replay.info.id, robot: id }).then((a) => a.names);
    names.catch(() => lists.delete(key));
    lists.set(key, names);
  }
  return names;
}

const isCommand = (name: string) => name.startsWith("command.");

/** What is measured and commanded first, then the commands, then what nobody commands. */
function inOrder(names: string[]): string[] {
  const place = (name: string) => (isCommand(name) ? 1 : names.includes(`command.${name}`) ? 0 : 2);
  return [...names].sort((a, b) => place(a) - place(b));
}

interface Line {
  label: string;
  colour: string;
  dashed?: boolean;
  /** Another line of the same colour stands in the legend for it. */
  unnamed?: boolean;
}

interface Shown {
  lines: Line[];
  data: SeriesData[];
  note?: string;
}

const nothing: Shown = { lines: [], data: [] };

/** Loads what a plot shows of this robot and part of the match, at most once at a time. */
function useShown(load: (id: string, from: number, to: number) => Promise<Shown>, depends: unknown[]) {
  const shown = useMemo(() => signal<Shown>(nothing), depends);
  useEffect(() => {
    let gone = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const stop = effect(() => {
      const id = robot.value;
      const [from, to] = [plotFrom.value, plotTo.value];
      if (!id) return;
      clearTimeout(timer);
      timer = setTimeout(async () => {
        try {
          const loaded = await load(id, from, to);
          if (!gone && id === robot.peek()) shown.value = loaded;
        } catch {
          if (!gone) shown.value = nothing;
        }
      }, 120);
    });
    return () => {
      gone = true;
      clearTimeout(timer);
      stop();
    };
  }, [shown]);
  return shown;
}

async function seriesOf(replay: Replay, id: string, names: string[], from: number, to: number) {
  if (names.length === 0) return {};
  const answer = await ask<{ series: Record<string, SeriesData> }>("series",
    { log: replay.info.id, robot: id, names: names.join(","), from, to, points: 1200 });
  return answer.series;
}

function label(name: string): string {
  // The plot of the walk is titled so.
  const short = name.replace(/^command\.(?=vx_|vy_|omega_)/, "");
  return short.replace(/_(m_s|rad_s|rad|m)$/, "").replace("debug.", "").replace("command.", "command ");
}

export function SeriesPlot({ replay, spec }: { replay: Replay; spec: PlotSpec }) {
  const shown = useShown(async (id, from, to) => {
    const wanted = inOrder((await namesOf(replay, id)).filter(spec.wants)).slice(0, 7);
    const found = await seriesOf(replay, id, wanted, from, to);
    const names = wanted.filter((name) => found[name]);
    const mixed = names.some(isCommand) && !names.every(isCommand);
    return {
      lines: names.map((name) => ({ label: label(name), colour: colourOf(name, names),
        dashed: isCommand(name) && !/v[xy]_|omega/.test(name), unnamed: mixed && isCommand(name) })),
      data: names.map((name) => found[name]),
      note: mixed ? "dashed: commanded" : undefined,
    };
  }, [replay, spec]);
  return <Plot title={spec.title} unit={spec.unit} shown={shown} />;
}

/** One value of the robot, of both logs where there are two. */
function ValuePlot({ name }: { name: string }) {
  const logs = replays.value;
  const shown = useShown(async (id, from, to) => {
    const all = await Promise.all(logs.map(async (replay) =>
      (await namesOf(replay, id)).includes(name) ? (await seriesOf(replay, id, [name], from, to))[name] : undefined));
    const there = logs.map((replay, i) => ({ id: replay.info.id, i, data: all[i] })).filter((one) => one.data);
    return {
      lines: there.map(({ id: log, i }) => ({ label: logs.length > 1 ? log : "", colour: colours()[i], dashed: i > 0 })),
      data: there.map((one) => one.data!),
    };
  }, [logs, name]);
  return <Plot title={label(name)} unit={unitOf(name)} shown={shown} />;
}

const wanted = signal("");
const choosing = signal(false);

/** All that the logs have of this robot as numbers, to be chosen by name. */
export function ChosenPlots() {
  const logs = replays.value;
  const names = useMemo(() => signal<string[]>([]), [logs]);
  const id = robot.value;
  useEffect(() => {
    void Promise.all(logs.map((replay) => namesOf(replay, id).catch(() => [] as string[]))).then((lists) => {
      if (id === robot.peek()) names.value = [...new Set(lists.flat())].sort(byClient);
    });
  }, [logs, id, names]);
  const picked = names.value.filter((name) => (chosen.value ?? firstOf(names.value)).includes(name));
  const listed = names.value.filter((name) => label(name).toLowerCase().includes(wanted.value.toLowerCase()));
  const toggle = (name: string) =>
    (chosen.value = picked.includes(name) ? picked.filter((other) => other !== name) : [...picked, name]);
  return (
    <div class="chosen">
      <details open={choosing.value} onToggle={(e) => (choosing.value = e.currentTarget.open)}>
        <summary>Choose values <span class="quiet num">{picked.length} of {names.value.length} of {id}</span></summary>
        <input type="search" aria-label="Part of a value's name" placeholder="Part of a name" value={wanted.value}
          onInput={(e) => (wanted.value = e.currentTarget.value)} />
      <ul>
        {listed.map((name) => (
          <li key={name}><label>
            <input type="checkbox" checked={picked.includes(name)} onChange={() => toggle(name)} /> {label(name)}
            {unitOf(name) && <span class="quiet"> {unitOf(name)}</span>}
          </label></li>
        ))}
      </ul>
      </details>
      {picked.map((name) => <ValuePlot key={name} name={name} />)}
    </div>
  );
}

const isClients = (name: string) => name.startsWith("debug.");
/** What the client logged stands first. */
const byClient = (a: string, b: string) => Number(isClients(b)) - Number(isClients(a));
const firstOf = (names: string[]) => names.filter(isClients).slice(0, 4);

function unitOf(name: string): string {
  if (isClients(name)) return "";
  return name.endsWith("_rad_s") ? "rad/s" : name.endsWith("_m_s") ? "m/s" : name.endsWith("_rad") ? "rad"
    : name.endsWith("_m") ? "m" : "";
}

function Plot({ title, unit, shown }: { title: string; unit: string; shown: Signal<Shown> }) {
  const holder = useRef<HTMLDivElement>(null);
  useEffect(() => {
    let plot: uPlot | null = null;
    let drawn: string | null = null;
    const make = () => {
      plot?.destroy();
      plot = build(holder.current!, title, shown.peek());
      drawn = drawnAs(shown.peek());
    };
    const observer = new ResizeObserver(() => {
      const size = boxOf(holder.current!);
      if (plot && size.width > 40) plot.setSize(size);
    });
    observer.observe(holder.current!);
    const stopData = effect(() => {
      if (drawnAs(shown.value) !== drawn) make();
      else plot?.setData(join(shown.value.data));
    });
    const stopView = effect(() => {
      void shown.value;
      plot?.setScale("x", { min: plotFrom.value, max: plotTo.value });
    });
    const stopTime = effect(() => {
      void time.value;
      plot?.redraw(false, false);
    });
    return () => {
      [stopData, stopView, stopTime].forEach((stop) => stop());
      observer.disconnect();
      plot?.destroy();
    };
  }, [title, shown]);
  const { lines, note } = shown.value;
  return (
    <figure class="series" data-series={title} data-lines={lines.length}>
      <figcaption>
        <strong>{title}</strong> {unit && <span class="quiet">{unit}</span>}
        <span class="legend">
          {lines.filter((line) => !line.unnamed && line.label).map((line, i) =>
            <span key={i}><i style={{ background: line.colour }} />
              {line.dashed ? `${line.label} dashed` : line.label}</span>)}
          {note && <span class="quiet">{note}</span>}
          {lines.length === 0 && <span class="quiet">nothing logged</span>}
        </span>
      </figcaption>
      <div class="series-plot" ref={holder} />
    </figure>
  );
}

const drawnAs = (shown: Shown) => shown.lines.map((line) => `${line.label} ${line.colour}`).join();

/** A command has the colour of the joint it is for, and the joints of a head have theirs always. */
function colourOf(name: string, names: string[]): string {
  const joint = name.replace(/^command\.(?=.*_rad$)/, "");
  const head = ["tilt_rad", "pan_rad", "roll_rad"].indexOf(joint);
  const place = names.includes(joint) ? names.indexOf(joint) : names.indexOf(name);
  return colours()[(head >= 0 ? head : place) % colours().length];
}

function boxOf(element: HTMLElement) {
  return { width: element.clientWidth, height: Math.max(60, element.clientHeight) };
}

function join(data: SeriesData[]): uPlot.AlignedData {
  if (data.length === 0) return [[0], [null]];
  return uPlot.join(data.map((d) => [d.t, d.values] as uPlot.AlignedData), data.map(() => [1]));
}

/** A value that stays as it is lies in the middle of a small range, not at the edge of 0 to 100. */
function rangeOf(least: number | null, most: number | null): uPlot.Range.MinMax {
  if (least === null || most === null) return [null, null];
  if (most - least > 1e-9 * Math.max(Math.abs(least), Math.abs(most))) return uPlot.rangeNum(least, most, 0.1, true);
  const half = Math.max(0.1, 0.1 * Math.abs(least));
  return [least - half, least + half];
}

function build(holder: HTMLElement, title: string, shown: Shown): uPlot {
  const axis = { stroke: () => palette.ink3, font: "11px Inter, sans-serif",
    grid: { stroke: () => palette.grid, width: 1 }, ticks: { show: false } };
  return new uPlot({
    ...boxOf(holder),
    legend: { show: false },
    cursor: { y: false, drag: { x: false, y: false } },
    // Without values there is no vertical axis, whose place the first time's label needs.
    padding: [6, 18, 0, shown.lines.length > 0 ? 0 : 44],
    scales: {
      x: { time: false, min: plotFrom.peek(), max: plotTo.peek() },
      y: { range: (_u, least, most) => rangeOf(least, most) },
    },
    axes: [
      { ...axis, size: 22, values: (_u, splits, _i, _space, step) => splits.map((t) => clock(t, step)) },
      { ...axis, size: 44, space: 22 },
    ],
    series: [{}, ...(shown.lines.length ? shown.lines : [{ label: title, colour: colours()[0], dashed: false }])
      .map((line) => ({ label: line.label, stroke: line.colour, width: 1.4, spanGaps: true,
        dash: line.dashed ? [3, 3] : undefined }))],
    hooks: {
      draw: [(u) => {
        const x = u.valToPos(time.peek(), "x", true);
        if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
        u.ctx.fillStyle = palette.ink;
        u.ctx.fillRect(x - 0.75, u.bbox.top, 1.5, u.bbox.height);
      }],
      ready: [(u) => u.over.addEventListener("click", (event) => {
        playing.value = false;
        seek(u.posToVal(event.offsetX, "x"));
      })],
    },
  }, join(shown.data), holder);
}
