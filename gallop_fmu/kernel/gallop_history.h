/* Numbers of recorded histories, on which the judgement of a motion rests: size, mean, frequency,
 * and how the envelope changes from cycle to cycle.  The bounds of the judgement are Python's
 * (gallop_fmu/simulation/steadiness.py), which has the reasons.
 *
 * The rules of gallop.h hold.  The files history*.c are not part of an FMU.
 */
#ifndef GALLOP_HISTORY_H
#define GALLOP_HISTORY_H

#include "gallop.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of a history, in the unit of its values unless stated otherwise.
 *
 * Those from GALLOP_HISTORY_BLOCKS on describe the cycles of the dominant frequency, of values that
 * were scaled to lie between -1 and 1 and interpolated to at least 64 samples in a cycle.  The
 * envelope is half the range of blocks of whole cycles, which overlap by a quarter of a cycle.  If
 * there are fewer than three blocks, or fewer than five samples in a cycle, BLOCKS is 0 and the
 * numbers after it are NaN. */
typedef enum {
    GALLOP_HISTORY_LOWEST,
    GALLOP_HISTORY_HIGHEST,
    GALLOP_HISTORY_MEAN,
    GALLOP_HISTORY_DEVIATION, /* standard deviation */
    GALLOP_HISTORY_FREQUENCY, /* [cycles a sample] of the largest spectral line; NaN without one */
    GALLOP_HISTORY_BLOCKS,  /* [1] in the window: blocks of one to four cycles, at most about 18 */
    GALLOP_HISTORY_SPACING, /* [1] from one block to the next, over the length of the window */
    /* mean logarithm of the envelope over each third of the blocks */
    GALLOP_HISTORY_LOG_1,
    GALLOP_HISTORY_LOG_2,
    GALLOP_HISTORY_LOG_3,
    GALLOP_HISTORY_TREND, /* share of the variance of these logarithms that a parabola explains */
    /* least range of the envelope over its mean, of blocks of one, two, three and four cycles */
    GALLOP_HISTORY_RANGE,
    GALLOP_HISTORY_FALL, /* 1 - smallest / largest value of the envelope of single cycles */
    /* effective value over sqrt(2) of the difference from one cycle to the next, in each third */
    GALLOP_HISTORY_HIDDEN_1,
    GALLOP_HISTORY_HIDDEN_2,
    GALLOP_HISTORY_HIDDEN_3,
    GALLOP_HISTORY_HALF_1, /* half of the range in the first half of the window */
    GALLOP_HISTORY_HALF_2, /* and in the second */
    GALLOP_HISTORY_NUMBERS
} gallop_history_number;

#define GALLOP_HISTORY_MAX_SAMPLES ((int64_t)1 << 32)

/* Size of the scratch memory that the functions below need.
 *
 * @param samples  Number of samples of a history
 * @return         [bytes]; 0 if it is not between 1 and GALLOP_HISTORY_MAX_SAMPLES
 */
GALLOP_API size_t gallop_history_size(int64_t samples);

/* Numbers of several histories of equally spaced samples.  Values may be infinite or not a number;
 * the numbers that depend on them then are not finite.
 *
 * @param samples    Number of samples of each history
 * @param histories  Number of histories, 1 or more
 * @param values     (histories, samples)
 * @param even       GALLOP_HISTORY_RANGE for which longer blocks are not tried [1]; NaN: the
 * numbers from GALLOP_HISTORY_BLOCKS on are not computed
 * @param work       Scratch memory of gallop_history_size(samples) bytes
 * @param numbers    Output, (histories, GALLOP_HISTORY_NUMBERS)
 * @return           GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_history_numbers(int64_t samples, int32_t histories, const double *values,
                                      double even, void *work, double *numbers);

/* Share of the variance of the envelope of single cycles that a spectral line and its double
 * explain, corrected for the number of unknowns.  The line is between one and a half beats in the
 * window and a third of the number of cycles.
 *
 * @param samples  Number of samples
 * @param values   (samples): a history for which gallop_history_numbers found blocks
 * @param numbers  (GALLOP_HISTORY_NUMBERS): what it found
 * @param work     Scratch memory of gallop_history_size(samples) bytes
 * @param share    Output [1]; 0 for fewer than seven cycles
 * @return         GALLOP_COMPLETED; GALLOP_BAD_CALL, also for a history without blocks
 */
GALLOP_API int gallop_history_beats(int64_t samples, const double *values, const double *numbers,
                                    void *work, double *share);

/* The numbers of several histories up to GALLOP_HISTORY_DEVIATION; NaN if a value is NaN.
 *
 * @param samples    Number of samples of each history, 1 or more
 * @param histories  Number of histories, 1 or more
 * @param values     (histories, samples)
 * @param sizes      Output, (histories, GALLOP_HISTORY_DEVIATION + 1)
 * @return           GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_history_sizes(int64_t samples, int32_t histories, const double *values,
                                    double *sizes);

/* The highest line of spectra above which, itself included, a share of the kinetic energy lies: of
 * the sum of the squares of all lines times the squares of their numbers.
 *
 * @param lines    Number of lines, 1 or more
 * @param spectra  Number of spectra of displacements, 1 or more
 * @param values   (spectra, lines, 2): real and imaginary parts
 * @param share    Share of the energy [1]
 * @return         Number of the line, from 0; -1 for a bad call
 */
GALLOP_API int64_t gallop_history_energy_line(int64_t lines, int32_t spectra, const double *values,
                                              double share);

/* Numbers of an ellipse in a plane with axes x and y. */
typedef enum {
    GALLOP_ELLIPSE_X, /* centre */
    GALLOP_ELLIPSE_Y,
    GALLOP_ELLIPSE_HALF_MAJOR,
    GALLOP_ELLIPSE_HALF_MINOR, /* not longer than the other */
    GALLOP_ELLIPSE_COSINE,     /* of the angle of the major axis to y, towards -x */
    GALLOP_ELLIPSE_SINE,
    GALLOP_ELLIPSE_NUMBERS
} gallop_ellipse_number;

/* Distances of the points of a path from an ellipse, negative inside.
 *
 * @param count     Number of points
 * @param x, y      (count): coordinates [m]
 * @param ellipse   (GALLOP_ELLIPSE_NUMBERS): lengths [m]
 * @param distance  Output, (count) [m]
 * @return          GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_history_distances(int64_t count, const double *x, const double *y,
                                        const double ellipse[GALLOP_ELLIPSE_NUMBERS],
                                        double *distance);

#ifdef __cplusplus
}
#endif

#endif
