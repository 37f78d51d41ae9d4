// The field from above: what stands, what moves, where the chosen robot looks, what clients drew.
import { useCallback, useMemo } from "preact/hooks";
import { palette } from "../shared/palette";
import type { DebugItem, Scenery } from "./api";
import { Canvas, font, type Size } from "./canvas";
import { sample, type Pose, type Replay } from "./replay";
import { recent } from "./reported";
import { robot, time } from "./store";

const body_m = [0.274, 0.154];
const ballRadius_m = 0.042;
const halfView_rad = (57.6 / 2) * (Math.PI / 180);
const trail_s = 4;

export function teamColour(team: string): string {
  if (team === "blue") return palette.after;
  return team === "red" ? palette.before : palette.ink2;
}

interface Frame {
  scale: number;
  x: (m: number) => number;
  y: (m: number) => number;
}

/** What reaches farther out than this does not count for what is shown. */
const surroundings_m = 10;

/** World to canvas: x to the right, y up, the field and what stands around it just fitting in. */
function frameOf(replay: Replay, size: Size): Frame {
  const { field, scenery } = replay.info;
  const [x_m, y_m] = field ? [field.length_m / 2, field.width_m / 2] : [1, 1];
  let [left, right, lower, upper] = [-x_m, x_m, -y_m, y_m];
  for (const { footprint_m } of scenery) {
    if (footprint_m.some((corner) => Math.hypot(...corner) > surroundings_m)) continue;
    for (const [x, y] of footprint_m) {
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [lower, upper] = [Math.min(lower, y), Math.max(upper, y)];
    }
  }
  const margin = 10;
  const scale = Math.min((size.width - 2 * margin) / (right - left), (size.height - 2 * margin) / (upper - lower));
  const [middleX, middleY] = [(left + right) / 2, (lower + upper) / 2];
  return {
    scale,
    x: (m) => size.width / 2 + (m - middleX) * scale,
    y: (m) => size.height / 2 - (m - middleY) * scale,
  };
}

export function Field({ replay }: { replay: Replay }) {
  const teams = useMemo(
    () => new Map(replay.info.robots.map((r) => [r.id, { team: r.team, number: r.number }])), [replay]);
  const draw = useCallback((context: CanvasRenderingContext2D, size: Size) => {
    const frame = frameOf(replay, size);
    for (const item of replay.info.scenery) drawScenery(context, frame, item);
    void replay.truth.arrivals.value;
    const t = replay.clamp(time.value);
    const truth = replay.truth.at(t);
    if (!truth || truth.t.length === 0) return;
    const now = sample(truth, t);
    const chosen = robot.value;
    drawTrails(context, frame, replay, t, chosen);
    const pose = now.robots.get(chosen);
    if (pose) drawView(context, frame, pose);
    for (const [id, at] of now.robots) {
      const { team, number } = teams.get(id) ?? { team: "", number: 0 };
      const label = /\d+$/.exec(id)?.[0] ?? String(number + 1);
      drawRobot(context, frame, at, teamColour(team), label, id === chosen);
    }
    if (now.ball) drawBall(context, frame, now.ball);
    for (const item of recent(replay, chosen, t)) {
      if (item.points && !item.in_image) drawMark(context, frame, item);
    }
  }, [replay, teams]);
  const pick = useCallback((event: PointerEvent, size: Size) => {
    if (event.type !== "pointerdown") return;
    const truth = replay.truth.at(replay.clamp(time.value));
    if (!truth) return;
    const frame = frameOf(replay, size);
    let nearest: [number, string] = [24, ""];
    for (const [id, at] of sample(truth, replay.clamp(time.value)).robots) {
      const distance = Math.hypot(frame.x(at.x) - event.offsetX, frame.y(at.y) - event.offsetY);
      if (distance < nearest[0]) nearest = [distance, id];
    }
    if (nearest[1]) robot.value = nearest[1];
  }, [replay]);
  return <Canvas name={`field ${replay.info.id}`} draw={draw} onPointer={pick} />;
}

function drawScenery(context: CanvasRenderingContext2D, frame: Frame, item: Scenery): void {
  const colour = `rgb(${item.rgb.join(",")})`;
  context.beginPath();
  for (const [x, y] of item.footprint_m) context.lineTo(frame.x(x), frame.y(y));
  context.closePath();
  context.fillStyle = colour;
  context.fill();
  // What is thin stays visible, and what stands on its like.
  context.lineWidth = item.footprint_m.length < 3 ? 2.5 : 1;
  context.strokeStyle = item.footprint_m.length < 3 || item.top_m < 0.01 ? colour : "rgba(0,0,0,0.25)";
  context.stroke();
}

