import { render } from "preact";
import "../shared/theme.css";

render(<main>The viewer.</main>, document.getElementById("app")!);
