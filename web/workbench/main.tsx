import { render } from "preact";
import "../shared/theme.css";
import "../shared/parts.css";
import { App } from "./app";
import { refused, start } from "./store";
import "./shell.css";
import "./work.css";
import "./screens.css";

render(<App />, document.getElementById("app")!);
start().catch((error: Error) => (refused.value = error.message));
