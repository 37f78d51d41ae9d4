// What pages draw, as docs/reference/report_data.md has it: data, wherever it came from.

export interface Value {
  value: number | null;
  sigma?: number | null;
  free?: boolean;
}
export type Parameters = Record<string, Value | number>;

export interface Candidate {
  effect: string;
  /** None: it waits for its fit, and a linear step judges it. */
  rank?: number;
  error: number | null;
  gain: number | null;
  gain_sigma?: number | null;
  loglik_gain?: number | null;
  log_likelihood_gain?: number | null;
  p_value: number | null;
  parameters?: Parameters;
  indistinguishable_from?: string[];
  stands_in_for?: string[];
  found?: boolean;
  at_bound?: boolean;
  why?: string;
  /** What the effect is. */
  help?: string;
  /** Effects added with it as one move, with their parameters. */
  with?: Record<string, Parameters>;
  significant?: boolean;
}

export interface Structure {
  residual: string;
  moment: string;
  covariate: string;
  strength: number | null;
  p_value: number | null;
}

export interface Bin {
  low: number;
  high: number;
  centre: number;
  n: number;
  mean: number | null;
  mean_sigma: number | null;
  scatter: number | null;
  formal: number | null;
}

export interface ResidualPlot {
  residual: string;
  covariate: string;
  moment?: string;
  stage?: "before" | "after";
  x_unit?: string;
  /** Whether the covariate counts labels: nothing lies between two of them. */
  discrete?: boolean;
  /** Of a covariate whose values are numbers of names. */
  x_names?: string[];
  strength?: number | null;
  p_value?: number | null;
  bins: Bin[];
  sample?: [number, number][];
}

export interface Arrows {
  stage?: "before" | "after";
  plane?: "image_px" | "world_m";
  unit?: string;
  items: [number, number, number, number][];
  /** Of landmarks: from where each was seen, and the places of all. */
  robot?: [number, number][];
  places?: { name: string; x: number; y: number }[];
}

export interface ImageMap {
  camera?: string;
  stage?: "before" | "after";
  title?: string;
  unit?: string;
  columns: number;
  rows: number;
  width_px: number;
  height_px: number;
  values: (number | null)[];
}

export interface Histogram {
  residual: string;
  stage?: "before" | "after";
  edges: number[];
  counts: number[];
}

export interface Line {
  name: string;
  points: number[][];
}

export interface Series {
  title?: string;
  x: string;
  y: string;
  /** A way over the ground: one scale for both axes. */
  plane?: "world_m";
  rms?: number | null;
  /** Of y, where single values far outside must not flatten the rest. */
  span?: [number, number];
  lines: Line[];
}

/** A parameter is written as a plain number or with its error. */
export function asValue(parameter: Value | number): Value {
  return typeof parameter === "number" ? { value: parameter } : parameter;
}
