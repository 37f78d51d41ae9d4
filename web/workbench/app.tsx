// The frame of all screens: where one is, what is saved, undo, and what the last click was as a command.
import { useEffect } from "preact/hooks";
import { count } from "../shared/format";
import { askToLeaveOut } from "./chosen";
import { DataScreen } from "./data";
import { FormulaScreen } from "./formula";
import { Keys, showKeys } from "./keys";
import { OpenScreen } from "./open";
import { PlanScreen } from "./plan";
import { SeeScreen } from "./see";
import { SessionScreen } from "./tree";
import { WorkScreen } from "./work";
import { addEffect, busy, connected, notice, pointed, problem, redo, refused, restore, saved, say, screen, screens, session, stopSearch, undo } from "./store";

/** Keys that hold on every screen; fields keep theirs. */
function useKeys(): void {
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      const typing = (event.target as HTMLElement).closest?.("input, textarea, select, .cm-editor");
      if (event.key === "Escape" && !document.querySelector("dialog[open]")) restore();
      else if (typing) return;
      else if (event.key === "Enter" && event.target === document.body && screen.value === "work" && pointed.value && !busy.value) {
        void addEffect(pointed.value);
      }
      else if (event.key === "?") showKeys();
      else if (event.key === "Delete" && screen.value === "work") askToLeaveOut();
      else if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z") {
        event.preventDefault();
        void (event.shiftKey ? redo() : undo());
      } else if (event.altKey && session.value?.set && screens[Number(event.key) - 1]) {
        event.preventDefault();
        screen.value = screens[Number(event.key) - 1][0];
      }
    };
    addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  }, []);
}

export function App() {
  useKeys();
  if (refused.value) {
    return (
      <main class="alone"><h1>The workbench cannot start</h1>
        <p role="alert">{refused.value}</p>
        <p class="quiet">Start it with <code>seam workbench FOLDER</code> and open the address that it prints.</p></main>
    );
  }
  if (!session.value) return <main class="alone"><p role="status">Reading the session …</p></main>;
  return (
    <div class={`app on-${screen.value}`}>
      <TopBar />
      <Messages />
      <main>{bodyOf(screen.value)}</main>
      <CommandBar />
    </div>
  );
}

function bodyOf(name: string) {
  switch (name) {
    case "open": return <OpenScreen />;
    case "data": return <DataScreen />;
    case "formula": return <FormulaScreen />;
    case "see": return <SeeScreen />;
    case "plan": return <PlanScreen />;
    case "session": return <SessionScreen />;
    default: return <WorkScreen />;
  }
}

function TopBar() {
  const now = session.value!;
  return (
    <header class="top">
      <button type="button" class="brand" onClick={() => (screen.value = "open")} title="Open other measurements">
        SEAM <span>workbench</span></button>
      {now.set && (
        <nav aria-label="Screens">
          {screens.map(([name, label], i) => (
            <button key={name} type="button" aria-current={screen.value === name ? "page" : undefined} title={`Alt ${i + 1}`}
              onClick={() => (screen.value = name)}>{label}</button>
          ))}
        </nav>
      )}
      {now.set && (
        <div class="history">
          <Saved />
          <button type="button" disabled={!now.canUndo || busy.value !== ""} onClick={() => void undo()} title="Ctrl Z">Undo</button>
          <button type="button" disabled={!now.canRedo || busy.value !== ""} onClick={() => void redo()} title="Ctrl Shift Z">Redo</button>
          <Keys />
        </div>
      )}
    </header>
  );
}

function Saved() {
  const [kind, text] = !connected.value ? ["lost", "no connection"] : busy.value ? ["busy", `${busy.value} …`]
    : saved.value ? ["good", "saved"] : ["lost", "not saved"];
  return <span class={`saved ${kind}`} role="status">{text}</span>;
}

function Messages() {
  return (
    <div class="messages">
      {problem.value && (
        <p class="message trouble" role="alert">{problem.value}{" "}
          <button type="button" class="link" onClick={() => (problem.value = "")}>close</button></p>
      )}
      <Job />
      {session.value?.problem && <p class="message trouble" role="alert">Not saved: {session.value.problem}</p>}
    </div>
  );
}

/** A command that the page asked for: how far it is, and a way to end it. */
function Job() {
  const job = session.value?.job;
  if (!job || job.version !== undefined) return null;
  return (
    <div class="message job" aria-label="What is being computed" role="group">
      <span role="status">{job.doing || job.what}{job.of > 0 && <span class="num">, {count(job.done)} of {count(job.of)}</span>} …</span>
      <progress max={job.of || 1} value={job.of ? job.done : undefined} aria-label={job.what} />
      <button type="button" onClick={stopSearch}>Cancel</button>
    </div>
  );
}

/** What the last click was, so that a script can repeat it. */
function CommandBar() {
  const { command, set } = session.value!;
  const says = notice.value && <p class="toast" role="status">{notice.value}</p>;
  if (!set || !command) return <>{says}</>;
  const copy = () => navigator.clipboard.writeText(command).then(() => say("The command is in the clipboard."),
    () => say("The browser gave no access to the clipboard."));
  return (
    <footer class="command" aria-label="The last step as a command">
      <code tabIndex={0}>{command}</code>
      {says}
      <button type="button" onClick={copy}>Copy</button>
    </footer>
  );
}
