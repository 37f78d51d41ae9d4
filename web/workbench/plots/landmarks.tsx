// Ranges and bearings to landmarks: the map with the lines of sight, residuals along and across these, errors by landmark.
import * as Plot from "@observablehq/plot";
import { useCallback, useMemo } from "preact/hooks";
import { arrowScale, bounds, placeMarks } from "../../shared/arrows";
import type { Box } from "../../shared/brush";
import { Figure, type Frame } from "../../shared/figure";
import { number, quantile } from "../../shared/format";
import { palette } from "../../shared/palette";
import type { Arrows } from "../../shared/types";
import { paintArrows, paintChosen, paintDots, paintRays } from "../paint";
import type { Numbers, Residuals, Rows } from "../rows";
import { choose, rowsOf, selection } from "../selection";
import { GroupPlot } from "./groups";
import { everyFew, type View } from "./view";

const mostRays = 1500;

/** Of each row the residual along and across the line of sight, and both in the world's axes; m. A part that was not measured
 * is 0. */
interface Sights {
  along: Float32Array;
  across: Float32Array;
  dx: Float32Array;
  dy: Float32Array;
}

const placesOf = (rows: Rows) => ["landmark_x_m", "landmark_y_m", "robot_x_m", "robot_y_m"].map((name) => rows.data(name)!);

function sightsOf(rows: Rows, of: Residuals): Sights {
  const [x, y, robotX, robotY] = placesOf(rows);
  const range = of.r.get("range_m"), bearing = of.r.get("bearing_rad");
  const [along, across, dx, dy] = Array.from({ length: 4 }, () => new Float32Array(rows.n).fill(NaN));
  for (let i = 0; i < rows.n; ++i) {
    const toX = x[i] - robotX[i], toY = y[i] - robotY[i], distance = Math.hypot(toX, toY);
    const seen = [range?.[i] ?? NaN, bearing?.[i] ?? NaN];
    if (!(distance > 0) || !seen.some(Number.isFinite)) continue;
    along[i] = Number.isFinite(seen[0]) ? seen[0] : 0;
    across[i] = Number.isFinite(seen[1]) ? seen[1] * distance : 0;
    dx[i] = (along[i] * toX - across[i] * toY) / distance;
    dy[i] = (along[i] * toY + across[i] * toX) / distance;
  }
  return { along, across, dx, dy };
}

export function LandmarkPlots({ view }: { view: View }) {
  const { rows, before, after } = view;
  const first = useMemo(() => sightsOf(rows, before), [rows, before]);
  const second = useMemo(() => after && sightsOf(rows, after), [rows, after]);
  return (
    <>
      <SightMap view={view} first={first} second={second} />
      {first.across.some((value) => value !== 0 && Number.isFinite(value)) && first.along.some((value) => value !== 0 && Number.isFinite(value)) &&
        <AlongAcross view={view} first={first} second={second} />}
      {rows.data("landmark") && <GroupPlot view={view} name="landmark" ids={rows.data("landmark")}
        labels={rows.words.names?.landmark} />}
    </>
  );
}

interface SightProps {
  view: View;
  first: Sights;
  second?: Sights;
}

