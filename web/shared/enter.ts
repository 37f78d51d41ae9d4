// The token in the address that a server of ours printed, exchanged for its cookie
// (docs/reference/workbench_api.md, "Safety"). The address does not keep it.

/** Throws the server's own sentence where it takes no such token. */
export async function enterByAddress(): Promise<void> {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  history.replaceState(null, "", location.pathname + location.search);
  const answer = await fetch("/api/enter", { method: "POST", credentials: "same-origin",
    headers: { "Content-Type": "application/json" }, body: JSON.stringify({ token }) });
  if (answer.ok) return;
  const body = (await answer.json().catch(() => ({}))) as { error?: string };
  throw new Error(body.error ?? `the server answered ${answer.status}`);
}
