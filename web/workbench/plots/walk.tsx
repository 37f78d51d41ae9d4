// Walks: the way from above, and how far the prediction from the start alone drifts from what was measured.
import * as Plot from "@observablehq/plot";
import { useCallback, useMemo } from "preact/hooks";
import type { Box } from "../../shared/brush";
import { Figure, type Frame } from "../../shared/figure";
import { number, quantile } from "../../shared/format";
import { inkName, palette } from "../../shared/palette";
import { SeriesFigure } from "../../shared/series";
import type { Series } from "../../shared/types";
import { paintChosen, paintPath } from "../paint";
import type { Numbers, Residuals, Rows } from "../rows";
import { choose, selection } from "../selection";
import { pointsOf, predicted, shownTrack, sizeOf, tracksOf, type Track } from "../tracks";
import { TrackChoice } from "./track_choice";
import { shownOf, type View } from "./view";

const channels = ["x_m", "y_m"];
const names = ["measured", "predicted", "predicted after"];

export function WalkPlots({ view }: { view: View }) {
  const { rows, before, after } = view;
  const tracks = useMemo(() => tracksOf(rows), [rows]);
  const track = shownTrack(tracks, before, channels);
  return (
    <>
      <FromAbove view={view} track={track} tracks={tracks} />
      <Drift view={view} tracks={tracks} key={after ? "preview" : "model"} />
    </>
  );
}

function FromAbove({ view: { rows, before, after }, track, tracks }: { view: View; track: Track; tracks: Track[] }) {
  const [x, y] = channels.map((name) => rows.data(name)!);
  const way = (of: Residuals) => channels.map((name) => predicted(rows.data(name)!, of.r.get(name)!)) as [Numbers, Numbers];
  const first = useMemo(() => way(before), [rows, before]);
  const second = useMemo(() => after && way(after), [rows, after]);
  const plot: Series = useMemo(() => ({ title: `${track.name} from above`, x: "x_m", y: "y_m", plane: "world_m",
    lines: [{ name: "measured", points: pointsOf(track, x, y) }, { name: "predicted", points: pointsOf(track, ...first) },
      ...(second ? [{ name: "predicted after", points: pointsOf(track, ...second) }] : [])] }), [track, first, second]);
  const chosen = selection.value;
  const inTrack = useMemo(() => new Set(track.rows), [track]);
  const onBrush = useCallback((box: Box | null, add: boolean) => box && choose(rows.n, (i) => inTrack.has(i) &&
    x[i] >= box.x[0] && x[i] <= box.x[1] && y[i] >= box.y[0] && y[i] <= box.y[1],
  `${track.name}: x ${number(box.x[0])} to ${number(box.x[1])} m, y ${number(box.y[0])} to ${number(box.y[1])} m`, add), [track]);
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) =>
    paintChosen(context, frame, x, y, chosen.mask, palette.pink, track.rows), [track, chosen]);
  return (
    <SeriesFigure plot={plot} names={names} tools={<TrackChoice tracks={tracks} shown={track} />} onBrush={onBrush} paint={paint}
      sentence={`${inkName()} was measured, orange is what the model predicts from the start that fits best: it misses by ${
        number(sizeOf(track, before, channels))} m${after ? `, blue with the preview, by ${
        number(sizeOf(track, after, channels))} m` : ""}, root mean square. Dots mark the starts.`} />
  );
}

/** How far each prediction is off when it begins at its run's first measured pose, and measures nothing on the way. */
function drifts(rows: Rows, of: Residuals, tracks: Track[]): Float32Array {
  const [x, y] = channels.map((name) => rows.data(name)!);
  const [dx, dy] = channels.map((name) => of.r.get(name)!), turn = of.r.get("theta_rad");
  const off = new Float32Array(rows.n).fill(NaN);
  for (const track of tracks) {
    const start = track.rows.find((i) => Number.isFinite(dx[i]) && Number.isFinite(dy[i]));
    if (start === undefined) continue;
    // The model's start is fitted to the whole run: its way is moved and turned to the first pose.
    const angle = Number.isFinite(turn?.[start]) ? turn![start] : 0, [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    for (const i of track.rows) {
      const alongX = x[i] - dx[i] - (x[start] - dx[start]), alongY = y[i] - dy[i] - (y[start] - dy[start]);
      off[i] = Math.hypot(x[i] - x[start] - cos * alongX + sin * alongY, y[i] - y[start] - sin * alongX - cos * alongY);
    }
  }
  return off;
}

function Drift({ view, tracks }: { view: View; tracks: Track[] }) {
  const { rows, before, after } = view;
  const now = shownOf(view), time = rows.data("time_s")!;
  const first = useMemo(() => drifts(rows, before, tracks), [before, tracks]);
  const shown = useMemo(() => (now === before ? first : drifts(rows, now, tracks)), [now, first]);
  const domain = useMemo(() => ({ x: [0, Math.max(...tracks.map((track) => time[track.rows[track.rows.length - 1]]))],
    y: [0, 1.1 * quantile([...first].filter(Number.isFinite), 0.995)] }), [tracks, first]);
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: 230, marginLeft: 52, marginBottom: 38,
    x: { domain: domain.x, label: "time since the start (s)", ticks: width < 420 ? 4 : 6, tickSize: 4 },
    y: { domain: domain.y, label: "measured from predicted (m)", ticks: 5, tickSize: 4, grid: true },
    marks: [Plot.ruleY([0], { stroke: palette.line })],
  }), [domain]);
  const chosen = selection.value;
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) => {
    for (const track of tracks) {
      if (after) paintPath(context, frame, track.rows, time, first, palette.before, 0.3);
      paintPath(context, frame, track.rows, time, shown, after ? palette.after : palette.before, 0.9);
    }
    paintChosen(context, frame, time, shown, chosen.mask, palette.pink);
  }, [tracks, shown, first, chosen]);
  const onBrush = useCallback((box: Box | null, add: boolean) => box && choose(rows.n, (i) => time[i] >= box.x[0] &&
    time[i] <= box.x[1] && shown[i] >= box.y[0] && shown[i] <= box.y[1],
  `${number(box.y[0])} to ${number(box.y[1])} m off, ${number(box.x[0])} to ${number(box.x[1])} s after the start`, add), [rows, shown]);
  const last = (of: Float32Array) => Math.sqrt(tracks.reduce((sum, { rows: all }) => {
    const end = all.reduce((latest, i) => (Number.isFinite(of[i]) ? of[i] : latest), 0);
    return sum + end ** 2;
  }, 0) / tracks.length);
  return (
    <Figure name="drift of the free prediction" draw={draw} paint={paint} onBrush={onBrush}
      title={<>drift of the free prediction <span class="quiet">a line a run</span></>}
      sentence={`Each prediction begins at its run's first measured pose, and nothing is measured on the way. At the ends it is ${
        number(last(first), 2)} m off${after ? `, with the preview ${number(last(shown), 2)} m` : ""}, root mean square over ${
        tracks.length} runs.`} />
  );
}
