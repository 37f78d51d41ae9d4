// Lines for people. They go to the terminal, with the robot's name and the simulated time, and into
// the log.
#ifndef SEAM_OPEN_R_OSYSLOG_H
#define SEAM_OPEN_R_OSYSLOG_H

#include <OPENR/OPENR.h>

typedef longword OSyslogPriority;
const OSyslogPriority osyslogERROR = 1;
const OSyslogPriority osyslogWARNING = 2;
const OSyslogPriority osyslogINFO = 3;
const size_t osyslogMAX_SIZE = 243;

OStatus osyslog(OSyslogPriority priority, const char* format, ...);
OStatus osysprint(const char* format, ...);

// Arguments in two pairs of parentheses: OSYSPRINT(("%d\n", n)).
#define OSYSPRINT(x) (osysprint x)
#define OSYSLOG1(x) (osyslog x)
#ifdef OPENR_DEBUG
#define OSYSDEBUG(x) (osysprint x)
#else
#define OSYSDEBUG(x)
#endif

#ifndef OSYSLOG_SHOW
#define OSYSLOG_SHOW 1
#endif
#if OSYSLOG_SHOW > 1
#define OSYSLOG2(x) (osyslog x)
#else
#define OSYSLOG2(x)
#endif
#if OSYSLOG_SHOW > 2
#define OSYSLOG3(x) (osyslog x)
#else
#define OSYSLOG3(x)
#endif
#if OSYSLOG_SHOW > 3
#define OSYSLOG4(x) (osyslog x)
#else
#define OSYSLOG4(x)
#endif

#endif
