/* Checks of the arguments of exported functions. */
#ifndef GALLOP_CHECK_H
#define GALLOP_CHECK_H

#include "base_memory.h"
#include "report.h"
#include "state.h"

#define MAX_STEPS 1e12 /* in one call: more would not end */

bool check_finite(const double *values, size_t count);
void check_mark_model(gallop_model *model);
void check_mark_state(const gallop_model *model, gallop_state *state);
bool check_is_model(const gallop_model *model);
bool check_is_started(const gallop_state *state);
bool check_is_state_of(const gallop_model *model, const gallop_state *state);
int check_room(const gallop_model *model, const gallop_state *state, double time,
               gallop_report *report);
int check_state(const gallop_model *model, const gallop_state *state, gallop_report *report);
int check_inputs(const gallop_model *model, const gallop_inputs *inputs, double until,
                 gallop_report *report);
int check_probes(const gallop_model *model, const gallop_probe *probe, int32_t probes,
                 gallop_report *report);

/* check_scene.c: before a model copies them */
int check_scene(const gallop_scene *s, gallop_report *report);

/* check_shedding.c: item `index` of the table */
int check_shedding(const gallop_scene *s, int32_t index, gallop_report *report);

#endif
