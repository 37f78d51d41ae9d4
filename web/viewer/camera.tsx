// A robot's eyes: its frame at this moment in any stage, what its client saw in it, and when each
// row took its light.
import { effect, signal } from "@preact/signals";
import { useCallback, useEffect, useMemo } from "preact/hooks";
import { palette } from "../shared/palette";
import { ask, askPicture, type FrameRows, type Picture } from "./api";
import { Canvas, font, type Size } from "./canvas";
import { lastAt, type Replay } from "./replay";
import { decisionAt, marksOn } from "./reported";
import { nextStage, playing, robot, sight, stage, time } from "./store";

interface Eye {
  picture: ReturnType<typeof signal<Picture | null>>;
  rows: ReturnType<typeof signal<FrameRows | null>>;
  trouble: ReturnType<typeof signal<string>>;
}

/** The index of the frame to show at `t`, or undefined to let the server find it by time. */
function frameAt(replay: Replay, id: string, t: number): number | undefined {
  const decided = sight.value === "decision" ? decisionAt(replay, id, t)?.frame : undefined;
  if (decided !== undefined) return decided;
  const chunks = replay.frames(id);
  void chunks.arrivals.value;
  const frames = chunks.at(t);
  if (!frames || frames.length === 0) return undefined;
  const i = lastAt({ length: frames.length, at: (k) => frames[k].t }, t);
  // Before the camera's first frame its first one is shown: there is nothing else to see.
  if (i < 0 && frames[0].t - t < 0.5) return frames[0].index;
  // Between frames that lie far apart the server renders what the camera would have seen.
  return i >= 0 && t - frames[i].t < 0.5 ? frames[i].index : undefined;
}

/** Asks for one picture at a time, always the newest wish: a slow server shows fewer frames. */
function useEye(replay: Replay): Eye {
  const eye = useMemo<Eye>(() => ({ picture: signal<Picture | null>(null),
    rows: signal<FrameRows | null>(null), trouble: signal("") }), [replay]);
  useEffect(() => {
    let shown = "";
    let wish: { key: string; query: Record<string, string | number> } | null = null;
    let busy = false;
    let gone = false;
    const work = async () => {
      busy = true;
      while (wish && !gone) {
        const { key, query } = wish;
        wish = null;
        try {
          const picture = await askPicture(query);
          eye.picture.value = picture;
          eye.trouble.value = "";
          shown = key;
          if (!playing.peek()) {
            eye.rows.value = await ask<FrameRows>("frame_rows",
              { log: query.log, robot: query.robot, index: picture.index });
          }
        } catch (error) {
          eye.trouble.value = (error as Error).message;
          shown = key;
        }
      }
      busy = false;
    };
    const stop = effect(() => {
      const id = robot.value;
      if (!id) return;
      const t = replay.clamp(time.value);
      const index = frameAt(replay, id, t);
      const query: Record<string, string | number> =
        { log: replay.info.id, robot: id, stage: stage.value };
      if (index === undefined) query.t = Math.floor(t * 100) / 100;
      else query.index = index;
      // When it comes to rest the row times are wanted too.
      const key = JSON.stringify(query) + playing.value;
      if (key === shown) return;
      wish = { key, query };
      if (!busy) void work();
    });
    return () => {
      gone = true;
      stop();
    };
  }, [replay, eye]);
  return eye;
}

export function Camera({ replay }: { replay: Replay }) {
  const eye = useEye(replay);
  const camera = replay.info.robots.find((r) => r.id === robot.value)?.camera;
  const [width, height] = [camera?.width_px ?? 178, camera?.height_px ?? 144];
  const drawImage = useCallback((context: CanvasRenderingContext2D, size: Size) => {
    const picture = eye.picture.value;
    if (picture) {
      context.imageSmoothingEnabled = false;
      context.drawImage(picture.bitmap, 0, 0, size.width, size.height);
      drawReported(context, size, replay, picture, width, height);
    }
  }, [eye, replay, width, height]);
  const drawTimes = useCallback((context: CanvasRenderingContext2D, size: Size) => {
    const rows = eye.rows.value;
    const picture = eye.picture.value;
    if (rows && picture && rows.index === picture.index) drawRowTimes(context, size, rows, time.value);
  }, [eye]);
  const picture = eye.picture.value;
  const decision = sight.value === "decision" && robot.value
    ? decisionAt(replay, robot.value, replay.clamp(time.value)) : undefined;
  const delay = lineDelay_ms(eye.rows.value, picture?.index);
  return (
    <section class="camera" aria-label={`Camera of ${robot.value}`}>
      <div class="camera-views">
        <div class="picture" style={{ aspectRatio: `${width} / ${height}` }}>
          <Canvas name={`camera ${replay.info.id}`} draw={drawImage} />
          {eye.trouble.value && <p class="trouble">{eye.trouble.value}</p>}
        </div>
        <div class="row-times" title="When each row of this frame took its light">
          <Canvas name={`rows ${replay.info.id}`} draw={drawTimes} />
        </div>
      </div>
      <p class="caption num" data-frame={picture?.index}>
        {picture ? <>frame {picture.index}, {picture.stamp_s.toFixed(3)} s
          {decision?.frame === picture.index &&
            <span class="decided">{" · "}decided from at {decision.t.toFixed(3)} s</span>}
          {delay !== null && <>{" · "}{delay.toFixed(3)} ms a row</>}
          {" · "}{picture.recorded ? "recorded" : "rendered now"}
          {picture.matches === true && <span class="ok"> · same bits as in the match</span>}
          {picture.matches === false && <span class="warn"> · differs from the match</span>}</>
          : "…"}
        {" "}<button type="button" class="link" title="F: frame of the decision, or the newest frame"
          onClick={() => (sight.value = sight.value === "time" ? "decision" : "time")}>
          {sight.value === "time" ? "show the decision's frame" : "show the newest frame"}</button>
      </p>
    </section>
  );
}

