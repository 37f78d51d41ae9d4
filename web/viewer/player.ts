// Lets time run: once for each picture of the screen, held while the match around it is loading.
import { effect } from "@preact/signals";
import { condition, end, follow, momentLink, panel, playing, replays, robot, speed, stage, time } from "./store";

const prefetch_s = 6;

export function startPlayer(): void {
  let last: number | undefined;
  const tick = (now: number) => {
    if (!playing.value) {
      last = undefined;
      return;
    }
    const passed = last === undefined ? 0 : Math.min(0.1, (now - last) / 1000);
    last = now;
    if (!waiting()) advance(passed);
    requestAnimationFrame(tick);
  };
  effect(() => {
    if (playing.value) requestAnimationFrame(tick);
  });
  keepAddress();
}

function waiting(): boolean {
  for (const replay of replays.value) {
    const t = replay.clamp(time.value);
    replay.truth.within(t, Math.min(t + prefetch_s * Math.max(1, speed.value), replay.info.end_s));
    if (replay.truth.pending(t)) return true;
  }
  return false;
}

function advance(passed: number): void {
  const t = time.value + passed * speed.value;
  if (t >= end.value) playing.value = false;
  time.value = Math.min(t, end.value);
  follow();
}

/** The address bar names the moment that is shown, a little after it came to rest. */
function keepAddress(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  effect(() => {
    void [time.value, robot.value, stage.value, panel.value, condition.value];
    if (playing.value || replays.value.length === 0) return;
    clearTimeout(timer);
    timer = setTimeout(() => history.replaceState(null, "", momentLink()), 250);
  });
}
