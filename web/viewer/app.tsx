// The page: one log with its field, camera and plots, or two side by side in step.
import { Camera, Stages } from "./camera";
import { Controls, Help, useKeys } from "./controls";
import { Field, teamColour } from "./field";
import { Panels } from "./panels";
import { SeriesPlot, specs } from "./plots";
import type { Replay } from "./replay";
import { notice, problem, replays, robot, time } from "./store";
import { Timeline } from "./timeline";

export function App() {
  useKeys();
  const logs = replays.value;
  if (logs.length === 0) {
    return <p class="waiting">{problem.value ? `The viewer cannot start: ${problem.value}` : "Reading the log …"}</p>;
  }
  const two = logs.length > 1;
  return (
    <div class={two ? "app two" : "app one"}>
      <header>
        <h1>SEAM <span>viewer</span></h1>
        {logs.map((replay) => <LogTitle key={replay.info.id} replay={replay} two={two} />)}
      </header>
      <div class="chooser">
        <Robots replay={logs[0]} />
        <Stages stages={logs[0].info.stages} />
      </div>
      {two ? <Two logs={logs} /> : <One replay={logs[0]} />}
      <footer>
        <Controls />
        <Timeline />
      </footer>
      {notice.value && <p class="notice" role="status">{notice.value}</p>}
      {problem.value && <p class="notice trouble" role="alert">{problem.value}</p>}
      <Help />
    </div>
  );
}

function One({ replay }: { replay: Replay }) {
  return (
    <main>
      <div class="stage-left">
        <div class="field"><Field replay={replay} /></div>
        <div class="plots">
          {specs.map((spec) => <SeriesPlot key={spec.title} replay={replay} spec={spec} />)}
        </div>
      </div>
      <div class="stage-right">
        <Camera replay={replay} />
        <Panels />
      </div>
    </main>
  );
}

function Two({ logs }: { logs: Replay[] }) {
  return (
    <main>
      {logs.map((replay) => (
        <div class="side" key={replay.info.id} data-side={replay.info.id}>
          <div class="field"><Field replay={replay} /></div>
          <div class="below">
            <Camera replay={replay} />
            <div class="plots">
              {specs.slice(0, 2).map((spec) => <SeriesPlot key={spec.title} replay={replay} spec={spec} />)}
            </div>
          </div>
          <Ended replay={replay} />
        </div>
      ))}
      <Panels />
    </main>
  );
}

function Ended({ replay }: { replay: Replay }) {
  if (time.value <= replay.info.end_s) return null;
  return <p class="ended num">ended at {replay.info.end_s.toFixed(3)} s</p>;
}

function LogTitle({ replay, two }: { replay: Replay; two: boolean }) {
  const { info } = replay;
  return (
    <div class="log-title">
      {two && <b>{info.id}</b>}
      <span class="file">{info.file}</span>
      <span class="quiet">{info.scenario}, seed {info.seed}</span>
      {!two && <span class="quiet" title="Fingerprint of the last state"><code>{info.fingerprint}</code></span>}
      {(!info.complete || info.losses.length > 0) && (
        <span class="badge" title={info.losses.join("\n")}>incomplete</span>
      )}
    </div>
  );
}

function Robots({ replay }: { replay: Replay }) {
  return (
    <div class="robots" role="group" aria-label="Robot">
      {replay.info.robots.map((r, i) => (
        <button key={r.id} type="button" aria-pressed={robot.value === r.id} title={`Key ${i + 1}`}
          onClick={() => (robot.value = r.id)}>
          <i style={{ background: teamColour(r.team) }} />{r.id}
        </button>
      ))}
    </div>
  );
}
