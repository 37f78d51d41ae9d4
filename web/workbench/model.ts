// What the page knows of a session, in the page's own terms; api.ts makes it from the server's answers.
import type { Candidate, Parameters, Structure } from "../shared/types";
import type { Range } from "./selection";

export interface Doubt {
  text: string;
  rows?: Range[];
}

export interface ColumnInfo {
  name: string;
  unit?: string;
  file?: string;
  low?: number | null;
  high?: number | null;
  missing?: number;
}

export interface SetInfo {
  title: string;
  kind: string;
  folder: string;
  /** The file that rows are lines of. */
  file: string;
  rows: number;
  groups: number;
  group: string;
  image?: { width_px: number; height_px: number };
  noise: Record<string, number>;
  noiseEstimated: boolean;
  columns: ColumnInfo[];
  doubts: Doubt[];
  /** Sentences of the import that made it. */
  imported?: { done: string[]; not_known: string[] };
}

export interface Version {
  id: string;
  parent: string | null;
  /** What made it, in a word: "nominal", "rolling_shutter", "formula". */
  name: string;
  command: string;
  note: string;
  error: number | null;
  headline: string;
  verdict?: string;
  effects: Record<string, Parameters>;
  structure: Structure[] | null;
  doubts: string[];
  noise: Record<string, number>;
  /** How many rows were left out when it was fitted. */
  leftOut: number;
  /** Whether it was compared with the measurements yet. */
  looked?: "no" | "running" | "failed" | "yes";
  trouble?: string;
}

export interface LeftOut {
  ranges: Range[];
  count: number;
  reason: string;
}

export interface Job {
  /** Of a look at a version, whose counts the list of candidates shows. */
  version?: string;
  what: string;
  /** What goes on just now, such as "reading left: pictures". */
  doing?: string;
  done: number;
  of: number;
}

export interface Place {
  name: string;
  path: string;
  kind?: string;
  title?: string;
}

export interface Session {
  revision: number;
  set: SetInfo | null;
  versions: Version[];
  current: string;
  leftOut: LeftOut[];
  recent: Place[];
  samples: Place[];
  /** Folders named at the terminal: those below may be opened by their names. */
  named: string[];
  job: Job | null;
  command: string;
  selection: Range[];
  canUndo: boolean;
  canRedo: boolean;
  /** Why the session cannot be written now. */
  problem?: string | null;
}

export interface Tie {
  effects: string[];
  /** The measurement that separates them. */
  advice: string;
}

/** A formula that explains what no effect of the catalogue does. */
export interface Suggestion {
  /** Its name in `yaml`; a person gives it another. */
  effect: string;
  formula: string;
  error: number | null;
  error_before: number | null;
  /** Effects that the search found and that the formula was fitted with. */
  beside?: string[];
  stage: string;
  /** What stands below the stage in a file of effects. */
  text: string;
}

export interface Search {
  candidates: Candidate[];
  /** Candidates that wait for their fit, as one linear step judges them; the best first. */
  prospects: Candidate[];
  suggestion?: Suggestion;
  ties: Tie[];
  ordered_by?: string;
  notTestable: { effect: string; parameter?: string; why?: string }[];
  /** Null when the search has ended. */
  progress: { done: number; of: number; what?: string } | null;
  cancelled?: boolean;
  trouble?: string;
  advice: string;
}

/** Of those that shift means the strongest beside the noise first, then what no plot shows and what widens residuals. */
export function strongestFirst(items: Structure[], noise: Record<string, number>): Structure[] {
  const size = (item: Structure) => (item.moment === "mean" && item.covariate !== "neighbour" ? (item.strength ?? 0) / (noise[item.residual] || Infinity) : -1);
  return [...items].sort((a, b) => size(b) - size(a));
}
