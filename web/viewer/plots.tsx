// Joints and odometry over the part of the match around the moment.
import { effect, signal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { palette, series as colours } from "../shared/palette";
import { ask, type SeriesData } from "./api";
import type { Replay } from "./replay";
import { playing, plotFrom, plotTo, robot, seek, time } from "./store";
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
  { title: "Client's values", unit: "", wants: (n) => n.startsWith("debug.") },
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

interface Shown {
  names: string[];
  data: SeriesData[];
}

/** Loads the series of this plot for the view, at most once at a time. */
function useSeries(replay: Replay, spec: PlotSpec) {
  const shown = useMemo(() => signal<Shown>({ names: [], data: [] }), [replay, spec]);
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
          const names = inOrder((await namesOf(replay, id)).filter(spec.wants)).slice(0, 7);
          const answer = names.length === 0 ? { series: {} as Record<string, SeriesData> }
            : await ask<{ series: Record<string, SeriesData> }>("series",
              { log: replay.info.id, robot: id, names: names.join(","), from, to, points: 1200 });
          const found = names.filter((name) => answer.series[name]);
          if (!gone && id === robot.peek()) {
            shown.value = { names: found, data: found.map((name) => answer.series[name]) };
          }
        } catch {
          if (!gone) shown.value = { names: [], data: [] };
        }
      }, 120);
    });
    return () => {
      gone = true;
      clearTimeout(timer);
      stop();
    };
  }, [replay, spec, shown]);
  return shown;
}

function label(name: string): string {
  // The plot of the walk is titled so.
  const short = name.replace(/^command\.(?=vx_|vy_|omega_)/, "");
  return short.replace(/_(m_s|rad_s|rad|m)$/, "").replace("debug.", "").replace("command.", "command ");
}

export function SeriesPlot({ replay, spec }: { replay: Replay; spec: PlotSpec }) {
  const holder = useRef<HTMLDivElement>(null);
  const shown = useSeries(replay, spec);
  useEffect(() => {
    let plot: uPlot | null = null;
    let drawn: string | null = null;
    const make = () => {
      plot?.destroy();
      plot = build(holder.current!, spec, shown.peek());
      drawn = shown.peek().names.join();
    };
    const observer = new ResizeObserver(() => {
      const size = boxOf(holder.current!);
      if (plot && size.width > 40) plot.setSize(size);
    });
    observer.observe(holder.current!);
    const stopData = effect(() => {
      const { names, data } = shown.value;
      if (names.join() !== drawn) make();
      else plot?.setData(join(data));
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
  }, [replay, spec, shown]);
  return (
    <figure class="series" data-series={spec.title}>
      <figcaption>
        <strong>{spec.title}</strong> {spec.unit && <span class="quiet">{spec.unit}</span>}
        <span class="legend">
          {shown.value.names.map((name) => (isCommand(name) && !shown.value.names.every(isCommand) ? null
            : <span key={name} style={{ color: colourOf(name, shown.value.names) }}>{label(name)}</span>
          ))}
          {shown.value.names.some(isCommand) && !shown.value.names.every(isCommand) &&
            <span class="quiet">dashed: commanded</span>}
          {shown.value.names.length === 0 && <span class="quiet">nothing logged</span>}
        </span>
      </figcaption>
      <div class="series-plot" ref={holder} />
    </figure>
  );
}

/** A command has the colour of the joint it is for, and the joints of a head have theirs always. */
function colourOf(name: string, names: string[]): string {
  const joint = name.replace(/^command\.(?=.*_rad$)/, "");
  const head = ["tilt_rad", "pan_rad", "roll_rad"].indexOf(joint);
  const place = names.includes(joint) ? names.indexOf(joint) : names.indexOf(name);
  return colours[(head >= 0 ? head : place) % colours.length];
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

function build(holder: HTMLElement, spec: PlotSpec, shown: Shown): uPlot {
  const axis = { stroke: palette.ink3, font: "11px Inter, sans-serif",
    grid: { stroke: "#eceef0", width: 1 }, ticks: { show: false } };
  return new uPlot({
    ...boxOf(holder),
    legend: { show: false },
    cursor: { y: false, drag: { x: false, y: false } },
    // Without values there is no vertical axis, whose place the first time's label needs.
    padding: [6, 18, 0, shown.names.length > 0 ? 0 : 44],
    scales: {
      x: { time: false, min: plotFrom.peek(), max: plotTo.peek() },
      y: { range: (_u, least, most) => rangeOf(least, most) },
    },
    axes: [
      { ...axis, size: 22, values: (_u, splits, _i, _space, step) => splits.map((t) => clock(t, step)) },
      { ...axis, size: 44, space: 22 },
    ],
    series: [{}, ...(shown.names.length ? shown.names : [spec.title]).map((name, _i, all) => ({
      label: name, stroke: colourOf(name, all), width: 1.4, spanGaps: true,
      dash: name.startsWith("command.") && !/v[xy]_|omega/.test(name) ? [3, 3] : undefined,
    }))],
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
