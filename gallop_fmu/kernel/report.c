/* How the outcome of a call gets into a report. */
#include "report.h"

#include "base_memory.h"

#include <math.h>

int report_failure(gallop_report *report, int outcome, int element, double time, double value,
                   double limit)
{
    if (report) {
        report->outcome = outcome;
        report->element = element;
        report->device = -1;
        report->time = time;
        report->value = value;
        report->limit = limit;
        report->field = NULL;
    }
    return outcome;
}

int report_device(gallop_report *report, int device, double time, const char *field, double value,
                  double limit)
{
    report_failure(report, GALLOP_EQUILIBRIUM_NOT_FOUND, -1, time, value, limit);
    if (report) {
        report->device = device;
        report->field = field;
    }
    return GALLOP_EQUILIBRIUM_NOT_FOUND;
}

int report_unstable(gallop_report *report, int element, double time)
{
    report_failure(report, GALLOP_EQUILIBRIUM_NOT_FOUND, element, time, NAN, NAN);
    if (report) report->field = "it would be unstable there";
    return GALLOP_EQUILIBRIUM_NOT_FOUND;
}

int report_completed(gallop_report *report, double time)
{
    return report_failure(report, GALLOP_COMPLETED, -1, time, 0.0, 0.0);
}

int report_invalid(gallop_report *report, const char *field, double value, double limit)
{
    report_failure(report, GALLOP_INVALID_SCENE, -1, 0.0, value, limit);
    report->field = field;
    return GALLOP_INVALID_SCENE;
}

int report_refused(gallop_report *report, const char *field, double value, double limit)
{
    report_failure(report, GALLOP_BAD_CALL, -1, report->time, value, limit);
    report->field = field;
    return GALLOP_BAD_CALL;
}

bool report_start(gallop_report *report, double time)
{
    if (!base_pointer_usable(report, WORD)) return false;
    *report = (gallop_report){.element = -1, .device = -1, .time = time, .lowest_tension = NAN};
    return true;
}
