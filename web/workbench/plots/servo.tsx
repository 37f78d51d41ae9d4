// A joint's log: command, answer and prediction over time, and the phase plane of the same run.
import { useCallback, useMemo } from "preact/hooks";
import type { Box } from "../../shared/brush";
import type { Frame } from "../../shared/figure";
import { number, quantile } from "../../shared/format";
import { inkName, palette } from "../../shared/palette";
import { SeriesFigure } from "../../shared/series";
import type { Line, Series } from "../../shared/types";
import { paintChosen } from "../paint";
import type { Numbers } from "../rows";
import { choose, selection } from "../selection";
import { pointsOf, predicted, rateOf, shownTrack, sizeOf, tracksOf } from "../tracks";
import { TrackChoice } from "./track_choice";
import type { View } from "./view";

const channel = "measured_rad";
const names = ["measured", "predicted", "command", "predicted after"];

/** Of the measured rates, with some room: where a command jumps a model without a lag jumps, too. */
function spanOf(rate: Numbers): [number, number] {
  const most = 1.3 * quantile([...rate].filter(Number.isFinite).map(Math.abs), 0.999) || 1;
  return [-most, most];
}

export function ServoPlots({ view }: { view: View }) {
  const { rows, before, after } = view;
  const [time, measured, command] = ["time_s", channel, "command_rad"].map((name) => rows.data(name)!);
  const tracks = useMemo(() => tracksOf(rows), [rows]);
  const track = shownTrack(tracks, before, [channel]);
  const first = useMemo(() => predicted(measured, before.r.get(channel)!), [rows, before]);
  const second = useMemo(() => after && predicted(measured, after.r.get(channel)!), [rows, after]);
  const line = (name: string, x: Numbers, y: Numbers): Line => ({ name, points: pointsOf(track, x, y) });
  const overTime: Series = useMemo(() => ({ title: `${track.name}: command and answer`, x: "time_s", y: channel,
    rms: sizeOf(track, after ?? before, [channel]),
    lines: [line("command", time, command), line("measured", time, measured), line("predicted", time, first),
      ...(second ? [line("predicted after", time, second)] : [])] }), [track, first, second]);
  const rate = useMemo(() => rateOf(track, time, measured), [track]);
  const phase: Series = useMemo(() => ({ title: `${track.name}: phase plane`, x: channel, y: "rate_radps", span: spanOf(rate),
    lines: [line("measured", measured, rate), line("predicted", first, rateOf(track, time, first)),
      ...(second ? [line("predicted after", second, rateOf(track, time, second))] : [])] }), [track, rate, first, second]);
  const inTrack = useMemo(() => new Set(track.rows), [track]);
  const within = (x: Numbers, y: Numbers, what: string) => (box: Box | null, add: boolean) => box && choose(rows.n, (i) =>
    inTrack.has(i) && x[i] >= box.x[0] && x[i] <= box.x[1] && y[i] >= box.y[0] && y[i] <= box.y[1],
  `${track.name}: ${what} ${number(box.x[0])} to ${number(box.x[1])}`, add);
  const chosen = selection.value;
  const marks = (x: Numbers, y: Numbers) => (context: CanvasRenderingContext2D, frame: Frame) =>
    paintChosen(context, frame, x, y, chosen.mask, palette.pink, track.rows);
  const size = number(overTime.rms);
  return (
    <>
      <SeriesFigure plot={overTime} names={names} tools={<TrackChoice tracks={tracks} shown={track} />}
        onBrush={useCallback(within(time, measured, "time"), [track])} paint={useCallback(marks(time, measured), [track, chosen])}
        sentence={`${inkName()} was measured; dashes are the command; orange is what the model predicts${second
          ? `, blue with the preview, which misses by ${size} rad root mean square` : `, which misses by ${size} rad root mean square`}.`} />
      <SeriesFigure plot={phase} names={names} onBrush={useCallback(within(measured, rate, "angle"), [track, rate])}
        paint={useCallback(marks(measured, rate), [track, rate, chosen])}
        sentence="Angle and rate of the same run. A lag turns the loops, friction flattens them where the rate changes its sign. What lies outside the measured rates is cut." />
    </>
  );
}
