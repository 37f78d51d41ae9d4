// The whole match as a strip: a lane a kind of event, the moment shown, the wheel zooms.
import { useCallback } from "preact/hooks";
import { palette } from "../shared/palette";
import { Canvas, font, type Size } from "./canvas";
import { lanesNow, robotLanes, type Lane, type Span } from "./lanes";
import {
  difference, end, playing, plotFrom, plotTo, replays, robot, seek, start, time, view, zoom,
} from "./store";

const labelWidth = 72;
const axisHeight = 20;

/** Steps of 1, 2, 5 (and of clock time above a minute) so that labels have room. */
function tickStep(span: number, room: number): number {
  const steps = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1800];
  return steps.find((step) => (span / step) * 70 < room) ?? 3600;
}

export function clock(t: number, step = 1): string {
  const places = step >= 1 ? 0 : step >= 0.1 ? 1 : step >= 0.01 ? 2 : 3;
  const minutes = Math.floor(t / 60 + 1e-9);
  const seconds = Math.max(0, t - 60 * minutes).toFixed(places);
  return `${minutes}:${seconds.padStart(places ? 3 + places : 2, "0")}`;
}

function scaleOf(size: Size) {
  const [low, high] = view.value;
  const width = size.width - labelWidth - 8;
  return { x: (t: number) => labelWidth + ((t - low) / (high - low)) * width,
    t: (x: number) => low + ((x - labelWidth) / width) * (high - low), low, high };
}

/** Of all logs, and one for where they differ. */
const rowCount = () =>
  Math.max(1, replays.value.length * lanesNow().length + (difference.value && !difference.value.equal ? 1 : 0));

function draw(context: CanvasRenderingContext2D, size: Size): void {
  const { x, low, high } = scaleOf(size);
  const logs = replays.value;
  const lanes = lanesNow();
  const diff = difference.value;
  const laneHeight = (size.height - axisHeight) / rowCount();
  drawPlotPage(context, size, x, low, high);
  drawAxis(context, size, x, low, high);
  let row = 0;
  for (const [place, replay] of logs.entries()) {
    for (const lane of lanes) {
      const top = row++ * laneHeight;
      const name = logs.length > 1 ? `${replay.info.id}: ${lane.label}` : lane.label;
      drawLane(context, size, top, laneHeight, name);
      const marks = { x, low, high, top, height: laneHeight };
      if (lane.spans) drawSpans(context, lane.spans(place), lane, marks);
      if (lane.times) drawMarks(context, lane.times(robotLanes.value), lane, marks);
      const { wants } = lane;
      if (wants) drawMarks(context, replay.events.filter(wants).map((event) => event.t), lane, marks);
    }
  }
  if (diff && !diff.equal) {
    const top = row * laneHeight;
    drawLane(context, size, top, laneHeight, "differs");
    const from = diff.first?.t;
    if (from !== undefined && from <= high) {
      context.fillStyle = palette.pink;
      context.globalAlpha = 0.3;
      context.fillRect(Math.max(labelWidth, x(from)), top + 3, x(Math.min(high, diff.compared_until_s)) -
        Math.max(labelWidth, x(from)), laneHeight - 6);
      context.globalAlpha = 1;
      for (const item of diff.spread) {
        if (item.t >= low && item.t <= high) context.fillRect(x(item.t) - 1, top + 2, 2, laneHeight - 4);
      }
    }
  }
  const now = x(time.value);
  if (now >= labelWidth - 1 && now <= size.width) {
    context.fillStyle = palette.ink;
    context.fillRect(now - 0.75, 0, 1.5, size.height - axisHeight + 4);
    context.beginPath();
    context.moveTo(now - 5, 0);
    context.lineTo(now + 5, 0);
    context.lineTo(now, 7);
    context.fill();
  }
}

function drawAxis(context: CanvasRenderingContext2D, size: Size, x: (t: number) => number, low: number,
  high: number): void {
  const step = tickStep(high - low, size.width - labelWidth);
  context.font = font(11);
  context.textBaseline = "alphabetic";
  context.textAlign = "center";
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9; ++i) {
    const at = x(i * step);
    context.fillStyle = palette.line;
    context.fillRect(at, 0, 1, size.height - axisHeight + 4);
    context.fillStyle = palette.ink3;
    context.fillText(clock(i * step, step), Math.min(Math.max(at, labelWidth + 12), size.width - 16), size.height - 4);
  }
}

/** Where the plots are, when they show less than the timeline. */
function drawPlotPage(context: CanvasRenderingContext2D, size: Size, x: (t: number) => number, low: number,
  high: number): void {
  const [from, to] = [Math.max(low, plotFrom.value), Math.min(high, plotTo.value)];
  if (to <= from || to - from > 0.9 * (high - low)) return;
  context.fillStyle = "rgba(86, 180, 233, 0.18)";
  context.fillRect(x(from), 0, x(to) - x(from), size.height - axisHeight + 4);
}

