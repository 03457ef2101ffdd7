/* Direct solver of the tangent equations of all chains and devices. */
#ifndef GALLOP_SOLVER_H
#define GALLOP_SOLVER_H

#include "element.h"

/* Decides whether junctions are coupled, and how much room the factors need. */
void solver_measure(gallop_model *model);

/* Which junctions can move: as the scene says, or none (statics of the single spans). */
typedef enum { SOLVER_JUNCTIONS_AS_IN_SCENE, SOLVER_JUNCTIONS_FIXED } solver_junctions;

/* Parts of a number. */
enum { SOLVER_REAL = 1, SOLVER_COMPLEX = 2 };

/* Equations of all chains and devices, real or complex. */
typedef struct {
    int parts;
    /* a tangent weights.k dR/du + weights.c dR/dv + weights.m dR/da that is factored first, into
     * the state; the sections of the view hold the section forces, with slopes, of the motion y: */
    const conditions *now;
    motion y;
    const tangent_weights *weights; /* (parts), NULL: the factors of the state are used */
    double *rhs; /* (nodes, 4 parts) becomes the solution; entries of fixed unknowns become zero;
                    NULL: factors only */
} solver_equations;

/* What a caller does with each half of a line: `before` computes its right-hand sides, and section
 * forces; `after` takes the solution, after a failure perhaps of one half only. */
typedef struct {
    team_work *before, *after;
    void *task;
} solver_frame;

/* Factors and solves; `frame` may be NULL.  False: a tangent is not positive definite. */
bool solver_run(const gallop_model *model, const state_view *view, solver_junctions junctions,
                const solver_equations *equations, int count, const solver_frame *frame);

/* One real tangent; one right-hand side (nodes, 4). */
bool solver_factor(const gallop_model *model, const conditions *now, const state_view *view,
                   motion y, tangent_weights weights, solver_junctions junctions);
void solver_solve(const gallop_model *model, const state_view *view, solver_junctions junctions,
                  double *rhs);

/* ---- One chain (solver_real.c, solver_complex.c).  Its nodes have four values in a right-hand
 * side, or four real parts before four imaginary ones; complex weights and tangents have two parts
 * where real ones have one. ---- */

/* What acts at the ends of a chain, if it is coupled to nothing that moves. */
typedef struct {
    bool fixed[2][4];
    double tangent[2][2][16]; /* [end][real, imaginary part], by rows */
} chain_ends;

typedef struct {
    int elements, unknowns; /* unknowns: leading ones of a node that are solved for, 4 or 2 */
    bool fused;             /* see PATHS */
    int strips;
    const int *strip_start;  /* (strips + 1) first element of each strip, then `elements` */
    int kept_corners;        /* of a chain that is coupled to others, both ends included: */
    const kept_corner *kept; /* the corners that it leaves to the caller; NULL: none */
    const chain_ends *ends;  /* of a chain with none */
    /* fills in the blocks of a strip's tangent, of `unknowns` rows and columns each, by rows */
    void (*blocks)(const void *source, int index, tangent_weights weights, lanes block[6][16]);
    const void *source;
} solver_chain;

/* Room [doubles] of a factored chain, times the parts of a number. */
static inline size_t solver_room(int elements, int strips, int segments, bool kept)
{
    const size_t corners = (size_t)elements + (size_t)segments;
    return 48 * LANES * (size_t)strips + (kept ? 80 : 48) * corners;
}

/* Factors a chain into its store.  False: the tangent is not positive definite. */
bool solver_real_factor(const solver_chain *c, const tangent_weights *weights, double *store);
bool solver_complex_factor(const solver_chain *c, const tangent_weights *weights, double *store);

/* rhs (nodes) becomes the solution; entries of fixed unknowns become zero. */
void solver_real_solve(const solver_chain *c, const double *store, double *rhs);
void solver_complex_solve(const solver_chain *c, const double *store, double *rhs);

/* Factors a chain with kept corners, which are coupled to others: eliminates all other nodes. */
bool solver_real_reduce(const solver_chain *c, const tangent_weights *weights, double *store);
bool solver_complex_reduce(const solver_chain *c, const tangent_weights *weights, double *store);

/* What the part between kept corners `index` and `index` + 1 of such a chain adds to the tangent of
 * those two nodes: ends[part][row's end][column's end][row][column]. */
void solver_real_ends(const solver_chain *c, const double *store, int index,
                      double ends[1][2][2][4][4]);
void solver_complex_ends(const solver_chain *c, const double *store, int index,
                         double ends[2][2][2][4][4]);

/* Of such a chain: takes the right-hand side to its kept corners, where it is added to that of the
 * others; and, with the solution of the kept corners in their places of rhs, finds the rest. */
void solver_real_to_ends(const solver_chain *c, const double *store, double *rhs);
void solver_complex_to_ends(const solver_chain *c, const double *store, double *rhs);
void solver_real_from_ends(const solver_chain *c, const double *store, double *rhs);
void solver_complex_from_ends(const solver_chain *c, const double *store, double *rhs);

/* ---- The system of the junctions (solver_junctions.h). ---- */

/* Junctions farther apart than `reach` in their order are not coupled. */
typedef struct {
    int count, reach, unknowns;
    bool fused;
    double *store;
} solver_junction_system;

/* Room [doubles] of its matrix, times the parts of a number. */
static inline size_t solver_junction_room(int count, int reach)
{
    return 16 * (size_t)count * (2 * (size_t)reach + 1);
}

/* The matrix becomes zero. */
void solver_real_junctions_clear(const solver_junction_system *s);
void solver_complex_junctions_clear(const solver_junction_system *s);

/* Adds a block, by rows, to one part of the matrix. */
void solver_real_junctions_add(const solver_junction_system *s, int row, int column, int part,
                               const double values[16]);
void solver_complex_junctions_add(const solver_junction_system *s, int row, int column, int part,
                                  const double values[16]);

/* The row of an unknown says that it is zero. */
void solver_real_junctions_fix(const solver_junction_system *s, int row, int unknown);
void solver_complex_junctions_fix(const solver_junction_system *s, int row, int unknown);

/* Factors the matrix.  False: it is not positive definite. */
bool solver_real_junctions_factor(const solver_junction_system *s, const tangent_weights *weights);
bool solver_complex_junctions_factor(const solver_junction_system *s,
                                     const tangent_weights *weights);

/* The right-hand sides (junctions, 4), or (junctions, 8), become the solution. */
void solver_real_junctions_solve(const solver_junction_system *s, double *x);
void solver_complex_junctions_solve(const solver_junction_system *s, double *x);

#endif