function SightMap({ view: { rows }, first, second }: SightProps) {
  const [x, y, robotX, robotY] = placesOf(rows);
  const drawn = useMemo(() => everyFew(rows, mostRays).filter((i) => Number.isFinite(first.dx[i])), [rows, first]);
  const set: Arrows = useMemo(() => ({ plane: "world_m", unit: "m", places: rows.words.places,
    robot: [...drawn].map((i) => [robotX[i], robotY[i]]),
    items: [...drawn].map((i) => [x[i], y[i], first.dx[i], first.dy[i]]) }), [rows, first]);
  const [scale, box] = useMemo(() => {
    const best = set.items.length > 1 ? arrowScale([set]) : 1;
    return [best, bounds(set, best)];
  }, [set]);
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: Math.round((width - 52) * (box[3] - box[2]) / (box[1] - box[0])) + 62,
    marginLeft: 40, marginRight: 12, marginTop: 26, marginBottom: 36,
    x: { domain: [box[0], box[1]], label: "x (m)", ticks: 6, tickSize: 4 },
    y: { domain: [box[2], box[3]], label: "y (m)", ticks: 5, tickSize: 4 },
    marks: [Plot.frame({ stroke: palette.line }), ...placeMarks(rows.words.places ?? [])],
  }), [box]);
  const chosen = selection.value;
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) => {
    const arrows = (of: Sights) => [x, y, of.dx, of.dy];
    paintRays(context, frame, drawn, [robotX, robotY, x, y], palette.dot, 0.25);
    if (second) {
      context.globalAlpha = 0.25;
      paintArrows(context, frame, drawn, arrows(first), scale, palette.before);
      context.globalAlpha = 1;
    }
    paintArrows(context, frame, drawn, arrows(second ?? first), scale, second ? palette.after : palette.before);
    const marked = rowsOf(chosen, mostRays);
    paintRays(context, frame, marked, [robotX, robotY, x, y], palette.pink, 0.8);
    paintArrows(context, frame, marked, arrows(second ?? first), scale, palette.pink, 1.8);
  }, [first, second, drawn, scale, chosen]);
  const onBrush = useCallback((area: Box | null, add: boolean) => {
    if (!area) return;
    const inside = (a: Numbers, b: Numbers, i: number) => a[i] >= area.x[0] && a[i] <= area.x[1] && b[i] >= area.y[0] && b[i] <= area.y[1];
    choose(rows.n, (i) => inside(x, y, i) || inside(robotX, robotY, i),
      `seen from or at x ${number(area.x[0])} to ${number(area.x[1])} m, y ${number(area.y[0])} to ${number(area.y[1])} m`, add);
  }, [rows]);
  return (
    <Figure name="map with lines of sight" draw={draw} paint={paint} onBrush={onBrush}
      title={<>where landmarks were seen from <span class="quiet">arrows {number(scale, 2)} times as long</span></>}
      sentence="Grey lines lead from the robot to the landmark. Each arrow starts at the landmark and shows where one observation puts it instead." />
  );
}

function AlongAcross({ view: { rows }, first, second }: SightProps) {
  const now = second ?? first;
  const reach = useMemo(() => Math.max(1e-6, 1.2 * quantile([...first.along, ...first.across].filter(Number.isFinite).map(Math.abs), 0.99)), [first]);
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: 260, marginLeft: 56, marginBottom: 38,
    x: { domain: [-reach, reach], label: "across: bearing × distance (m)", ticks: width < 420 ? 4 : 6, tickSize: 4, grid: true },
    y: { domain: [-reach, reach], label: "along: range (m)", ticks: 5, tickSize: 4, grid: true },
    marks: [Plot.ruleX([0], { stroke: palette.line }), Plot.ruleY([0], { stroke: palette.line })],
  }), [reach]);
  const chosen = selection.value;
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) => {
    if (second) {
      context.globalAlpha = 0.3;
      paintDots(context, frame, first.across, first.along, palette.before);
    }
    paintDots(context, frame, now.across, now.along, second ? palette.after : palette.before);
    paintChosen(context, frame, now.across, now.along, chosen.mask, palette.pink);
  }, [first, second, chosen]);
  const onBrush = useCallback((box: Box | null, add: boolean) => box && choose(rows.n, (i) => now.across[i] >= box.x[0] &&
    now.across[i] <= box.x[1] && now.along[i] >= box.y[0] && now.along[i] <= box.y[1],
  `across ${number(box.x[0])} to ${number(box.x[1])} m, along ${number(box.y[0])} to ${number(box.y[1])} m`, add), [rows, now]);
  return (
    <Figure name="along and across the line of sight" draw={draw} paint={paint} onBrush={onBrush}
      title={<>residuals <span class="quiet">along and across the line of sight</span></>}
      sentence="A cloud off the middle is a bias: up, ranges are too long; to the right, bearings are too far left. A stretched cloud has a cause that noise has not." />
  );
}