function drawLane(context: CanvasRenderingContext2D, size: Size, top: number, height: number, label: string): void {
  context.fillStyle = palette.line;
  context.fillRect(labelWidth, top + height - 0.5, size.width - labelWidth, 1);
  context.fillStyle = palette.ink2;
  context.font = font(11);
  context.textAlign = "left";
  context.textBaseline = "middle";
  context.fillText(label, 2, top + height / 2);
}

interface Strip {
  x: (t: number) => number;
  low: number;
  high: number;
  top: number;
  height: number;
}

/** One mark for each pixel at most, so that a match of any length draws at once. */
function drawMarks(context: CanvasRenderingContext2D, times: number[], lane: Lane, strip: Strip): void {
  const { x, low, high, top, height } = strip;
  context.fillStyle = palette[lane.colour];
  let last = -10;
  for (const t of times) {
    if (t < low || t > high) continue;
    const at = x(t);
    if (at - last < 1) continue;
    last = at;
    context.fillRect(at - (lane.thin ? 0.5 : 1.25), top + 2, lane.thin ? 1 : 2.5, height - 4);
  }
}

function drawSpans(context: CanvasRenderingContext2D, spans: Span[], lane: Lane, strip: Strip): void {
  const { x, low, high, top, height } = strip;
  context.fillStyle = palette[lane.colour];
  let last = -10;
  for (const { from, to } of spans) {
    if (to < low || from > high) continue;
    const begin = Math.max(x(Math.max(from, low)), last);
    const end = Math.max(x(Math.min(to, high)), x(Math.max(from, low)) + 2);
    if (end - last < 1) continue;
    last = end;
    context.fillRect(begin, top + 2, end - begin, height - 4);
  }
}

export function Timeline() {
  const rows = rowCount();
  const onPointer = useCallback((event: PointerEvent, size: Size) => {
    const canvas = event.currentTarget as HTMLCanvasElement;
    if (event.type === "pointerdown") {
      canvas.setPointerCapture(event.pointerId);
      playing.value = false;
    } else if (!(event.buttons & 1)) {
      canvas.title = describe(event.offsetX, event.offsetY, size);
      return;
    }
    seek(snapped(event.offsetX, event.offsetY, size));
  }, []);
  const onWheel = useCallback((event: WheelEvent, size: Size) => {
    zoom(Math.exp(event.deltaY * 0.0015), scaleOf(size).t(event.offsetX));
  }, []);
  const whole = useCallback(() => {
    view.value = [start.value, Math.max(end.value, start.value + 0.1)];
  }, []);
  const lane = replays.value.length > 1 ? 17 : 13;
  return (
    <div class="timeline" data-lanes={lanesNow().map((one) => one.label).join(" ")} style={{ height: `${lane * rows + axisHeight}px` }}>
      <Canvas name="timeline" draw={draw} onPointer={onPointer} onWheel={onWheel} onDoubleClick={whole} />
    </div>
  );
}

interface Mark {
  t: number;
  text: string;
}

/** The marks of the lane under this height. */
function marksAt(y: number, size: Size): Mark[] {
  const lanes = lanesNow();
  const row = Math.floor((y * rowCount()) / (size.height - axisHeight));
  const replay = replays.value[Math.floor(row / lanes.length)];
  if (!replay) return [];
  const { label, wants, times, spans } = lanes[row % lanes.length];
  const events = wants ? replay.events.filter(wants) : [];
  return [
    ...events.map((event) => ({ t: event.t, text: `${event.name} ${event.robot} ${event.detail}` })),
    ...(times?.(robotLanes.value) ?? []).map((t) => ({ t, text: `${label} of ${robot.value}` })),
    ...(spans?.(replays.value.indexOf(replay)) ?? []).map(({ from, to }) =>
      ({ t: from, text: `${label}, until ${clock(to, 0.001)}` })),
  ];
}

function nearest(x: number, y: number, size: Size): Mark | undefined {
  const scale = scaleOf(size);
  let best: Mark | undefined;
  let reach = 4;
  for (const mark of marksAt(y, size)) {
    const away = Math.abs(scale.x(mark.t) - x);
    if (away < reach) [best, reach] = [mark, away];
  }
  return best;
}

/** A click on a mark goes to the mark's own time. */
function snapped(x: number, y: number, size: Size): number {
  return nearest(x, y, size)?.t ?? scaleOf(size).t(x);
}

function describe(x: number, y: number, size: Size): string {
  const mark = nearest(x, y, size);
  return mark ? `${clock(mark.t, 0.001)} ${mark.text}`.trim() : "";
}
