// Play, step, speed, and the keys that do the same.
import { useEffect } from "preact/hooks";
import {
  changeSpeed, end, helpShown, momentLink, nextRobot, nextStage, panel, playing, replays, robot, say, seek, sight, speed,
  speeds, start, stepDecision, stepEvent, stepWorld, time, togglePlay, view, zoom,
} from "./store";
import { clock } from "./timeline";

function Icon({ path }: { path: string }) {
  return <svg width="16" height="16" viewBox="0 0 16 16" aria-hidden="true"><path d={path} /></svg>;
}

const icons = {
  play: "M4 2.5v11l9-5.5z",
  pause: "M4 2.5h3v11H4zM9 2.5h3v11H9z",
  next: "M5 3l6 5-6 5z",
  back: "M11 3L5 8l6 5z",
  nextEvent: "M3 3l6 5-6 5zM11 3h2v10h-2z",
  backEvent: "M13 3L7 8l6 5zM3 3h2v10H3z",
};

export function Controls() {
  return (
    <div class="controls" role="toolbar" aria-label="Playback">
      <div class="buttons">
        <button type="button" onClick={() => stepEvent(-1)} aria-label="Previous event"
          title="Previous event (Shift + ←)"><Icon path={icons.backEvent} /></button>
        <button type="button" onClick={() => void stepWorld(-1)} aria-label="Step back"
          title="One step back (←)"><Icon path={icons.back} /></button>
        <button type="button" class="play" onClick={togglePlay}
          aria-label={playing.value ? "Pause" : "Play"} title="Play or pause (Space)">
          <Icon path={playing.value ? icons.pause : icons.play} /></button>
        <button type="button" onClick={() => void stepWorld(1)} aria-label="Step forward"
          title="One step (→)"><Icon path={icons.next} /></button>
        <button type="button" onClick={() => stepEvent(1)} aria-label="Next event"
          title="Next event (Shift + →)"><Icon path={icons.nextEvent} /></button>
      </div>
      <Clock />
      <label class="speed">
        Speed{" "}
        <select value={String(speed.value)} aria-label="Speed"
          onChange={(event) => (speed.value = Number(event.currentTarget.value))}>
          {speeds.map((s) => <option key={s} value={String(s)}>{s}×</option>)}
        </select>
      </label>
      <span class="spacer" />
      <button type="button" class="text" onClick={() => void copyLink()} title="Copy a link to this moment (L)">
        Copy link</button>
      <button type="button" class="text" onClick={() => (helpShown.value = true)} title="Keys (?)">Keys</button>
    </div>
  );
}

function Clock() {
  const go = (text: string) => {
    const parts = text.trim().split(":").map(Number);
    const t = parts.reduce((sum, part) => sum * 60 + part, 0);
    if (Number.isFinite(t)) seek(t);
    else say(`"${text}" is not a time: write seconds or minutes:seconds.`);
  };
  return (
    <span class="clock num">
      <input aria-label="Time" value={clock(time.value, 0.001)} onFocus={(e) => e.currentTarget.select()}
        onChange={(event) => go(event.currentTarget.value)} />
      <span class="quiet">/ {clock(end.value, 0.001)}</span>
    </span>
  );
}

async function copyLink(): Promise<void> {
  const link = momentLink();
  history.replaceState(null, "", link);
  try {
    await navigator.clipboard.writeText(link);
    say("The link to this moment is on the clipboard.");
  } catch {
    say(link);
  }
}

const keys: [string, string][] = [
  ["Space", "play or pause"],
  ["← →", "one step of the world"],
  ["Shift + ← →", "previous or next event"],
  ["Alt + ← →", "one second"],
  [", .", "previous or next decision of the robot"],
  ["F", "frame of the decision, or the newest frame"],
  ["Home, End", "start or end of the match"],
  ["− +", "slower, faster"],
  ["1 … 9, [ ]", "choose a robot"],
  ["S", "next stage of the camera's chain"],
  ["W, wheel", "whole match in the timeline; the wheel zooms it"],
  ["/", "find a moment by a condition"],
  ["L", "copy a link to this moment"],
  ["?", "these keys"],
];

export function Help() {
  if (!helpShown.value) return null;
  return (
    <div class="shade" onClick={() => (helpShown.value = false)}>
      <div class="help" role="dialog" aria-label="Keys">
        <h2>Keys</h2>
        <table>
          <tbody>{keys.map(([key, what]) => <tr key={key}><th>{key}</th><td>{what}</td></tr>)}</tbody>
        </table>
      </div>
    </div>
  );
}

/** One key, one action; typing into a field is left alone. */
export function useKeys(): void {
  useEffect(() => {
    const listen = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      if (["INPUT", "SELECT", "TEXTAREA"].includes(target.tagName) || event.ctrlKey || event.metaKey) return;
      if (act(event)) event.preventDefault();
    };
    window.addEventListener("keydown", listen);
    return () => window.removeEventListener("keydown", listen);
  }, []);
}

function arrow(direction: 1 | -1, event: KeyboardEvent): void {
  if (event.shiftKey) stepEvent(direction);
  else if (event.altKey) seek(time.value + direction);
  else void stepWorld(direction);
}

function act(event: KeyboardEvent): boolean {
  const ids = replays.value[0]?.info.robots.map((r) => r.id) ?? [];
  switch (event.key) {
    case " ": togglePlay(); return true;
    case "ArrowRight": arrow(1, event); return true;
    case "ArrowLeft": arrow(-1, event); return true;
    case "Home": seek(start.value); return true;
    case "End": seek(end.value); return true;
    case "+": case "=": changeSpeed(1); return true;
    case "-": changeSpeed(-1); return true;
    case "[": nextRobot(-1); return true;
    case "]": nextRobot(1); return true;
    case ",": void stepDecision(-1); return true;
    case ".": void stepDecision(1); return true;
    case "f": case "F": sight.value = sight.value === "time" ? "decision" : "time"; return true;
    case "s": case "S": nextStage(); return true;
    case "w": case "W": view.value = [start.value, Math.max(end.value, start.value + 0.1)]; return true;
    case "z": zoom(0.5, time.value); return true;
    case "l": case "L": void copyLink(); return true;
    case "/": panel.value = "find"; return true;
    case "?": helpShown.value = !helpShown.value; return true;
    case "Escape": helpShown.value = false; return true;
  }
  if (/^[1-9]$/.test(event.key) && ids[Number(event.key) - 1]) {
    robot.value = ids[Number(event.key) - 1];
    return true;
  }
  return false;
}
