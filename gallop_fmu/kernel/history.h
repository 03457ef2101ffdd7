/* What the files history*.c share; see gallop_history.h. */
#ifndef HISTORY_H
#define HISTORY_H

#include "base_lanes.h"
#include "gallop_history.h"

/* Scratch memory for histories of `count` samples. */
typedef struct {
    int64_t count, size;           /* size: length of the transform, a power of two */
    double *window;                /* (count): Hann's window */
    double *cosine, *sine;         /* (size / 2): of 2 pi k / size */
    lanes *windowed;               /* (count): samples of LANES histories, times the window */
    lanes *real[2], *imaginary[2]; /* (size / 2) each: the transform, and room for its stages */
    double *finer[2];              /* interpolated samples, in the place of the transform */
    double *envelope, *logarithm;  /* (count) */
} history_room;

/* Interpolated samples of a history, scaled to lie between -1 and 1. */
typedef struct {
    const double *values;
    int64_t count;
    double period; /* [samples] */
} history_fine;

typedef struct {
    double lowest, highest;
    int64_t lowest_at, highest_at;
} history_range;

/* Bytes that a room for `count` samples needs, and the room in such memory. */
size_t history_room_size(int64_t count);
history_room history_room_in(void *work, int64_t count);

/* Sum of values less `shift`, or of the squares of these: in pairs of pairs, as NumPy adds. */
double history_sum(const double *values, int64_t count, double shift, bool squared);

/* Smallest and largest of one or more values that are numbers, and the first place of each. */
history_range history_range_of(const double *values, int64_t count);

/* Hann's window of `count` samples, two or more, with scratch memory of this length. */
void history_window(int64_t count, double *window, double *scratch);

/* Fill in the tables of a room that the next function reads. */
void history_prepare_lines(const history_room *room);

/* Largest spectral line [cycles a sample] of each of up to LANES histories, from their values and
 * from their numbers up to GALLOP_HISTORY_MEAN, to GALLOP_HISTORY_FREQUENCY. */
void history_lines(const history_room *room, int histories, const double *const values[],
                   double *const numbers[]);

/* Whether a history has one or more cycles, of enough samples each, by its numbers up to
 * GALLOP_HISTORY_FREQUENCY. */
bool history_has_cycles(const double *numbers, int64_t samples);

/* Interpolate a history until a cycle has a sufficient number of samples. */
history_fine history_refine(const history_room *room, const double *values, const double *numbers);

/* Envelope of blocks of `cycles` cycles; returns the number of blocks, 0 for fewer than three. */
int64_t history_envelope(const history_fine *fine, int cycles, double *envelope);

/* The numbers of a history with cycles, from GALLOP_HISTORY_BLOCKS on. */
void history_cycles(const history_room *room, const double *values, double even, double *numbers);

#endif
