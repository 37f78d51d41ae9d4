import { render } from "preact";
import "../shared/theme.css";
import "../shared/parts.css";
import { readReport, type Report } from "./data";
import { Page } from "./page";
import "./report.css";

const app = document.getElementById("app")!;
let report: Report | undefined;
const isBroken = (text: string) => {
  app.textContent = text;
  app.className = "broken";
};
try {
  report = readReport();
} catch (error) {
  isBroken((error as Error).message);
}
if (report) {
  document.title = `${report.title ?? report.data?.title ?? "Report"} – SEAM`;
  try {
    render(<Page report={report} />, app);
  } catch (error) {
    isBroken(`This page's data is not of the form that its format has (${(error as Error).message}). Make the result anew.`);
  }
}
