// What a person takes away: the model in the files of other programs, the report, the whole session.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { save } from "../shared/save";
import * as api from "./api";
import { session } from "./store";

const files: [string, string, string][] = [
  ["model", "Model", "the version shown with its fitted values, a model file of SEAM"],
  ["report", "Report", "a page that works without this program"],
  ["session", "Whole session", "all versions, notes and rows left out, as an archive"],
];

/** Names of programs as they write them. */
const programs: Record<string, string> = { opencv: "OpenCV", ros: "ROS", mrcal: "mrcal", kalibr: "Kalibr", mjcf: "MuJoCo", urdf: "URDF",
  "kalibr-imu": "Kalibr (IMU)", "vins-imu": "VINS", "kalibr-imu-cam": "Kalibr (camera and IMU)", "vins-imu-cam": "VINS (camera and IMU)",
  json: "JSON" };
const nameOf = (format: string) => programs[format] ?? format;

const formats = signal<api.ExportFormat[]>([]);
/** What the last export of a model came to. */
const ended = signal<{ version: string; format: string; name?: string; notes: string[]; why?: string } | null>(null);
const writing = signal("");

async function write(version: string, format: string, drop: boolean): Promise<void> {
  writing.value = format;
  try {
    const { name, text, notes } = await api.exportModel(version, format, drop);
    save(text, "application/octet-stream", name);
    ended.value = { version, format, name, notes };
  } catch (error) {
    ended.value = { version, format, notes: [], why: (error as Error).message };
  } finally {
    writing.value = "";
  }
}

export function Exports() {
  const { current, set } = session.value!;
  useEffect(() => void api.formats().then((all) => (formats.value = all), () => (formats.value = [])), [set?.folder]);
  return (
    <section aria-label="Export">
      <h2>Export</h2>
      <ul class="exports">
        {files.map(([what, label, text]) => (
          <li key={what}><a class="button" href={api.exportAddress(what)} download>{label}</a> <span class="quiet">{text}</span></li>
        ))}
      </ul>
      <h3>Version {current} for other programs</h3>
      <ul class="exports formats">
        {formats.value.map(({ name, what }) => (
          <li key={name}><button type="button" disabled={writing.value !== ""} onClick={() => void write(current, name, false)}>
            {writing.value === name ? "writing …" : nameOf(name)}</button> <span class="quiet">{what}</span></li>
        ))}
      </ul>
      <Ended />
      <p class="quiet">Plots are saved as SVG by the button at the corner of each.</p>
    </section>
  );
}

function Ended() {
  const now = ended.value;
  if (!now || now.version !== session.value?.current) return null;
  if (now.why !== undefined) {
    const holds = /--drop/.test(now.why);
    return (
      <div class="ended trouble" role="alert">
        <p>{nameOf(now.format)}: {now.why}</p>
        {holds && <button type="button" disabled={writing.value !== ""} onClick={() => void write(now.version, now.format, true)}>
          Leave out what {nameOf(now.format)} cannot hold</button>}
      </div>
    );
  }
  return (
    <div class="ended" role="status">
      <p><code>{now.name}</code> is written.</p>
      {now.notes.length > 0 && <ul>{now.notes.map((note, i) => <li key={i}>{note}</li>)}</ul>}
    </div>
  );
}
