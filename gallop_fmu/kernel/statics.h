/* Equilibria: the initial one, and that under wind, loads and displaced supports. */
#ifndef GALLOP_STATICS_H
#define GALLOP_STATICS_H

#include "report.h"
#include "state.h"

int statics_initial(gallop_model *model, gallop_report *report);
int statics_equilibrium(const gallop_model *model, double t, const conditions *target,
                        state_view *at, gallop_report *report);

#endif
