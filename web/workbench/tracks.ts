// Rows in the order of time, run by run: a servo's log, a walk.
import { signal } from "@preact/signals";
import type { Numbers, Residuals, Rows } from "./rows";

export interface Track {
  id: number;
  name: string;
  /** By time. */
  rows: Uint32Array;
}

const mostPoints = 800;

export function tracksOf(rows: Rows): Track[] {
  const ids = rows.data("track"), time = rows.data("time_s");
  if (!ids || !time) return [];
  const found = new Map<number, number[]>();
  for (let i = 0; i < rows.n; ++i) {
    const list = found.get(ids[i]);
    if (list) list.push(i);
    else found.set(ids[i], [i]);
  }
  return [...found].map(([id, list]) => ({ id, name: rows.words.names?.track?.[id] ?? String(id),
    rows: Uint32Array.from(list).sort((a, b) => time[a] - time[b] || a - b) }));
}

/** What the model predicts: the measured less the residual; NaN where either is not there. */
export function predicted(measured: Numbers, residual: Numbers): Float32Array {
  return Float32Array.from(measured, (value, i) => value - residual[i]);
}

/** Points of a line through a track's rows, of a long one every few. */
export function pointsOf(track: Track, x: Numbers, y: Numbers): number[][] {
  const step = Math.ceil(track.rows.length / mostPoints);
  const points: number[][] = [];
  for (let k = 0; k < track.rows.length; k += step) {
    const i = track.rows[k];
    if (Number.isFinite(x[i]) && Number.isFinite(y[i])) points.push([x[i], y[i]]);
  }
  return points;
}

/** Root mean square of residuals over a track's rows. */
export function sizeOf(track: Track, residuals: Residuals, channels: string[]): number {
  let squares = 0, n = 0;
  for (const i of track.rows) {
    const square = channels.reduce((sum, name) => sum + residuals.r.get(name)![i] ** 2, 0);
    if (!(square - square === 0)) continue;
    squares += square;
    ++n;
  }
  return n ? Math.sqrt(squares / n) : 0;
}

const chosenTrack = signal("");
export const chooseTrack = (name: string): void => {
  chosenTrack.value = name;
};

/** The track that a person chose, else the one that the model misses most. */
export function shownTrack(tracks: Track[], before: Residuals, channels: string[]): Track {
  return tracks.find((track) => track.name === chosenTrack.value) ??
    tracks.reduce((worst, track) => (sizeOf(track, before, channels) > sizeOf(worst, before, channels) ? track : worst));
}

/** The rate of a column along a track, by the rows beside each. */
export function rateOf(track: Track, time: Numbers, values: Numbers): Float32Array {
  const rate = new Float32Array(values.length).fill(NaN);
  for (let k = 1; k + 1 < track.rows.length; ++k) {
    const [a, b] = [track.rows[k - 1], track.rows[k + 1]];
    rate[track.rows[k]] = (values[b] - values[a]) / (time[b] - time[a]);
  }
  return rate;
}
