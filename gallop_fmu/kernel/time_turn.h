/* A factorised tangent turns with the cable.
 *
 * The tangent is stiff along the cable, and the cable turns while its factors are used.  An error
 * of the tension then pushes along directions that the factors do not know, and what they make of
 * the rest is a transverse motion that the next iteration has to take back.  So, at each node, the
 * force along the cable now, of direction e, is given to the factors in their own direction e', and
 * the correction along e' is taken along e: with W = 1 + (e' - e) e^T, the inverse of the tangent K
 * is W^T K'^-1 W.  The directions are those between the neighbouring nodes; at junctions W is 1. */
#ifndef GALLOP_TIME_TURN_H
#define GALLOP_TIME_TURN_H

#include "state.h"

/* x += along (by . x), of the four unknowns of a node. */
INLINE void turn_shear(lanes x[LANE_GROUPS], const lanes by[LANE_GROUPS],
                       const lanes along[LANE_GROUPS])
{
#if LANES == 4
    lanes product = x[0] * by[0];
    product += MERGE(product, product, 1, 0, 3, 2);
    product += MERGE(product, product, 2, 3, 0, 1);
    x[0] += product * along[0];
#else
    double product = 0.0;
    for (int i = 0; i < 4; i++) product += x[i] * by[i];
    for (int i = 0; i < 4; i++) x[i] += product * along[i];
#endif
}

/* What a turn reads and keeps: directions that the factors have, and those of now. */
typedef struct {
    const double *chord, *chord_inverse, *factored;
    double *along;
} turning;

INLINE turning turn_of(const gallop_model *model, const state_view *at)
{
    return (turning){model->chord, model->chord_inverse, at->factored, at->along};
}

/* The direction of the cable at the node whose unknowns begin at u + n. */
INLINE void turn_direction(const turning *t, const double *u, int n, lanes *along)
{
    const lanes chord = LANES_AT(t->chord + n) + (LANES_AT(u + n + 4) - LANES_AT(u + n - 4));
    *along = chord * LANES_AT(t->chord_inverse + n);
}

/* The factors are made for the directions at u, of the nodes whose unknowns are `first` to `end`.
 */
INLINE void turn_note(const turning *t, const double *u, int first, int end, double *factored)
{
    for (int n = first; n < end; n += LANES) turn_direction(t, u, n, (lanes *)(factored + n));
}

/* Turns the force on a node, whose unknowns begin at u + n, to the factors' direction; keeps the
 * direction of now at along + first + n. */
INLINE void turn_force(const turning *t, const double *u, int first, int n,
                       lanes force[LANE_GROUPS])
{
    lanes along[LANE_GROUPS], change[LANE_GROUPS];
    for (int i = 0; i < LANE_GROUPS; i++) {
        turn_direction(t, u, n + LANES * i, &along[i]);
        change[i] = LANES_AT(t->factored + n + LANES * i) - along[i];
        LANES_AT(t->along + first + n + LANES * i) = along[i];
    }
    turn_shear(force, along, change);
}

/* Turns a correction from the factors' direction to that kept by turn_force. */
INLINE void turn_back(const turning *t, int first, int n, lanes correction[LANE_GROUPS])
{
    lanes along[LANE_GROUPS], change[LANE_GROUPS];
    for (int i = 0; i < LANE_GROUPS; i++) {
        along[i] = LANES_AT(t->along + first + n + LANES * i);
        change[i] = LANES_AT(t->factored + n + LANES * i) - along[i];
    }
    turn_shear(correction, change, along);
}

#endif