function drawTrails(context: CanvasRenderingContext2D, frame: Frame, replay: Replay, t: number,
  chosen: string): void {
  const ball: number[][] = [];
  const walk: number[][] = [];
  for (const truth of replay.truth.within(t - trail_s, t)) {
    truth.t.forEach((at, i) => {
      if (at < t - trail_s || at > t) return;
      if (truth.ball?.[i]) ball.push(truth.ball[i]);
      if (truth.robots[chosen]?.[i]) walk.push(truth.robots[chosen][i]);
    });
  }
  for (const [trail, colour] of [[ball, "#ffb46b"], [walk, "#ffffff"]] as const) {
    if (trail.length < 2) continue;
    context.beginPath();
    trail.forEach(([x, y], i) => {
      if (i === 0) context.moveTo(frame.x(x), frame.y(y));
      else context.lineTo(frame.x(x), frame.y(y));
    });
    context.strokeStyle = colour;
    context.globalAlpha = 0.75;
    context.lineWidth = 1.5;
    context.stroke();
    context.globalAlpha = 1;
  }
}

/** The wedge of the field that the camera takes in. */
function drawView(context: CanvasRenderingContext2D, frame: Frame, pose: Pose): void {
  const { x, y, heading, elevation } = pose.camera;
  const [left, top] = [frame.x(x), frame.y(y)];
  // What looks steeply up or down takes in little of the plane ahead.
  const reach = 1.5 * frame.scale * Math.max(0.2, Math.cos(elevation));
  context.beginPath();
  context.moveTo(left, top);
  context.arc(left, top, reach, -heading - halfView_rad, -heading + halfView_rad);
  context.closePath();
  const gradient = context.createRadialGradient(left, top, 0, left, top, reach);
  gradient.addColorStop(0, "rgba(255,255,255,0.5)");
  gradient.addColorStop(1, "rgba(255,255,255,0.06)");
  context.fillStyle = gradient;
  context.fill();
}

function drawRobot(context: CanvasRenderingContext2D, frame: Frame, pose: Pose, colour: string,
  label: string, chosen: boolean): void {
  const [length, width] = [Math.max(16, body_m[0] * frame.scale), Math.max(10, body_m[1] * frame.scale)];
  context.save();
  context.translate(frame.x(pose.x), frame.y(pose.y));
  context.rotate(-pose.heading);
  context.beginPath();
  context.roundRect(-length / 2, -width / 2, length, width, width / 4);
  context.fillStyle = colour;
  context.fill();
  context.lineWidth = chosen ? 3 : 1.25;
  context.strokeStyle = chosen ? "#ffe14d" : "#ffffff";
  context.stroke();
  context.translate(length / 2, 0);
  context.rotate(pose.heading - pose.camera.heading);
  context.beginPath();
  context.moveTo(width * 0.42, 0);
  context.lineTo(-width * 0.1, width * 0.3);
  context.lineTo(-width * 0.1, -width * 0.3);
  context.closePath();
  context.fillStyle = "#ffffff";
  context.fill();
  context.restore();
  context.font = font(11, 650);
  context.fillStyle = "#ffffff";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(label, frame.x(pose.x), frame.y(pose.y) + 0.5);
}

function drawBall(context: CanvasRenderingContext2D, frame: Frame, [x, y]: number[]): void {
  context.beginPath();
  context.arc(frame.x(x), frame.y(y), Math.max(4, ballRadius_m * frame.scale), 0, 2 * Math.PI);
  context.fillStyle = "#ff8a1f";
  context.fill();
  context.lineWidth = 1.25;
  context.strokeStyle = "#ffffff";
  context.stroke();
}

/** What the client drew into the world: a line, or a cross for a single point. */
function drawMark(context: CanvasRenderingContext2D, frame: Frame, item: DebugItem): void {
  const points = item.points!;
  context.strokeStyle = "#ffe14d";
  context.lineWidth = 1.75;
  context.beginPath();
  if (points.length === 1) {
    const [x, y] = [frame.x(points[0][0]), frame.y(points[0][1])];
    context.moveTo(x - 5, y - 5);
    context.lineTo(x + 5, y + 5);
    context.moveTo(x - 5, y + 5);
    context.lineTo(x + 5, y - 5);
  } else {
    points.forEach(([x, y], i) => {
      if (i === 0) context.moveTo(frame.x(x), frame.y(y));
      else context.lineTo(frame.x(x), frame.y(y));
    });
  }
  context.stroke();
}
