// The document that a command writes into the page: `docs/reference/report_data.md` says what each field means.
import type { Arrows, Candidate, Histogram, ImageMap, Parameters, ResidualPlot, Series, Structure } from "../shared/types";

export interface Step {
  effect: string | null;
  parameters?: Parameters;
  error_before: number | null;
  error_after: number | null;
  indistinguishable_from?: string[];
  why?: string;
  version?: number | string;
  data?: string;
  fingerprint?: string;
}

export interface Outlier {
  file?: string;
  line?: number;
  channel?: string;
  residual?: number | string;
}

export interface Interval {
  bias_mm: number | null;
  ci95?: number | [number, number];
  spread_mm?: number | null;
}

export interface FreePrediction {
  over: string;
  residual: string;
  rms: number | null;
  at_end?: number | null;
  n: number;
}

export interface FigureTable {
  title: string;
  figures: { name: string; unit: string; value: number | null; sigma: number | null }[];
  snr_curve: {
    light: number;
    signal_dn: number;
    snr: number | null;
    sigma: number | null;
    expected: number | null;
  }[];
}

export interface Suggestion {
  effect: string;
  formula?: string;
  error?: number | null;
  error_before?: number | null;
  terms?: string[];
  beside?: string[];
  mimics?: string[];
  yaml?: string;
}

export interface Result {
  format?: string;
  headline?: string;
  doubts?: string[];
  notes?: string[];
  structure_of?: "given" | "explanation";
  explanation?: { steps?: { effect: string; error_after: number | null }[]; error: number | null };
  verdict?: string;
  kind?: string;
  n?: number;
  groups?: number;
  error?: number | null;
  native?: Record<string, number>;
  noise_floor?: number | null;
  noise?: Record<string, number>;
  baseline?: {
    error: number | null;
    native?: Record<string, number>;
    noise_floor?: number;
    free_prediction?: FreePrediction[];
  };
  free_prediction?: FreePrediction[];
  findings?: { what: string; name: string; text: string }[];
  candidates?: Candidate[];
  structure?: Structure[];
  material?: number;
  traces?: { structure?: Structure[]; candidates?: Candidate[] };
  steps?: Step[];
  versions?: Step[];
  outliers?: Outlier[] | { count?: number; items?: Outlier[] };
  looked_for?: { what: string; of: string[]; outcome: string; why?: string }[];
  not_testable?: { effect: string; parameter?: string; why?: string }[];
  figures?: FigureTable;
  suggestion?: Suggestion;
  advice?: string;
  modes?: Record<string, Interval>;
  paired?: { difference_mm: number | null; ci95?: number | [number, number] };
  seeds?: number;
}

export interface LeaveOneOut {
  effect: string;
  log_likelihood_lost?: number | null;
  error_with: number | null;
  error_without: number | null;
}

export interface Plots {
  residuals?: ResidualPlot[];
  arrows?: Arrows[];
  maps?: ImageMap[];
  histograms?: Histogram[];
  series?: Series[];
  intervals?: Series[];
  leave_one_out?: LeaveOneOut[];
  /** Points of a target: x, y by its plan, their shift along x, y and out of it, and the errors of
   * the shift along x and out of it; m. */
  target?: number[][];
  /** How well the lens is known, or by how much two models differ, over the image. */
  lens_error?: ImageMap | ImageMap[];
}

export interface Table {
  title?: string;
  columns: string[];
  rows: (string | number | null)[][];
}

export interface Report {
  format: string;
  title?: string;
  command?: string;
  version?: string;
  model?: { name?: string; file?: string; effects?: Record<string, Parameters> };
  data?: {
    folder?: string;
    title?: string;
    kind?: string;
    fingerprint?: string;
    n?: number;
    residuals?: number;
    groups?: number;
    held_out_n?: number;
    held_out_groups?: number;
    image?: { width_px: number; height_px: number };
    noise?: Record<string, number>;
    noise_from?: string;
  };
  result: Result;
  plots?: Plots;
  tables?: Table[];
}

/** Reads the embedded document; throws with a sentence when the page holds none. */
export function readReport(): Report {
  const text = document.getElementById("data")?.textContent ?? "";
  let report: Report;
  try {
    report = JSON.parse(text) as Report;
  } catch {
    throw new Error("This page holds no readable report data: it is the template, or it was cut.");
  }
  if (!report || report.format !== "seam-report/1") {
    throw new Error(`This page holds "${report?.format}" where "seam-report/1" was expected.`);
  }
  return { ...report, result: report.result ?? {} };
}

/** The error of the model as given, wherever this command writes it. */
export function errorBefore(result: Result): number | null {
  const first = steps(result)[0];
  return result.baseline?.error ?? (first ? first.error_before : result.error) ?? null;
}

/** The steps of `discover`, or the versions of `history`: both are errors that fall. */
export function steps(result: Result): Step[] {
  return result.steps ?? result.versions ?? [];
}

export function outlierList(result: Result): Outlier[] {
  const outliers = result.outliers;
  return Array.isArray(outliers) ? outliers : outliers?.items ?? [];
}

/** The noise of one observation of a residual, stated or estimated. */
export function noiseOf(report: Report, residual: string): number | null {
  return (report.data?.noise ?? report.result.noise)?.[residual] ?? null;
}
