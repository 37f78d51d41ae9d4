// Drawing in turns: what would take long at once is done piece by piece, and between the pieces the page answers.

type Work = () => void;

/** No task of the page is much longer than this and one piece: a click is answered before a person sees that it was not. */
const longest_ms = 12;

/** By whom it is wanted: who wants again before the turn has come, wants only the last. */
const wanted = new Map<object, Work>();
const afterwards = new Map<object, Work>();
const channel = new MessageChannel();
let running = false;

channel.port1.onmessage = () => void work();

function begin(): void {
  if (running) return;
  running = true;
  document.documentElement.dataset.drawing = "true"; // For whoever waits for the page.
  channel.port2.postMessage(0);
}

function take(of: Map<object, Work>): Work | undefined {
  const [first] = of;
  if (!first) return undefined;
  of.delete(first[0]);
  return first[1];
}

async function work(): Promise<void> {
  running = false;
  for (const end = performance.now() + longest_ms; performance.now() < end;) {
    const next = take(wanted) ?? take(afterwards);
    if (!next) break;
    try {
      next();
    } catch (error) {
      reportError(error);
    }
    await null; // What it has changed is rendered here.
  }
  if (wanted.size + afterwards.size > 0) begin();
  else if (!running) delete document.documentElement.dataset.drawing;
}

/** Does this when its turn comes. */
export function inTurn(who: object, what: Work): void {
  wanted.set(who, what);
  begin();
}

/** Does this once nothing waits for its turn. */
export function afterTurns(who: object, what: Work): void {
  afterwards.set(who, what);
  begin();
}

export function forget(who: object): void {
  wanted.delete(who);
  afterwards.delete(who);
}