/** From one row's start to the next one's. */
function lineDelay_ms(frame: FrameRows | null | undefined, index: number | undefined): number | null {
  if (!frame || frame.index !== index || frame.rows.length < 2) return null;
  const span = BigInt(frame.rows[frame.rows.length - 1].start_ns) - BigInt(frame.rows[0].start_ns);
  return Number(span) / 1e6 / (frame.rows.length - 1);
}

export function Stages({ stages }: { stages: string[] }) {
  return (
    <div class="segments" role="group" aria-label="Stage of the camera's chain">
      {stages.map((name) => (
        <button key={name} type="button" aria-pressed={stage.value === name}
          onClick={() => (stage.value = name)} title="S: next stage" onContextMenu={nextStage}>
          {name}
        </button>
      ))}
    </div>
  );
}

const reportColour = "#ffe14d";

function drawReported(context: CanvasRenderingContext2D, size: Size, replay: Replay, picture: Picture,
  width: number, height: number): void {
  const [sx, sy] = [size.width / width, size.height / height];
  context.lineWidth = 1.75;
  context.font = font(11, 600);
  const t = replay.clamp(time.value);
  for (const item of marksOn(replay, robot.value, picture.index, t)) {
    const at = item.points!.map(([u, v]) => [(u + 0.5) * sx, (v + 0.5) * sy]);
    context.strokeStyle = reportColour;
    context.beginPath();
    if (at.length === 1) context.arc(at[0][0], at[0][1], 5, 0, 2 * Math.PI);
    at.forEach(([x, y], i) => {
      if (at.length > 1) i === 0 ? context.moveTo(x, y) : context.lineTo(x, y);
    });
    context.stroke();
    const top = at.reduce((best, p) => (p[1] < best[1] ? p : best));
    const label = context.measureText(item.name).width;
    const x = Math.min(Math.max(2, top[0]), size.width - label - 8);
    const y = Math.max(16, top[1] - 4);
    context.fillStyle = "rgba(20,24,30,0.72)";
    context.fillRect(x - 3, y - 12, label + 6, 15);
    context.fillStyle = reportColour;
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    context.fillText(item.name, x, y);
  }
}

/** Time to the right, rows down: the slanted band is the rolling shutter. */
function drawRowTimes(context: CanvasRenderingContext2D, size: Size, frame: FrameRows, t: number): void {
  const zero = BigInt(frame.rows[0]?.start_ns ?? frame.stamp_ns);
  const offsets = frame.rows.map((row) => [Number(BigInt(row.start_ns) - zero) / 1e6,
    Number(BigInt(row.end_ns) - zero) / 1e6]);
  if (offsets.length === 0) return;
  const low = Math.min(...offsets.map((o) => o[0]));
  const high = Math.max(...offsets.map((o) => o[1]), low + 1e-3);
  const bottom = size.height - 16;
  const x = (ms: number) => 2 + ((ms - low) / (high - low)) * (size.width - 4);
  const rowHeight = bottom / offsets.length;
  context.fillStyle = palette.sky;
  offsets.forEach(([from, to], row) => {
    context.fillRect(x(from), row * rowHeight, Math.max(1, x(to) - x(from)), Math.max(0.6, rowHeight));
  });
  const now = Number(BigInt(Math.round(t * 1e9)) - zero) / 1e6;
  if (now >= low && now <= high) {
    context.fillStyle = palette.before;
    context.fillRect(x(now) - 0.75, 0, 1.5, bottom);
  }
  context.fillStyle = palette.ink3;
  context.font = font(10.5);
  context.textBaseline = "bottom";
  context.textAlign = "left";
  if (size.width > 60) context.fillText(`${low.toFixed(0)}`, 0, size.height);
  context.textAlign = "right";
  context.fillText(`${high.toFixed(1)} ms`, size.width, size.height);
}
