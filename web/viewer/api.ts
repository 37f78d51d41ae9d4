// The server's answers (docs/reference/viewer_api.md) and how they are asked for. Times are simulated seconds.

export type LogId = "a" | "b";

export interface RobotInfo {
  id: string;
  team: string;
  number: number;
  camera?: { width_px: number; height_px: number };
}

export interface Scenery {
  label?: string;
  top_m: number;
  /** Corners of what it covers of the ground; two where it stands upright. */
  footprint_m: [number, number][];
  rgb: [number, number, number];
}

export interface LogInfo {
  id: LogId;
  file: string;
  bytes: number;
  scenario: string;
  scenario_text?: string;
  seed: string;
  start_s: number;
  end_s: number;
  step_s: number;
  complete: boolean;
  losses: string[];
  end_reason: string;
  fingerprint: string;
  versions: Record<string, string>;
  robots: RobotInfo[];
  joints: string[];
  sections: string[];
  has_frames: boolean;
  stages: string[];
  field?: { length_m: number; width_m: number };
  scenery: Scenery[];
}

export interface Truth {
  t: number[];
  ball?: [number, number, number][];
  /** x, y, heading, then tilt, pan, roll; of a robot without such a head its camera's x, y, heading, elevation, too. */
  robots: Record<string, number[][]>;
}

export interface MatchEvent {
  t: number;
  kind: string;
  robot: string;
  name: string;
  detail: string;
}

export interface Decision {
  t: number;
  /** The newest frame that the robot had been sent when it decided. */
  frame?: number;
}

export interface DebugItem {
  t: number;
  name: string;
  /** The frame that a drawing belongs to. */
  frame?: number;
  value?: number;
  text?: string;
  in_image?: boolean;
  points?: [number, number][];
}

export interface FrameInfo {
  index: number;
  t: number;
  recorded: boolean;
  fingerprint: string;
}

export interface FrameRows {
  index: number;
  stamp_ns: string;
  rows: { start_ns: string; end_ns: string; yaw_rad: number; pitch_rad: number }[];
}

export interface State {
  time_ns: string;
  step: number;
  fingerprint: string;
  sections: { name: string; hash: string; fields: [string, unknown][] }[];
}

export interface SeriesData {
  t: number[];
  values: (number | null)[];
}

export interface Difference {
  equal: boolean;
  header: string[];
  compared_until_s: number;
  first?: { t: number; section: string; field: string; a: unknown; b: unknown } | null;
  first_decision?: {
    t: number;
    robot: string;
    /** An empty text: that run's decision lacks the field. */
    fields: { field: string; a: string; b: string }[];
    /** The frames that the two decisions were made from. */
    frame?: { a: number; b: number; same: boolean } | null;
  } | null;
  spread: { t: number; section: string }[];
}

type Query = Record<string, string | number | undefined>;

export function address(path: string, query: Query): string {
  const parts = Object.entries(query)
    .filter(([, value]) => value !== undefined)
    .map(([name, value]) => `${name}=${encodeURIComponent(String(value))}`);
  return `/api/${path}${parts.length ? `?${parts.join("&")}` : ""}`;
}

/** The server's own sentence where an answer is an error. */
async function refusal(response: Response): Promise<Error> {
  const body = (await response.json().catch(() => ({}))) as { error?: string };
  return new Error(body.error ?? `the server answered ${response.status}`);
}

export async function ask<T>(path: string, query: Query = {}): Promise<T> {
  const response = await fetch(address(path, query));
  if (!response.ok) throw await refusal(response);
  return (await response.json()) as T;
}

export interface Picture {
  bitmap: ImageBitmap;
  index: number;
  stamp_s: number;
  recorded: boolean;
  /** Whether a frame rendered now has the fingerprint of the log; unknown when the log has none. */
  matches?: boolean;
}

export async function askPicture(query: Query): Promise<Picture> {
  const response = await fetch(address("frame", query));
  if (!response.ok) throw await refusal(response);
  const headers = response.headers;
  const matches = headers.get("X-Seam-Matches");
  return {
    bitmap: await createImageBitmap(await response.blob()),
    index: Number(headers.get("X-Seam-Index")),
    stamp_s: Number(headers.get("X-Seam-Stamp-Ns")) / 1e9,
    recorded: headers.get("X-Seam-Recorded") === "1",
    matches: matches === "1" ? true : matches === "0" ? false : undefined,
  };
}
