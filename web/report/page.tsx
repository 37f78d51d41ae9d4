// The order of the page: the answer first, then where it shows, then how it was found.
import { OverImage } from "./image";
import { Candidates } from "./candidates";
import type { Report } from "./data";
import { Distributions, ErrorFalling, Worth } from "./errors";
import { Figures } from "./figures";
import { Formula } from "./formula";
import { Advice, LookedFor, NotTestable, Outliers, Reproduce, Tables } from "./notes";
import { Residuals } from "./residuals";
import { IntervalPlots, Modes, SeriesPlots } from "./series";
import { Structure } from "./structure";
import { LensMapFigure, TargetPicture } from "./target";
import { Header } from "./summary";

export function Page({ report }: { report: Report }) {
  return (
    <main>
      <Header report={report} />
      <Formula report={report} />
      <Advice report={report} />
      <Modes report={report} />
      <ErrorFalling report={report} />
      <Candidates report={report} />
      <Structure report={report} />
      <Figures report={report} />
      <Residuals report={report} />
      <OverImage report={report} />
      <LensMapFigure report={report} />
      <TargetPicture report={report} />
      <SeriesPlots report={report} />
      <IntervalPlots report={report} />
      <Worth report={report} />
      <Distributions report={report} />
      <Tables report={report} />
      <LookedFor report={report} />
      <NotTestable report={report} />
      <Outliers report={report} />
      <Reproduce report={report} />
    </main>
  );
}
