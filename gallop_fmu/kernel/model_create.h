/* Creation of a model: what its files share. */
#ifndef GALLOP_MODEL_CREATE_H
#define GALLOP_MODEL_CREATE_H

#include "model.h"

/* The one place that decides what is computed; parameters of an FMU make a new model, and so a new
 * decision.  The tables of the model and its devices are known. */
void model_create_parts(gallop_model *m);

/* A field of the scene is varied. */
bool model_create_is_varied(const gallop_scene *s);

/* Where sections and nodes are in varied fields; the initial equilibrium is known. */
int model_create_wind_places(gallop_model *m, gallop_report *report);

#endif
