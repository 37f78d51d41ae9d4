import { render } from "preact";
import "../shared/theme.css";
import "../shared/parts.css";
import { readReport, type Report } from "./data";
import { Page } from "./page";
import "./report.css";

const app = document.getElementById("app")!;
let report: Report | undefined;
try {
  report = readReport();
} catch (error) {
  app.textContent = (error as Error).message;
  app.className = "broken";
}
if (report) {
  document.title = `${report.title ?? report.data?.title ?? "Report"} – SEAM`;
  render(<Page report={report} />, app);
}
