// The program behind the workbench's page, as a person starts it.
import { spawn } from "node:child_process";
import { join, resolve } from "node:path";

/** Starts it on a set with a session; gives the address that it prints, and `end`, after which it has gone. */
export async function startProgram(seam, share, set, session) {
  const child = spawn(resolve(seam), ["workbench", set, "--session", session], { cwd: join(session, ".."), stdio: ["ignore", "pipe", "inherit"],
    env: { ...process.env, XDG_STATE_HOME: session, SEAM_WORKBENCH_DIR: join(resolve(share), "workbench") } });
  process.on("exit", () => child.kill()); // Whatever ends a test.
  const address = await new Promise((done, fail) => {
    let text = "";
    child.stdout.on("data", (piece) => {
      text += piece;
      if (text.includes("\n")) done(text.split("\n")[0]);
    });
    child.on("exit", (code) => fail(new Error(`seam workbench ended with ${code}`)));
  });
  const end = async () => {
    child.removeAllListeners("exit");
    const gone = new Promise((done) => child.on("exit", done));
    child.kill();
    await gone;
  };
  return { address, end };
}
