/* How the outcome of a call gets into a report. */
#ifndef GALLOP_REPORT_H
#define GALLOP_REPORT_H

#include "gallop.h"
#include <stdbool.h>

/* Sets what a call reports; returns the outcome. */
int report_failure(gallop_report *report, int outcome, int element, double time, double value,
                   double limit);

/* A device has no equilibrium: because of this quantity of it, a constant text. */
int report_device(gallop_report *report, int device, double time, const char *field, double value,
                  double limit);

/* An equilibrium is unstable, most of all at an element. */
int report_unstable(gallop_report *report, int element, double time);

/* Success; failures on the way to it are forgotten. */
int report_completed(gallop_report *report, double time);

/* A number of the scene is impossible. */
int report_invalid(gallop_report *report, const char *field, double value, double limit);

/* An argument of a call cannot be used. */
int report_refused(gallop_report *report, const char *field, double value, double limit);

/* Clears the report; false where there is none that can be written. */
bool report_start(gallop_report *report, double time);

#endif
