import { render } from "preact";
import { enterByAddress } from "../shared/enter";
import "../shared/theme.css";
import { App } from "./app";
import { openSearch } from "./find";
import { keepLanes } from "./lanes";
import { startPlayer } from "./player";
import { load, problem } from "./store";
import "./viewer.css";

render(<App />, document.getElementById("app")!);
enterByAddress()
  .then(load)
  .then(() => {
    startPlayer();
    keepLanes();
    openSearch();
  })
  .catch((error: Error) => {
    problem.value = error.message;
  });
